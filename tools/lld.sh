#!/usr/bin/env bash
# LLVM's linker, of the toolchain or Debian's: lld.sh -flavor FLAVOR ARGUMENT...
set -euo pipefail

rustc=${RUSTC:-rustc}
own=$("$rustc" --print sysroot)/lib/rustlib/$("$rustc" -vV | sed -n 's/^host: //p')/bin/rust-lld
if [ -x "$own" ]; then exec "$own" "$@"; fi
case $2 in wasm) name=wasm-ld ;; darwin) name=ld64.lld ;; *) name=ld.lld ;; esac
for linker in "$name" "$name-19"; do
    if command -v "$linker" >/dev/null; then exec "$linker" "${@:3}"; fi
done
echo "error: there is no linker $name (rust-lld of the toolchain, or the package lld-19)" >&2
exit 1
