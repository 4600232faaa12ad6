#!/usr/bin/env bash
# The long checks: all tests, all again with heavy assertions, those of MPI with MPICH, the sanitizers, a hundred repetitions of what could hang, and the benchmarks.
set -euo pipefail
cd "$(dirname "$0")/.."
export WEFT_LONG_TESTS=1  # tests at random try more, on all numbers of ranks; convergence goes further

scripts/test.sh
scripts/test_mpich.sh
# The whole mesh is checked after every pass.
scripts/build.sh heavy
ctest --test-dir build-heavy --output-on-failure
scripts/sanitize.sh asan tsan
# A hang that comes once in a hundred runs is a hang.
ctest --test-dir build --output-on-failure --tests-regex '^mpi\.(engine|transport)' --repeat until-fail:100
build/bin/weft_engine_tests --gtest_filter='Ranks/*' --gtest_repeat=100 --gtest_brief=1
# Runs killed at random moments go on to the same bytes, and time limits are kept.
scripts/kill_runs.py build/bin/weft --runs 200 --limits 50
# Warnings of Clang and findings of clang-tidy are errors.
scripts/lint.sh
# Error paths that no test runs.
scripts/coverage.sh
# Calls that fail, by number.
WEFT_FAULTS=250 ctest --test-dir build --output-on-failure --tests-regex '^command\.fault$' --timeout 14400
# Changed files and options, by what they reach: an hour each.
scripts/fuzz.sh 3600
# Random meshes, metrics, partitions, ranks.
scripts/fuzz_runs.py build/bin/weft --seconds 3600
# The CAD cases on their models; skips loudly where they are not there.
scripts/cad_cases.py build/bin/weft
# A thousand ranks in one thread, and 2, 4 and 8 simulated and real ones: the same bytes and messages.
scripts/many_ranks.py
# Several hosts over TCP, links that are slow, lossy or cut, hosts that are lost; skips loudly where network namespaces are not permitted.
scripts/several_hosts.py --hosts 4
scripts/several_hosts.py --random 100
# The paper's figures, and predicted scaling, on a small scale.
scripts/paper.sh --quick
scripts/scaling.py --complexity 5000 --subdomains 32 --copies 4 --grow 1 --cores 16 64 --weak 4 16 64 --threads 1 --whole 16
scripts/bench.sh
scripts/bench.sh engine
# Predicted times beside measured ones; last, for other work of the machine makes it fail.
scripts/calibrate.py
