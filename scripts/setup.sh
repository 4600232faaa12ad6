#!/usr/bin/env bash
# Installs what weft needs on Debian 12; does nothing, offline, when it is all there. --all: also what optional parts need
# (PETSc, SimGrid, dolfinx, Debian packages, documentation, Clang); without it these parts are left out, and their tests skip.
set -euo pipefail

packages=(
  g++ cmake ninja-build ccache python3
  libocct-foundation-dev libocct-modeling-data-dev libocct-modeling-algorithms-dev libocct-data-exchange-dev
  libtbb-dev libcgal-dev libceres-dev libeigen3-dev
  libcli11-dev libfmt-dev nlohmann-json3-dev libpugixml-dev zlib1g-dev libcgns-dev libhdf5-dev
  pkg-config libcairo2-dev
  libjs-chart.js libjs-three graphviz
  openmpi-bin libopenmpi-dev mpich libmpich-dev libmetis-dev
  libgtest-dev libgmock-dev chromium python3-jsonschema
  pybind11-dev python3-dev python3-numpy python3-mpi4py python3-meshio python3-matplotlib
  python3-pytest python3-venv python3-wheel python3-setuptools gfortran abigail-tools
)

if [[ ${1:-} == --all ]]; then
  packages+=(
    libsimgrid-dev
    petsc-dev python3-petsc4py python3-dolfinx
    lintian debootstrap man-db groff zsh fish
    doxygen gcovr
    clang-16 libclang-rt-16-dev clang-tidy-16 clang-format
  )
fi

if ! command -v dpkg-query >/dev/null; then
  echo "setup: this is no Debian; install the like of: ${packages[*]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || exit 0

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "setup: as root, run: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
echo "setup: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
