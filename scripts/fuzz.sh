#!/usr/bin/env bash
# Fuzzes the readers and the options with libFuzzer, under ASan and UBSan: fuzz.sh SECONDS. Each target gets so many seconds, as many
# jobs as there are cores; inputs that reach new code are kept in build-fuzz/corpus-*, findings in build-fuzz/finding-*. Needs Clang.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?usage: fuzz.sh SECONDS}

scripts/setup.sh --all
# Compiles the command and the two targets.
cmake --preset fuzz --log-level=WARNING
cmake --build --preset fuzz --parallel "$(nproc)" --target weft weft_fuzz_readers weft_fuzz_options

# The first line of an input names the format of the rest (tests/fuzz/readers.cpp).
export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1:suppressions=$PWD/scripts/known_undefined.txt
export ASAN_OPTIONS=detect_leaks=0  # HDF5 and OpenCASCADE are not built for it: what they leak is not ours
corpus=build-fuzz/corpus-readers
mkdir -p "$corpus" build-fuzz/corpus-options
tests/fuzz/seeds.sh build-fuzz/bin/weft build-fuzz/seeds
for file in build-fuzz/seeds/*; do
  name=$(basename "$file")
  { echo ".${name#*.}" && cat "$file"; } >"$corpus/$name"
done

failed=0
for target in readers options; do
  build-fuzz/bin/weft_fuzz_$target "build-fuzz/corpus-$target" -max_total_time="$seconds" -max_len=65536 -timeout=60 \
    -rss_limit_mb=8192 -fork="$(nproc)" -artifact_prefix="build-fuzz/finding-$target-" >"build-fuzz/$target.log" 2>&1 ||
    failed=1
  tail -n 1 "build-fuzz/$target.log"
done
exit "$failed"
