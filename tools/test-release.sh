#!/usr/bin/env bash
# Tries what tools/release.sh has built: the checksums; each program, under qemu-user and wine where it is for another platform, writes an FMU for all
# platforms, and all write the same bytes; in a new Debian with nothing but Python, the program exports and fmpy runs the FMU.
#
# usage: tools/test-release.sh [FOLDER]        default: target/release-files, made by tools/release.sh
#
# Needs root, debootstrap, qemu-user, wine, mingw-w64, libc6-arm64-cross, and PyPI for fmpy.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=$(realpath "${1-target/release-files}")
work=$PWD/target/release-test
export WINEDEBUG=-all WINEPREFIX=$work/wine
model=slider_crank

say() { printf '== %s\n' "$*"; }
fail() { printf 'error: %s\n' "$*" >&2; exit 1; }

run() {
    local platform=$1
    shift
    case $platform in
        linux-x86_64) "$@" ;;
        linux-aarch64) qemu-aarch64 -L /usr/aarch64-linux-gnu "$@" ;;
        windows-x86_64) "$(command -v wine || command -v wine64 || echo /usr/lib/wine/wine64)" "$@" ;;
        *) fail "no way to run a program for '$platform'" ;;
    esac
}

say checksums
(cd "$folder" && sha256sum --quiet --check SHA256SUMS)

rm -rf "$work/unpacked"
mkdir -p "$work/unpacked"
for archive in "$folder"/cotree-*-linux-*.tar.gz "$folder"/cotree-*-windows-*.zip; do
    case $archive in
        *.tar.gz) tar -xzf "$archive" -C "$work/unpacked" ;;
        *.zip) python3 -m zipfile -e "$archive" "$work/unpacked" ;;
    esac
done

first=
for place in "$work"/unpacked/*/; do
    release=$(basename "$place")
    platform=$(echo "$release" | cut -d- -f3-)
    say "$release"
    program=$place/cotree
    if [ "$platform" = windows-x86_64 ]; then
        program+=.exe
        # Not every wine has this library; see docs/platforms.md.
        x86_64-w64-mingw32-gcc -O1 -Wall -shared -o "$place/bcryptprimitives.dll" tests/platforms/prng.c -ladvapi32
    fi
    (cd "$place" && run "$platform" "$program" export "models/$model/scene.toml" -o "$model.fmu" && run "$platform" "$program" --version)
    for file in CHANGELOG.md man/cotree-simulate.1 completions/cotree.bash licences/LIST.txt; do
        [ -s "$place/$file" ] || fail "$release has no $file"
    done
    listed=$(python3 -m zipfile -l "$place/$model.fmu")
    for library in linux64/$model.so aarch64-linux/$model.so win64/$model.dll darwin64/$model.dylib aarch64-darwin/$model.dylib; do
        [[ $listed == *binaries/$library* ]] || fail "$release: the FMU has no binaries/$library"
    done
    # Nothing runs the one for Macs here: its headers are looked at.
    python3 -m zipfile -e "$place/$model.fmu" "$work/fmu"
    python3 tools/mach_o.py "$work/fmu/binaries/darwin64/$model.dylib" 11.0 x86_64 arm64
    first=${first:-$place}
    cmp "$first/$model.fmu" "$place/$model.fmu" || fail "$release writes another FMU"
done
[ -n "$first" ] || fail "there is no program in $folder"

say "a new Debian"
root=$work/debian
[ -x "$root/usr/bin/python3" ] || debootstrap --variant=minbase --include=python3 bookworm "$root" >"$work/debootstrap.log"
inside() { env -i PATH=/usr/bin:/bin PYTHONPATH=/opt/packages HOME=/tmp /usr/sbin/chroot "$root" "$@"; }
rm -rf "${root:?}/opt/"*
python3 -m pip install --quiet --disable-pip-version-check --target "$root/opt/packages" --python-version 3.11 --only-binary :all: -r tests/fmpy/requirements.txt
cp tests/fmpy/run.py "$root/opt/"
tar -xzf "$folder"/cotree-*-linux-x86_64.tar.gz -C "$root/opt"
inside sh -c "cd /opt/cotree-* && ./cotree check models/$model/scene.toml && ./cotree export models/$model/scene.toml -o /opt/$model.fmu"
inside sh -c "cd /opt/cotree-* && ./cotree view models/$model/scene.toml -o /opt/page.html"
! grep -q 'id="solver"></script>' "$root/opt/page.html" || fail "the page has no solver"
cmp "$first/$model.fmu" "$root/opt/$model.fmu"
inside python3 /opt/run.py "/opt/$model.fmu"
say "the wheel"
wheel=$(find "$folder" -name 'cotree-*manylinux*x86_64.whl')
[ -n "$wheel" ] || fail "there is no wheel in $folder"
python3 -m zipfile -e "$wheel" "$root/opt/packages"
[ -s "$root/opt/packages/cotree/licences/LIST.txt" ] || fail "the wheel has no licences of what is linked into it"
inside python3 -c "
import cotree, glob
model = cotree.load(glob.glob('/opt/cotree-*/models/$model/scene.toml')[0])
print(model.simulate(stop='1 s')['energy.total'][-1], 'J after 1 s')
assert 'id=\"solver\"></script>' not in model.page(), 'the package has no solver for its pages'
model.export('/opt/python.fmu')"
inside python3 /opt/run.py /opt/python.fmu
say "all is well"
