#!/usr/bin/env bash
# Which lines the tests run, and which error paths they never do: coverage.sh [ctest options]. Table and list in build-coverage/coverage.md.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh --all
scripts/build.sh coverage
find build-coverage -name '*.gcda' -delete
# Also after a failure: what ran is counted.
failed=0
ctest --test-dir build-coverage --output-on-failure --parallel "$(nproc)" "$@" || failed=$?
gcovr --root . --object-directory build-coverage --filter 'meshing/' --filter 'engine/' --filter 'partition/' --filter 'graph/' \
  --filter 'tools/' --exclude-throw-branches --gcov-ignore-parse-errors --json build-coverage/coverage.json
scripts/coverage.py build-coverage/coverage.json >build-coverage/coverage.md
sed -n '1,/^## /p' build-coverage/coverage.md | head -n -1
exit "$failed"
