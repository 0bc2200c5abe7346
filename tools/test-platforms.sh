#!/usr/bin/env bash
# Runs every model's FMU on every platform that there is a runtime for, but for Macs and browsers, and compares all results bit by bit with linux64; also with
# linux64 on a processor without AVX2.
#
# usage: tools/test-platforms.sh [RUNTIMES [MODEL...]]        default: target/runtimes, made by tools/build-runtimes.sh, and all models
#
# COTREE names the program that exports; without it the development build does. Needs gcc, Python 3 and qemu-user; for win64 mingw-w64 and wine, for aarch64-linux its cross compiler.
set -euo pipefail
cd "$(dirname "$0")/.."

STEPS=200
OLD=linux64-sse2 # linux64 on
OLD_CPU=Nehalem  # of 2008
runtimes=$(realpath "${1-target/runtimes}")
work=$PWD/target/platforms
export WINEDEBUG=-all WINEPREFIX=$work/wine

folder() { case $1 in "$OLD") echo linux64 ;; *) echo "$1" ;; esac; }
fail() { printf 'error: %s\n' "$*" >&2; exit 1; }

# The compiler for a platform, and what runs its programs.
compiler() {
    case $1 in
        linux64 | "$OLD") echo gcc ;;
        aarch64-linux) echo aarch64-linux-gnu-gcc ;;
        win64) echo x86_64-w64-mingw32-gcc ;;
        *) fail "no test for platform '$1'" ;;
    esac
}
run() {
    local platform=$1
    shift
    case $platform in
        linux64) "$@" ;;
        "$OLD") qemu-x86_64 -cpu "$OLD_CPU" "$@" ;;
        aarch64-linux) qemu-aarch64 -L /usr/aarch64-linux-gnu "$@" ;;
        win64) "$(command -v wine || command -v wine64 || echo /usr/lib/wine/wine64)" "$@" | tr -d '\r' ;;
    esac
}

# The path as the platform has it, and as the URI of a folder.
path() { case $1 in win64) printf 'Z:%s' "${2//\//\\}" ;; *) printf '%s' "$2" ;; esac; }
uri() { case $1 in win64) printf 'file:///Z:%s' "$2" ;; *) printf 'file://%s' "$2" ;; esac; }

mkdir -p "$work"
[ ! -d "$runtimes/win64" ] ||
    x86_64-w64-mingw32-gcc -O1 -Wall -shared -o "$work/bcryptprimitives.dll" tests/platforms/prng.c -ladvapi32
program=${COTREE-target/debug/cotree}
[ -n "${COTREE-}" ] || cargo build --quiet
platforms=(linux64)
for folder in "$runtimes"/*/; do
    platform=$(basename "$folder")
    case $platform in
        linux64 | web) ;;
        *darwin*) echo "$platform: nothing here runs its programs" ;;
        *) platforms+=("$platform") ;;
    esac
done
[ ${#platforms[@]} -gt 1 ] || fail "$runtimes has no other platform: run tools/build-runtimes.sh first"
exported=$(IFS=,; echo "${platforms[*]}")
platforms+=("$OLD")
grep -q avx2 /proc/cpuinfo || fail "this processor has no AVX2, so there is nothing to compare $OLD with"
for platform in "${platforms[@]}"; do
    "$(compiler "$platform")" -std=c99 -O1 -Wall -o "$work/run-$platform" tests/platforms/run.c $([ "$platform" = win64 ] || echo -ldl)
done

differ=0
scenes=(models/*/scene.toml tests/scenes/stiff.toml)
if [ $# -gt 1 ]; then
    shift
    scenes=("${@/#/models/}")
    scenes=("${scenes[@]/%//scene.toml}")
fi
for scene in "${scenes[@]}"; do
    model=$(basename "${scene%/scene.toml}" .toml)
    fmu=$work/$model.fmu
    "$program" export "$scene" -o "$fmu" --runtimes "$runtimes" --platform "$exported" >/dev/null
    rm -rf "${work:?}/$model"
    python3 -m zipfile -e "$fmu" "$work/$model"
    read -r guid step stop identifier variables < <(python3 - "$work/$model/modelDescription.xml" <<'PYTHON'
import sys
from xml.etree import ElementTree
root = ElementTree.parse(sys.argv[1]).getroot()
experiment = root.find("DefaultExperiment")
print(root.get("guid"), experiment.get("stepSize"), experiment.get("stopTime"), root.find("CoSimulation").get("modelIdentifier"), len(root.find("ModelVariables")))
PYTHON
    )
    steps=$(python3 -c "print(min($STEPS, round($stop / $step)))")
    for platform in "${platforms[@]}"; do
        library=$(echo "$work/$model/binaries/$(folder "$platform")/$identifier".*)
        run "$platform" "$work/run-$platform$([ "$platform" != win64 ] || echo .exe)" "$(path "$platform" "$library")" "$(uri "$platform" "$work/$model/resources")" \
            "$guid" "$variables" "$step" "$steps" >"$work/$model-$platform.txt" || fail "$model does not run on $platform"
        if cmp -s "$work/$model-linux64.txt" "$work/$model-$platform.txt"; then
            printf '%-20s %-14s same bits (%d variables, %d steps)\n' "$model" "$platform" "$variables" "$steps"
        else
            printf '%-20s %-14s DIFFERENT\n' "$model" "$platform"
            differ=1
        fi
    done
done
exit "$differ"
