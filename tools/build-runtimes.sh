#!/usr/bin/env bash
# Builds the runtimes that `cotree export --platform` packs, <folder>/<platform>/cotree_runtime.{so,dll}, and the one that
# `cotree view` puts into its pages, <folder>/web/cotree_runtime.wasm.
#
# usage: tools/build-runtimes.sh [-o FOLDER] [PLATFORM...]     default: -o target/runtimes linux64 aarch64-linux win64 web
#
# Needs Rust, and but for web Python 3 and PyPI (zig, as a linker that knows old C libraries); for win64 also mingw-w64;
# for web, if the toolchain is Debian's, also lld-19.
# Rust's standard library for a platform comes from `rustup target add`, or is built from its sources: those of the
# toolchain (`rustup component add rust-src`) or Debian's (packages rustc-web, cargo-web, rust-web-src). See docs/platforms.md.
set -euo pipefail
cd "$(dirname "$0")/.."

GLIBC=2.28 # of Debian 10 and RHEL 8
ZIG=(cargo-zigbuild==0.24.0 ziglang==0.17.0)

folder=target/runtimes
work=$PWD/target/runtimes-build
zig=$work/zig

say() { printf '== %s\n' "$*" >&2; }
fail() { printf 'error: %s\n' "$*" >&2; exit 1; }

# Rust's and the file's names for a platform.
triple() {
    case $1 in
        linux64) echo x86_64-unknown-linux-gnu ;;
        aarch64-linux) echo aarch64-unknown-linux-gnu ;;
        win64) echo x86_64-pc-windows-gnu ;;
        web) echo wasm32-unknown-unknown ;;
        *) fail "no recipe for platform '$1' (there are linux64, aarch64-linux, win64, web)" ;;
    esac
}
built_file() { case $1 in win64) echo cotree_runtime.dll ;; web) echo cotree_page.wasm ;; *) echo libcotree_runtime.so ;; esac; }
file() { case $1 in win64) echo cotree_runtime.dll ;; web) echo cotree_runtime.wasm ;; *) echo cotree_runtime.so ;; esac; }

# Picks the toolchain: sets CARGO and RUSTC, and `std` to what cargo needs to have a standard library for the triple.
choose_toolchain() {
    local rustc
    for rustc in rustc /usr/bin/rustc; do
        command -v "$rustc" >/dev/null || continue
        local cargo=${rustc%rustc}cargo sources
        sources=$("$rustc" --print sysroot)/lib/rustlib/src/rust/library
        if [ -d "$("$rustc" --print target-libdir --target "$1")" ]; then
            std=()
        elif [ -d "$sources" ]; then
            std=(-Z "build-std=std,$([ "$1" = wasm32-unknown-unknown ] && echo panic_abort || echo panic_unwind)")
            export RUSTC_BOOTSTRAP=1 # `-Z build-std` is not stable
        else
            continue
        fi
        CARGO=$(command -v "$cargo") RUSTC=$(command -v "$rustc")
        export CARGO RUSTC
        return
    done
    fail "Rust's standard library for $1 is missing: run 'rustup target add $1', or install its sources (see docs/platforms.md)"
}

install_zig() {
    [ -x "$zig/bin/cargo-zigbuild" ] && return
    say "zig"
    python3 -m venv --clear "$zig"
    "$zig/bin/pip" install --quiet --disable-pip-version-check "${ZIG[@]}"
}

# The newest C library that a shared library asks for must not be newer than $GLIBC.
check_glibc() {
    local newest
    newest=$(objdump -T "$1" 2>/dev/null || "$zig/bin/python" -m ziglang objdump -T "$1")
    newest=$(printf '%s\n' "$newest" | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -n 1)
    [ "$(printf '%s\n' "$newest" "GLIBC_$GLIBC" | sort -V | tail -n 1)" = "GLIBC_$GLIBC" ] ||
        fail "$1 needs $newest"
    say "needs at most $newest"
}

build() {
    local platform=$1 target std=()
    target=$(triple "$platform")
    say "$platform"
    (
        choose_toolchain "$target"
        local package=runtime
        [ "$platform" != web ] || package=page
        options=(--release --manifest-path "tools/$package/Cargo.toml" --target-dir "$work" "${std[@]}")
        # Paths of this machine are nobody's business, and the same source gives the same bytes anywhere.
        export RUSTFLAGS="--remap-path-prefix=$PWD=cotree --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"
        if [ "$platform" = win64 ] || [ "$platform" = web ]; then
            # A browser cannot unwind, and what is not needed is not sent.
            [ "$platform" = win64 ] || options+=(--config 'profile.release.panic="abort"' --config 'profile.release.strip=true')
            "$CARGO" build "${options[@]}" --target "$target"
        else
            install_zig
            PATH=$zig/bin:$PATH "$zig/bin/cargo-zigbuild" zigbuild "${options[@]}" --target "$target.$GLIBC"
        fi
    )
    mkdir -p "$folder/$platform"
    cp "$work/$target/release/$(built_file "$platform")" "$folder/$platform/$(file "$platform")"
    [ "$platform" = win64 ] || [ "$platform" = web ] || check_glibc "$folder/$platform/$(file "$platform")"
}

if [ "${1-}" = -o ]; then
    folder=${2:?-o needs a folder}
    shift 2
fi
[ $# -gt 0 ] || set -- linux64 aarch64-linux win64 web
for platform; do build "$platform"; done
say "done: $folder"
