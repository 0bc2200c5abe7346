#!/usr/bin/env bash
# The linker of what runs in browsers. The compiler asks it to export every C function of every crate, and with it all that these call: the functions of FMI, and
# those that a generator of bindings would read. A page calls functions of tools/front and tools/web alone; without the others the modules are a tenth smaller.
set -euo pipefail

kept=()
while [ $# -gt 0 ]; do
    case $1 in
        --export)
            case $2 in front_* | cotree_*) kept+=("$1" "$2") ;; esac
            shift
            ;;
        -flavor) shift ;;
        *) kept+=("$1") ;;
    esac
    shift
done

exec "$(dirname "$0")/lld.sh" -flavor wasm "${kept[@]}"
