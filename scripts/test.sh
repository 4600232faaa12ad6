#!/usr/bin/env bash
# Installs what is missing, builds, and runs all tests; further arguments go to ctest (e.g. -R Surface).
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh
scripts/build.sh release
ctest --test-dir build --output-on-failure --parallel $(($(nproc) + 2)) "$@"  # many mostly wait
