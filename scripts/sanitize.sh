#!/usr/bin/env bash
# Runs the whole test suite under sanitizers: sanitize.sh [asan] [tsan] (default: both).
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD

# The thread sanitizer does not see the synchronisation inside a TBB that was not built for it and would report
# races that are none. The source is that of the TBB installed here.
build_tbb_for_tsan() {
  local prefix=$root/build-tsan-tbb
  [[ ! -e $prefix/installed ]] || return 0
  local apt=(-o Dir::Etc::sourceparts="$prefix/sources" -o Dir::Etc::sourcelist=/dev/null
    -o Dir::State::lists="$prefix/lists")
  mkdir -p "$prefix/sources" "$prefix/lists/partial"
  if [[ -e /etc/apt/sources.list.d/debian.sources ]]; then  # of images; the installer writes the other
    sed '/^#/d; s/^Types:.*/Types: deb-src/' /etc/apt/sources.list.d/debian.sources >"$prefix/sources/src.sources"
  else
    sed -n 's/^deb /deb-src /p' /etc/apt/sources.list >"$prefix/sources/src.list"
  fi
  apt-get "${apt[@]}" update -qq
  (cd "$prefix" && apt-get "${apt[@]}" source --download-only -qq onetbb && mkdir -p source &&
    tar -xf onetbb_*.orig.tar.* --strip-components=1 -C source)
  cmake -G Ninja -S "$prefix/source" -B "$prefix/build" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_TEST=OFF \
    -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF -DTBB_SANITIZE=thread -DCMAKE_INSTALL_PREFIX="$prefix" --log-level=WARNING
  cmake --build "$prefix/build" --target install
  touch "$prefix/installed"
}

# Older thread sanitizers need a fixed address layout; also while building, because test discovery runs the tests.
fixed_layout() {
  local setarch=(setarch "$(uname -m)" --addr-no-randomize)
  if "${setarch[@]}" true 2>/dev/null; then "${setarch[@]}" "$@"; else "$@"; fi
}

# These build programs without sanitizers, which cannot load a library with them.
foreign='^(package|documentation|help_pages|bindings)'

# A child reads CGNS files first. GCC's address sanitizer does not free its own locks in a child of fork(): where ranks
# are threads that allocate (Formats/FieldShares) the child may hang, and ends by its alarm after a minute.
run_asan() {
  scripts/build.sh asan
  export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
  export LSAN_OPTIONS=suppressions=$root/scripts/known_leaks.txt:print_suppressions=0
  # Open MPI does not free all that it allocates: no leaks are looked for in what starts ranks.
  local on_ranks='^(mpi|command|examples|kill|fuzz\.runs|graph\.misuse)'
  ASAN_OPTIONS=detect_stack_use_after_return=1 \
    ctest --test-dir build-asan --output-on-failure --parallel "$(nproc)" --exclude-regex "$on_ranks|$foreign"
  ASAN_OPTIONS=detect_stack_use_after_return=1:detect_leaks=0 \
    ctest --test-dir build-asan --output-on-failure --parallel "$(nproc)" --tests-regex "$on_ranks"
}

run_tsan() {
  build_tbb_for_tsan
  CMAKE_PREFIX_PATH=$root/build-tsan-tbb fixed_layout scripts/build.sh tsan
  TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1:suppressions=$root/scripts/known_races.txt \
    fixed_layout ctest --test-dir build-tsan --output-on-failure --parallel "$(nproc)" \
    --exclude-regex "^mpi\.|$foreign"  # MPI is not built for it
}

[[ $# -gt 0 ]] || set -- asan tsan
scripts/setup.sh
for sanitizer in "$@"; do
  "run_$sanitizer"
done
