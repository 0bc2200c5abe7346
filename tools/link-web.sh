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
        # Said by its name where it is called by that.
        -flavor) shift ;;
        *) kept+=("$1") ;;
    esac
    shift
done

rustc=${RUSTC:-rustc}
own=$("$rustc" --print sysroot)/lib/rustlib/$("$rustc" -vV | sed -n 's/^host: //p')/bin/rust-lld
if [ -x "$own" ]; then exec "$own" -flavor wasm "${kept[@]}"; fi
for linker in wasm-ld wasm-ld-19; do
    if command -v "$linker" >/dev/null; then exec "$linker" "${kept[@]}"; fi
done
echo "error: there is no linker for WebAssembly (rust-lld of the toolchain, or the package lld-19)" >&2
exit 1
