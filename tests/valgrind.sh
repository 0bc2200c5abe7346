#!/usr/bin/env bash
# Memory of 300 instances in 20 loads of the library under valgrind: no invalid access, nothing lost. Usage: tests/valgrind.sh [MODEL]; COTREE=PROGRAM exports with a
# program that has been built.
set -euo pipefail
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "SKIPPED: valgrind is not installed"; exit 0; }
model="${1:-slider_crank}"
cotree=(${COTREE:-cargo run --quiet --release --})
work="$(mktemp -d)"
trap 'rm -r "$work"' EXIT

"${cotree[@]}" export "models/$model/scene.toml" -o "$work/model.fmu"
python3 -m zipfile -e "$work/model.fmu" "$work/model"
library="$(echo "$work"/model/binaries/*/*.so)"
guid="$(grep -o 'guid="[^"]*"' "$work/model/modelDescription.xml" | head -n 1 | cut -d '"' -f 2)"
gcc -O1 -g -std=c99 -Wall -Wextra -Werror tests/valgrind.c -o "$work/instances" -ldl
valgrind --quiet --error-exitcode=1 --leak-check=full --errors-for-leak-kinds=definite,indirect,possible \
    "$work/instances" "$library" "file://$work/model/resources" "$guid" 20 15
echo "300 instances of $model in 20 loads of the library: no invalid access, nothing lost"
