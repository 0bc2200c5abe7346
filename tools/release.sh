#!/usr/bin/env bash
# Builds what a release consists of, on one machine: for each platform an archive with the program `cotree`, the runtimes of all platforms, so that
# `cotree export` writes FMUs for all of them, models, and licences; the Python wheel for Linux; and SHA256SUMS.
#
# usage: tools/release.sh [-o FOLDER] [PLATFORM...]     default: -o target/release-files linux64 aarch64-linux win64
#
# Needs what tools/build-runtimes.sh needs; tools/test-release.sh tries the result.
set -euo pipefail
cd "$(dirname "$0")/.."

. tools/cross.sh

MATURIN=(maturin==1.9.6 ziglang==0.17.0)

folder=target/release-files
runtimes=$PWD/target/runtimes

version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
# The date of the files in the archives: the same commit gives the same bytes.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}
export SOURCE_DATE_EPOCH

# Users' names for a platform, and what its program and its runtime are called.
name() { case $1 in linux64) echo linux-x86_64 ;; aarch64-linux) echo linux-aarch64 ;; win64) echo windows-x86_64 ;; *) fail "no release for '$1'" ;; esac; }
program() { [ "$1" = win64 ] && echo cotree.exe || echo cotree; }
runtime() { echo "$runtimes/$1/cotree_runtime.$([ "$1" = win64 ] && echo dll || echo so)"; }

# The licences of everything that is linked into the program, a folder for each crate.
licences() {
    cargo metadata --format-version 1 --filter-platform "$(triple "$1")" | python3 tools/licences.py "$2"
}

# The folder becomes one file, whose bytes depend on its content only.
pack() {
    local platform=$1 content=$2
    find "$folder/$content" -exec touch --no-dereference --date="@$SOURCE_DATE_EPOCH" {} +
    if [ "$platform" = win64 ]; then
        rm -f "$folder/$content.zip"
        (cd "$folder" && find "$content" -type f | sort | TZ=UTC python3 -c '
import sys, zipfile
with zipfile.ZipFile(sys.argv[1], "w", zipfile.ZIP_DEFLATED) as archive:
    for line in sys.stdin:
        archive.write(line.rstrip("\n"))' "$content.zip")
    else
        tar --create --directory "$folder" --sort=name --owner=0 --group=0 --numeric-owner --mode=u+rw,go-w "$content" | gzip -n9 >"$folder/$content.tar.gz"
    fi
    rm -r "${folder:?}/$content"
}

build() {
    local platform=$1 content built
    content=cotree-$version-$(name "$platform")
    say "$content"
    COTREE_RUNTIME=$(runtime "$platform") build_for "$platform" Cargo.toml --bin cotree
    built=$work/$(triple "$platform")/release/$(program "$platform")
    [ "$platform" = win64 ] || check_glibc "$built"
    rm -rf "${folder:?}/$content"
    mkdir -p "$folder/$content"
    cp "$built" README.md LICENSE-MIT LICENSE-APACHE "$folder/$content/"
    cp -r "$runtimes" "$folder/$content/runtimes"
    cp -r models "$folder/$content/models"
    licences "$platform" "$folder/$content/licences"
    pack "$platform" "$content"
}

# For Python on Linux; other systems build theirs from the source (docs/python.md).
wheel() {
    say wheel
    # The package brings the solver of its pages along.
    rm -rf python/cotree/runtimes
    mkdir -p python/cotree/runtimes
    cp -r "$runtimes/web" python/cotree/runtimes/web
    python3 -m venv --clear "$work/maturin"
    "$work/maturin/bin/pip" install --quiet --disable-pip-version-check "${MATURIN[@]}"
    COTREE_RUNTIME=$(runtime linux64) CARGO_TARGET_DIR=$work PATH=$work/maturin/bin:$PATH \
        maturin build --quiet --release --strip --zig --target "$(triple linux64)" --compatibility "manylinux_${GLIBC/./_}" --out "$folder"
    rm -r python/cotree/runtimes
}

if [ "${1-}" = -o ]; then
    folder=${2:?-o needs a folder}
    shift 2
fi
[ $# -gt 0 ] || set -- linux64 aarch64-linux win64
mkdir -p "$folder"
rm -rf "$folder"/cotree* "$folder/SHA256SUMS"
tools/build-runtimes.sh -o "$runtimes" linux64 aarch64-linux win64 web
for platform; do build "$platform"; done
wheel
(cd "$folder" && sha256sum -- cotree* >SHA256SUMS)
say "done: $folder"
