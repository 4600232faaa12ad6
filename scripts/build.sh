#!/usr/bin/env bash
# Builds a preset: build.sh [release|debug|asan|tsan|mpich|portable|clang|fuzz|heavy|coverage] [--no-tests]. The release command lands at build/bin/weft.
set -euo pipefail
cd "$(dirname "$0")/.."

preset=release
tests=ON
for argument in "$@"; do
  case $argument in
    --no-tests) tests=OFF ;;
    *) preset=$argument ;;
  esac
done

if command -v ccache >/dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
  export CCACHE_SLOPPINESS=${CCACHE_SLOPPINESS:-pch_defines,time_macros}  # without it nothing with precompiled headers is kept
fi
# Compiling CGAL or Ceres takes up to 2 GB: fewer jobs than cores where memory is short.
memory_gb=$(awk '/^MemAvailable/ { print int($2 / 1048576) }' /proc/meminfo)
jobs=$(nproc)
((jobs <= memory_gb / 2)) || jobs=$((memory_gb / 2 > 0 ? memory_gb / 2 : 1))

# WEFT_CMAKE_OPTIONS: further -D options, as .ci/run gives.
# shellcheck disable=SC2086
cmake --preset "$preset" -DWEFT_TESTS=$tests ${WEFT_CMAKE_OPTIONS:-} --log-level=WARNING
cmake --build --preset "$preset" --parallel "$jobs"
