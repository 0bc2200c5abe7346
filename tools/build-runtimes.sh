#!/usr/bin/env bash
# Builds the runtimes that `cotree export --platform` packs, <folder>/<platform>/cotree_runtime.{so,dll,dylib}, and the one that
# `cotree view` puts into its pages, <folder>/web/cotree_runtime.wasm, with what `cotree draw` needs beside it, <folder>/web/cotree_front.wasm.
#
# usage: tools/build-runtimes.sh [-o FOLDER] [PLATFORM...]     default: -o target/runtimes linux64 aarch64-linux win64 darwin64 aarch64-darwin web
#
# Needs Rust, and but for web Python 3 and PyPI (zig, as a linker that knows old C libraries, and for its list of the functions of macOS); for win64 also
# mingw-w64; for Macs and web, if the toolchain is Debian's, also lld-19.
# Rust's standard library for a platform comes from `rustup target add`, or is built from its sources: those of the
# toolchain (`rustup component add rust-src`) or Debian's (packages rustc-web, cargo-web, rust-web-src). See docs/platforms.md.
set -euo pipefail
cd "$(dirname "$0")/.."

. tools/cross.sh

folder=target/runtimes

built_file() { case $1 in win64) echo cotree_runtime.dll ;; darwin64 | aarch64-darwin) echo libcotree_runtime.dylib ;; web) echo cotree_web.wasm ;; *) echo libcotree_runtime.so ;; esac; }
file() { case $1 in win64) echo cotree_runtime.dll ;; darwin64 | aarch64-darwin) echo cotree_runtime.dylib ;; web) echo cotree_runtime.wasm ;; *) echo cotree_runtime.so ;; esac; }

# The way from a scene to its FMU. It goes into one page, whose size counts more than its speed; bits do not depend on that.
build_front() {
    say "web, front"
    local options=(--config 'profile.release.panic="abort"' --config 'profile.release.lto=true' --config 'profile.release.codegen-units=1') small
    options+=(--config 'profile.release.opt-level="z"')
    for small in cotree-fmu cotree-runtime cotree-synthesis libm matrixmultiply nalgebra wide zlib-rs; do
        options+=(--config "profile.release.package.$small.opt-level=\"z\"")
    done
    build_for web tools/front/Cargo.toml "${options[@]}"
    cp "$work/$(triple web)/release/cotree_front.wasm" "$folder/web/cotree_front.wasm"
}

build() {
    local platform=$1 package=runtime options=()
    say "$platform"
    if [ "$platform" = web ]; then
        # A browser cannot unwind.
        package=web options=(--config 'profile.release.panic="abort"')
    fi
    build_for "$platform" "tools/$package/Cargo.toml" "${options[@]}"
    mkdir -p "$folder/$platform"
    cp "$work/$(triple "$platform")/release/$(built_file "$platform")" "$folder/$platform/$(file "$platform")"
    case $platform in
        *linux*) check_glibc "$folder/$platform/$(file "$platform")" ;;
        *darwin*) check_macos "$folder/$platform/$(file "$platform")" "$platform" ;;
        web) build_front ;;
    esac
}

if [ "${1-}" = -o ]; then
    folder=${2:?-o needs a folder}
    shift 2
fi
[ $# -gt 0 ] || set -- linux64 aarch64-linux win64 darwin64 aarch64-darwin web
for platform; do build "$platform"; done
say "done: $folder"
