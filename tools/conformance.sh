#!/usr/bin/env bash
# Runs every case of the conformance catalogues and writes the tables to docs/conformance.md and docs/conformance-fmi3.md.
set -euo pipefail
cd "$(dirname "$0")/.."
COTREE_DATE=$(date -u +%Y-%m-%d)
COTREE_COMMIT=$(git rev-parse --short HEAD)
[ -z "$(git status --porcelain --untracked-files=no)" ] || COTREE_COMMIT+=" with changes"
export COTREE_DATE COTREE_COMMIT COTREE_CONFORMANCE_TABLE=$PWD/docs/conformance.md
cargo test --quiet --test all -- --nocapture conformance::every_case
export COTREE_CONFORMANCE_TABLE_3=$PWD/docs/conformance-fmi3.md
cargo test --quiet --test all -- --nocapture fmi3::every_case
