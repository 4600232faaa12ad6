#!/usr/bin/env bash
# Builds the Debian packages into build-package/packages/ and checks them with lintian: package.sh [PRESET], portable unless said.
# The files go to the system's folders, so that binaries need no search path of their own.
set -euo pipefail
cd "$(dirname "$0")/.."

cmake --preset "${1:-portable}" -B build-package -DCMAKE_INSTALL_PREFIX=/usr -DCMAKE_SKIP_INSTALL_RPATH=ON \
  -DWEFT_TESTS=OFF --log-level=WARNING
cmake --build build-package --parallel "$(nproc)"
rm -rf build-package/packages
(cd build-package && cpack -G DEB > cpack.log) || { cat build-package/cpack.log; exit 1; }
ls build-package/packages/*.deb
lintian --fail-on error --tag-display-limit 0 build-package/packages/*.deb
