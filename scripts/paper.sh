#!/usr/bin/env bash
# The paper's figures and tables for which weft has an equivalent, in build/paper/index.html; --quick: small meshes, in minutes.
set -euo pipefail
cd "$(dirname "$0")/.."

weft=${WEFT:-build/bin/weft}
[[ -x $weft ]] || scripts/build.sh release --no-tests
exec python3 -B scripts/paper.py --weft "$weft" "$@"
