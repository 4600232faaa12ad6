#!/usr/bin/env bash
# Builds, then times `weft adapt` (and Mmg, where it is installed) on the benchmark cases; see bench.py --help.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh
scripts/build.sh release --no-tests
exec python3 -B scripts/bench.py "$@"
