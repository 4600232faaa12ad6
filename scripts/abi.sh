#!/usr/bin/env bash
# Compares the C interface with that of the last release (tools/bindings/c/weft-c.abi) by abidiff: functions may be
# added, none may go or change. --update makes it the reference, with a release.
set -euo pipefail
cd "$(dirname "$0")/.."

reference=tools/bindings/c/weft-c.abi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Only these files declare the interface; with debug information, but without the rest of the library, they are a
# library that tells its types.
flags=(-std=c++20 -g -O0 -fPIC -fvisibility=hidden -DOMPI_SKIP_MPICXX -DMPICH_SKIP_MPICXX -DFMT_SHARED -I.
  -Imeshing/include -Itools/library/include -Itools/bindings/c/include)
read -r -a mpi <<<"$(pkg-config --cflags "${WEFT_MPI_PACKAGE:-ompi-c}")"
for source in tools/bindings/c/*.cpp; do
  "${CXX:-g++}" "${flags[@]}" "${mpi[@]}" -c "$source" -o "$folder/$(basename "$source" .cpp).o"
done
echo 'WEFT_C_0 { global: weft_*; local: *; };' >"$folder/exports"
"${CXX:-g++}" -shared -Wl,-soname,libweft.so.0 -Wl,--version-script="$folder/exports" \
  "$folder"/*.o -o "$folder/libweft.so.0"

if [[ ${1:-} == --update ]]; then
  # What is written must not name this machine.
  abidw --no-corpus-path --no-comp-dir-path --no-show-locs "$folder/libweft.so.0" >"$reference"
  echo "abi: $reference is the C interface as it is now"
  exit 0
fi
if abidiff --no-added-syms "$reference" "$folder/libweft.so.0"; then
  echo "abi: the C interface is that of the last release, or has more"
else
  echo "abi: the C interface has changed: programs built against the last release would break" >&2
  exit 1
fi
