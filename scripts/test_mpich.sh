#!/usr/bin/env bash
# Builds with MPICH, in build-mpich/, and runs the tests that start ranks, also those of the installed package; further arguments go to ctest.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh
scripts/build.sh mpich
ctest --test-dir build-mpich --output-on-failure --label-regex '^mpi$' "$@"
