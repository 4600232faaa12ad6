#!/usr/bin/env bash
# Compiles everything with Clang, warnings being errors, then runs clang-tidy on what is no test: lint.sh [--alone] [FILE...]. By default
# sources are compiled and looked at some at a time, as in a build (half an hour on two cores); --alone: each by itself and without
# precompiled headers, which also finds headers that lack an include (two hours). Needs clang-16 and clang-tidy-16 (scripts/setup.sh --all).
set -euo pipefail
cd "$(dirname "$0")/.."

for tool in clang++-16 clang-tidy-16; do
  command -v "$tool" >/dev/null || { echo "lint: $tool is missing: scripts/setup.sh --all" >&2; exit 1; }
done
build=build-clang
options=()
if [[ ${1:-} == --alone ]] || (($# > 0)); then
  [[ $1 != --alone ]] || shift
  build=build-clang-alone
  options=(-DWEFT_UNITY=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON)
fi
cmake --preset clang -B "$build" -DWEFT_TESTS=ON -DWEFT_WERROR=ON "${options[@]}" --log-level=WARNING
files=("$@")
if (($# == 0)); then
  cmake --build "$build" --parallel "$(nproc)"
  mapfile -t files < <(python3 -c "
import json, os, sys
for unit in json.load(open(sys.argv[1] + '/compile_commands.json')):
    path = os.path.relpath(unit['file'])
    if path.removeprefix(sys.argv[1] + '/').split('/')[0] in ('engine', 'meshing', 'partition', 'graph', 'tools') and path.endswith(('.cpp', 'cxx.cxx')):
        print(path)" "$build" | sort -u)
fi
printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy-16 -p "$build" --quiet
