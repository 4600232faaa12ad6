#!/usr/bin/env bash
# Compares the C interface with that of the last release (tools/bindings/c/weft-c.abi) by abidiff: functions may be
# added, none may go or change. --update makes it the reference, with a release. Where the library has been built,
# it must export what the header declares, and nothing else in C.
set -euo pipefail
cd "$(dirname "$0")/.."

header=tools/bindings/c/include/weft/weft-c.h
reference=tools/bindings/c/weft-c.abi
library=${WEFT_LIBRARY:-build/lib/libweft.so}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# The interface is the header alone: a library of its functions with empty bodies has the same types, and compiles
# in a moment.
python3 -B - "$header" >"$folder/interface.c" <<'PYTHON'
import re
import sys

text = open(sys.argv[1]).read()
print(re.sub(r"^WEFT_C_API ([^;]*);", r"\1 { __builtin_trap(); }", text, flags=re.MULTILINE))
PYTHON
read -r -a mpi <<<"$(pkg-config --cflags "${WEFT_MPI_PACKAGE:-ompi-c}")"
(cd "$folder" && "${CC:-gcc}" -std=c99 -g -O0 -fPIC -shared -Wl,-soname,libweft-c.so "${mpi[@]}" interface.c \
  -o libweft-c.so)

if [[ -e $library ]]; then
  exported() { nm -D --defined-only "$1" | sed -n 's/.* T \(weft_[a-z0-9_]*\)\(@.*\)*$/\1/p' | sort; }
  diff <(exported "$folder/libweft-c.so") <(exported "$library") || {
    echo "abi: $library does not export what $header declares" >&2
    exit 1
  }
fi

if [[ ${1:-} == --update ]]; then
  # What is written must not name this machine.
  abidw --no-corpus-path --no-comp-dir-path --no-show-locs "$folder/libweft-c.so" >"$reference"
  echo "abi: $reference is the C interface as it is now"
  exit 0
fi
if abidiff --no-added-syms "$reference" "$folder/libweft-c.so"; then
  echo "abi: the C interface is that of the last release, or has more"
else
  echo "abi: the C interface has changed: programs built against the last release would break" >&2
  exit 1
fi
