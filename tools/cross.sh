# How cotree's shell scripts build for another platform: sourced, not run.
# Sets $work, where everything is built; whoever sources it has changed into the root of the project.

GLIBC=2.28 # of Debian 10 and RHEL 8
ZIG=(cargo-zigbuild==0.24.0 ziglang==0.17.0)

work=$PWD/target/runtimes-build
zig=$work/zig

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
        web) echo wasm32-unknown-unknown ;;
        *) fail "no recipe for platform '$1' (there are linux64, aarch64-linux, win64, web)" ;;
    esac
}

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

# The newest C library that a program or shared library asks for must not be newer than $GLIBC.
check_glibc() {
    local newest
    newest=$(objdump -T "$1" 2>/dev/null || "$zig/bin/python" -m ziglang objdump -T "$1")
    newest=$(printf '%s\n' "$newest" | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -n 1)
    [ "$(printf '%s\n' "$newest" "GLIBC_$GLIBC" | sort -V | tail -n 1)" = "GLIBC_$GLIBC" ] ||
        fail "$1 needs $newest"
    say "needs at most $newest"
}

# Builds a package for a platform: build_for PLATFORM MANIFEST [OPTION...]; the result is in $work/<triple>/release.
build_for() (
    local platform=$1 manifest=$2 target std=()
    target=$(triple "$platform")
    choose_toolchain "$target"
    local options=(--release --config "$STRIP" --manifest-path "$manifest" --target-dir "$work" ${std[@]+"${std[@]}"} "${@:3}")
    [ "$platform" != web ] || options+=(--config "target.$target.linker=\"$PWD/tools/link-web.sh\"")
    if [ "$platform" = win64 ] || [ "$platform" = web ]; then
        "$CARGO" build "${options[@]}" --target "$target"
    else
        install_zig
        PATH=$zig/bin:$PATH "$zig/bin/cargo-zigbuild" zigbuild "${options[@]}" --target "$target.$GLIBC"
    fi
)
