#!/usr/bin/env bash
# Builds, then times `weft adapt` (and Mmg, where it is installed) on the benchmark cases; see bench.py --help.
# `bench.sh tracing` measures what tracing, report and progress cost; see bench_tracing.py --help.
# `bench.sh distributed` measures subdomains beside one mesh; see bench_distributed.py --help.
# `bench.sh record [CASE...]` keeps the record: weft beside Mmg and published figures, table, picture and history; see bench_record.py --help.
# `bench.sh meshing [SURFACE...]` compares initial meshes with TetGen's and Gmsh's; see bench_meshing.py --help.
# `bench.sh engine [PART...]` measures the engine instead; see tools/bench/engine/run_benchmarks.py --help.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh
if [[ ${1:-} == engine ]]; then
  shift
  if command -v ccache >/dev/null; then
    export CMAKE_CXX_COMPILER_LAUNCHER=ccache
  fi
  cmake --preset release -DWEFT_BENCHMARKS=ON --log-level=WARNING
  cmake --build --preset release --target weft_transport_bench weft_engine_bench weft_example_programs
  exec python3 -B tools/bench/engine/run_benchmarks.py "$@"
fi
scripts/build.sh release --no-tests
if [[ ${1:-} == tracing ]]; then
  shift
  exec python3 -B scripts/bench_tracing.py "$@"
fi
if [[ ${1:-} == distributed ]]; then
  shift
  exec python3 -B scripts/bench_distributed.py "$@"
fi
if [[ ${1:-} == record ]]; then
  shift
  exec python3 -B scripts/bench_record.py "$@"
fi
if [[ ${1:-} == meshing ]]; then
  shift
  exec python3 -B scripts/bench_meshing.py "$@"
fi
exec python3 -B scripts/bench.py "$@"
