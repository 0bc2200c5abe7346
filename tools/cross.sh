# How cotree's shell scripts build for another platform: sourced, not run.
# Sets $work, where everything is built; whoever sources it has changed into the root of the project.

GLIBC=2.28 # of Debian 10 and RHEL 8
MACOS=11.0 # the first for both processors
ZIG=(cargo-zigbuild==0.24.0 ziglang==0.17.0)

work=$PWD/target/runtimes-build
zig=$work/zig
macos=$work/MacOSX.sdk

# Names of functions are of no use to anybody but us.
STRIP='profile.release.strip="symbols"'
# Paths of this machine are nobody's business, and the same source gives the same bytes anywhere.
export RUSTFLAGS="--remap-path-prefix=$PWD=cotree --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"

say() { printf '== %s\n' "$*" >&2; }
fail() { printf 'error: %s\n' "$*" >&2; exit 1; }

# Rust's name for a platform.
triple() {
    case $1 in
        linux64) echo x86_64-unknown-linux-gnu ;;
        aarch64-linux) echo aarch64-unknown-linux-gnu ;;
        win64) echo x86_64-pc-windows-gnu ;;
        darwin64) echo x86_64-apple-darwin ;;
        aarch64-darwin) echo aarch64-apple-darwin ;;
        web) echo wasm32-unknown-unknown ;;
        *) fail "no recipe for platform '$1' (there are linux64, aarch64-linux, win64, darwin64, aarch64-darwin, web)" ;;
    esac
}

is_mac() { [ "$1" = darwin64 ] || [ "$1" = aarch64-darwin ]; }

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

# What a linker needs of macOS: the list of the system's functions, which zig brings along. Its newest processors are not known to every linker.
provide_macos() {
    local name
    install_zig
    mkdir -p "$macos/usr/lib"
    sed 's/arm64e\.x1-/arm64-/g' "$zig"/lib/python3*/site-packages/ziglang/lib/libc/darwin/libSystem.tbd >"$macos/usr/lib/libSystem.tbd"
    # As on a Mac; the crate libc names also iconv, which nothing calls.
    for name in libc libm libiconv; do ln -sf libSystem.tbd "$macos/usr/lib/$name.tbd"; done
}

# The newest C library that a program or shared library asks for must not be newer than $GLIBC.
check_glibc() {
    local newest
    newest=$(objdump -T "$1" 2>/dev/null || "$zig/bin/python" -m ziglang objdump -T "$1")
    newest=$(printf '%s\n' "$newest" | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -n 1)
    [ "$(printf '%s\n' "$newest" "GLIBC_$GLIBC" | sort -V | tail -n 1)" = "GLIBC_$GLIBC" ] ||
        fail "$1 needs $newest"
    say "needs at most $newest"
}

# A shared library for Macs needs nothing but the system, from $MACOS on.
check_macos() { python3 tools/mach_o.py "$1" "$MACOS" "$([ "$2" = darwin64 ] && echo x86_64 || echo arm64)" >&2 || fail "$1 is not fit for macOS $MACOS"; }

# Builds a package for a platform: build_for PLATFORM MANIFEST [OPTION...]; the result is in $work/<triple>/release.
build_for() (
    local platform=$1 manifest=$2 target std=()
    target=$(triple "$platform")
    choose_toolchain "$target"
    local options=(--release --config "$STRIP" --manifest-path "$manifest" --target-dir "$work" ${std[@]+"${std[@]}"} "${@:3}")
    [ "$platform" != web ] || options+=(--config "target.$target.linker=\"$PWD/tools/link-web.sh\"")
    if [ "$platform" = win64 ] || [ "$platform" = web ]; then
        "$CARGO" build "${options[@]}" --target "$target"
    elif is_mac "$platform"; then
        provide_macos
        options+=(--config "target.$target.linker=\"$PWD/tools/lld.sh\"" --config 'profile.release.package.cotree-runtime.strip="none"')
        # The linker strips: what changes a library afterwards breaks its signature.
        MACOSX_DEPLOYMENT_TARGET=$MACOS SDKROOT=$macos "$CARGO" rustc "${options[@]}" --config 'profile.release.strip="none"' --target "$target" --lib -- \
            -C linker-flavor=ld64.lld -C link-args="-x -install_name @rpath/libcotree_runtime.dylib"
    else
        install_zig
        PATH=$zig/bin:$PATH "$zig/bin/cargo-zigbuild" zigbuild "${options[@]}" --target "$target.$GLIBC"
    fi
)
