#!/usr/bin/env bash
# Builds what a release consists of, on one machine, and publishes nothing: for each platform an archive with the program `cotree`, the runtimes of all
# platforms, so that `cotree export` writes FMUs for all of them, models, manual pages, completions, the changelog, and licences; Python wheels for Linux; the source archive for pip; the crates, in
# the order in which they depend on each other; and SHA256SUMS. Says in the end what each file holds.
#
# usage: tools/release.sh [-o FOLDER] [PART...]     default: -o target/release-files linux64 aarch64-linux win64 wheels sdist crates
#
# Needs what tools/build-runtimes.sh needs, sdist and crates but Rust and PyPI; tools/test-release.sh tries the result.
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

# Manual pages and completions, the same on all platforms: the program of this machine writes them.
manual() {
    local program=$work/$(triple linux64)/release/cotree shell
    [ -x "$program" ] || COTREE_RUNTIME=$(runtime linux64) build_for linux64 Cargo.toml --bin cotree
    "$program" man "$1/man" >&2
    mkdir -p "$1/completions"
    for shell in bash elvish fish powershell zsh; do "$program" completions $shell >"$1/completions/cotree.$shell"; done
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
    cp "$built" README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$folder/$content/"
    manual "$folder/$content"
    cp -r "$runtimes" "$folder/$content/runtimes"
    cp -r models "$folder/$content/models"
    licences "$platform" "$folder/$content/licences"
    pack "$platform" "$content"
}

install_maturin() {
    [ -x "$work/maturin/bin/maturin" ] && return
    python3 -m venv --clear "$work/maturin"
    "$work/maturin/bin/pip" install --quiet --disable-pip-version-check "${MATURIN[@]}"
}

# For Python on Linux, whatever its C library; wheels for other systems are built there.
wheels() {
    install_maturin
    # The package brings the solver of its pages along.
    rm -rf python/cotree/runtimes
    mkdir -p python/cotree/runtimes
    cp -r "$runtimes/web" python/cotree/runtimes/web
    local platform
    for platform in linux64 aarch64-linux; do
        say "wheel, $platform"
        rm -rf python/cotree/licences
        licences "$platform" python/cotree/licences
        COTREE_RUNTIME=$(runtime "$platform") CARGO_TARGET_DIR=$work PATH=$work/maturin/bin:$PATH \
            maturin build --quiet --release --strip --zig --target "$(triple "$platform")" --compatibility "manylinux_${GLIBC/./_}" --out "$folder"
    done
    rm -r python/cotree/runtimes python/cotree/licences
}

# What pip builds a wheel from where there is none.
sdist() {
    say sdist
    install_maturin
    "$work/maturin/bin/maturin" sdist --out "$folder" >&2
}

# The crates as crates.io gets them; `cargo publish` uploads them in the order of their dependencies. .ci/nightly builds each from its archive.
crates() {
    say crates
    local names
    names=$(cargo metadata --no-deps --format-version 1 | python3 -c '
import json, sys
print("\n".join(own["name"] for own in json.load(sys.stdin)["packages"] if own["publish"] is None))')
    # shellcheck disable=SC2046
    cargo package --quiet --allow-dirty --no-verify --locked --target-dir "$work" $(printf -- '-p %s ' $names)
    local name
    for name in $names; do cp "$work/package/$name-$version.crate" "$folder/"; done
}

# Each file, its size, and the names on top of what it holds.
contents() {
    python3 - "$folder" <<'END'
import pathlib, sys, tarfile, zipfile
for path in sorted(pathlib.Path(sys.argv[1]).iterdir()):
    if path.suffix in (".zip", ".whl"):
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    elif path.suffix in (".gz", ".crate"):
        with tarfile.open(path) as archive:
            names = [own.name for own in archive if own.isfile()]
    else:
        continue
    inside = [name if path.suffix == ".whl" else name.partition("/")[2] for name in names]
    top = dict.fromkeys(name.split("/")[0] + ("/" if "/" in name else "") for name in inside)
    print(f"{path.name}  {path.stat().st_size / 1e6:.1f} MB, {len(names)} files: {', '.join(top)}")
END
}

if [ "${1-}" = -o ]; then
    folder=${2:?-o needs a folder}
    shift 2
fi
[ $# -gt 0 ] || set -- linux64 aarch64-linux win64 wheels sdist crates
mkdir -p "$folder"
rm -rf "$folder"/cotree* "$folder/SHA256SUMS"
# Archives hold the runtimes of all platforms, and wheels that for browsers.
case " $* " in *64* | *wheels*) tools/build-runtimes.sh -o "$runtimes" linux64 aarch64-linux win64 darwin64 aarch64-darwin web ;; esac
for part; do
    case $part in
        wheels | sdist | crates) "$part" ;;
        *) build "$part" ;;
    esac
done
contents
(cd "$folder" && sha256sum -- cotree* >SHA256SUMS)
say "done: $folder"
