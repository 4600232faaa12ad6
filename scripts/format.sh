#!/usr/bin/env bash
# Formats all sources with clang-format; with --check only says which differ.
set -euo pipefail
cd "$(dirname "$0")/.."

mode=(-i)
[[ ${1:-} != --check ]] || mode=(--dry-run --Werror)
find meshing engine partition graph tools tests \( -name '*.h' -o -name '*.cpp' \) -print0 |
  xargs -0 --no-run-if-empty clang-format "${mode[@]}"
