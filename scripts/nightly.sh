#!/usr/bin/env bash
# The long checks: all tests, the sanitizers, and the benchmark on all its cases.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/test.sh
scripts/sanitize.sh asan tsan
scripts/bench.sh
