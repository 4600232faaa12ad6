#!/usr/bin/env bash
# Compiles everything with Clang, warnings being errors, without precompiled headers and each source alone, then runs clang-tidy on the sources:
# lint.sh [FILE...] (all but tests). Needs clang-16 and clang-tidy-16 (scripts/setup.sh --all).
set -euo pipefail
cd "$(dirname "$0")/.."

for tool in clang++-16 clang-tidy-16; do
  command -v "$tool" >/dev/null || { echo "lint: $tool is missing: scripts/setup.sh --all" >&2; exit 1; }
done
cmake --preset clang -DWEFT_WERROR=ON -DWEFT_UNITY=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON --log-level=WARNING
if (($# > 0)); then
  files=("$@")
else
  cmake --build --preset clang --parallel "$(nproc)"
  mapfile -t files < <(git ls-files 'engine/*.cpp' 'meshing/*.cpp' 'partition/*.cpp' 'graph/*.cpp' 'tools/*.cpp')
fi
printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy-16 -p build-clang --quiet
