#!/usr/bin/env bash
# Builds a preset: build.sh [release|debug|asan|tsan|mpich|portable|pgo|clang|fuzz|heavy|coverage] [--no-tests]. The release command lands at build/bin/weft.
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

# Small cases that go through all stages: a layer, its coarsening, subdomains, curved and planar boundary.
train() {
  local weft=$1 out=build-pgo/training adapt
  mkdir -p "$out"
  "$weft" mesh box -o "$out/box.meshb" --cells 10 10 10 --quiet
  "$weft" mesh ball --size 0.1 -o "$out/ball.meshb" --quiet
  for adapt in "box.meshb --metric-fn polar-2 --complexity 10000 --threads 1 -o $out/fine.meshb" \
    "fine.meshb --metric $out/fine.solb --complexity 1000 --threads 1 -o $out/coarse.meshb" \
    "box.meshb --metric-fn polar-2 --complexity 5000 --threads 1 --subdomains 8 -o $out/parts.meshb" \
    "ball.meshb --metric-fn uniform:0.05 --threads 1 -o $out/sphere.meshb"; do
    # shellcheck disable=SC2086
    "$weft" adapt "$out"/$adapt --quiet || (($? == 1))
  done
}

if [[ $preset == pgo ]]; then
  cmake --preset pgo -DWEFT_TESTS=OFF -DWEFT_PROFILE=generate --log-level=WARNING
  cmake --build --preset pgo --parallel "$jobs" --target weft
  find build-pgo -name '*.gcda' -delete
  train build-pgo/bin/weft
  WEFT_CMAKE_OPTIONS="${WEFT_CMAKE_OPTIONS:-} -DWEFT_PROFILE=use"
fi

# WEFT_CMAKE_OPTIONS: further -D options, as .ci/run gives.
# shellcheck disable=SC2086
cmake --preset "$preset" -DWEFT_TESTS=$tests ${WEFT_CMAKE_OPTIONS:-} --log-level=WARNING
cmake --build --preset "$preset" --parallel "$jobs"
