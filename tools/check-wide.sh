#!/usr/bin/env bash
# Finds closures and adapters that the code for AVX2 calls: they are compiled without it, and what they cost shows nowhere else.
#
# usage: tools/check-wide.sh BINARY        a program or library with symbols that holds the runtime
#
# Needs objdump.
set -euo pipefail

binary=${1:?a program or library with symbols}
escapes=$(objdump --disassemble --no-show-raw-insn --demangle "$binary" | awk '
    /^[0-9a-f]+ <.*>:$/ { name = $0; wide = name ~ /::wide>:$/; seen += wide }
    wide && /call/ && (/[{][{]closure[}][}]/ || /core::iter/ || /core::array/) { print name; print }
    END { if (!seen) print "no function for AVX2 in here: without symbols nothing is known" }')
[ -z "$escapes" ] && exit 0
printf '%s\n' "$escapes" >&2
exit 1
