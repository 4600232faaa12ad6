#!/usr/bin/env bash
# As root, with network: installs the packages of build-package/packages/ in a clean Debian 12 and uses what is there then.
#   tests/packaging/chroot_test.sh [FOLDER]   a folder that debootstrap has filled, else one is made and removed
set -euo pipefail
cd "$(dirname "$0")/../.."

packages=(build-package/packages/*.deb)
root=${1:-}
if [[ -z $root ]]; then
  root=$(mktemp -d)
  trap 'rm -rf --one-file-system "$root"' EXIT
  debootstrap --variant=minbase bookworm "$root" >/dev/null
fi
mkdir -p "$root/packages"
cp "${packages[@]}" "$root/packages/"
inside() {
  chroot "$root" /usr/bin/env DEBIAN_FRONTEND=noninteractive LC_ALL=C \
    MPIRUN="mpirun --allow-run-as-root --oversubscribe --bind-to none -n 2" "$@"
}

inside apt-get update -qq
mapfile -t inside_packages < <(cd "$root" && printf '/%s\n' packages/*.deb)
inside apt-get install -y -qq --no-install-recommends "${inside_packages[@]}" g++ pkg-config >/dev/null
inside weft --version | head -1
inside sh -c 'cd /tmp && weft mesh box --cells 4 4 4 -o box.meshb && weft adapt box.meshb --metric-fn uniform:0.2 -o fine.meshb --quiet && weft verify fine.meshb --quiet'
inside sh -c 'cd /tmp && weft convert box.meshb box.cgns --quiet && weft view box.cgns -o box.pdf --quiet && test -s box.pdf'
if [[ -e $root/usr/lib/x86_64-linux-gnu/weft/libweft_cad.so ]]; then
  cp tests/data/models/cylinder.brep "$root/tmp/"
  inside sh -c 'cd /tmp && weft mesh cylinder.brep --size 0.5 -o cylinder.meshb --quiet && weft verify cylinder.meshb --quiet'
fi
cat tests/package/one_mesh.cpp >"$root/tmp/one_mesh.cpp"
inside sh -c 'cd /tmp && g++ -std=c++20 one_mesh.cpp -o one_mesh $(pkg-config --cflags --libs weft) && ./one_mesh'
cp tools/bindings/c/examples/adapt_file.c "$root/tmp/"
inside sh -c 'cd /tmp && weft metric box.meshb --metric-fn uniform:0.2 -o box.solb --quiet &&
  gcc -std=c99 adapt_file.c -o adapt_file $(pkg-config --cflags --libs weft) && ./adapt_file box.meshb box.solb from-c.meshb | head -1 &&
  weft verify from-c.meshb --against box.meshb --quiet'
if [[ "${packages[*]}" == *libweft-fortran-dev_* ]]; then
  cp tools/bindings/fortran/examples/adapt_file.f90 "$root/tmp/"
  inside apt-get install -y -qq --no-install-recommends gfortran >/dev/null
  inside sh -c 'cd /tmp && gfortran -I/usr/lib/x86_64-linux-gnu/fortran/weft adapt_file.f90 -o from_fortran -lweft_fortran -lweft &&
    ./from_fortran box.meshb box.solb from-fortran.meshb | head -1 && cmp from-c.meshb from-fortran.meshb'
  cp tools/bindings/fortran/examples/adapt_parts.f90 "$root/tmp/"
  inside sh -c 'cd /tmp &&
    mpifort -I/usr/lib/x86_64-linux-gnu/fortran/weft adapt_parts.f90 -o parts_fortran -lweft_fortran -lweft && $MPIRUN ./parts_fortran'
fi
cp tools/bindings/c/examples/adapt_parts.c "$root/tmp/"
inside sh -c 'cd /tmp && mpicc -std=c99 adapt_parts.c -o parts_c $(pkg-config --cflags --libs weft) && $MPIRUN ./parts_c'
inside sh -c 'cd /tmp && $MPIRUN weft adapt box.meshb --metric box.solb -o parts.meshb --quiet &&
  weft verify parts.meshb --against box.meshb --quiet'
inside sh -c 'test -s /usr/share/man/man1/weft-adapt.1.gz && test -s /usr/share/bash-completion/completions/weft'
if [[ "${packages[*]}" == *python3-weft_* ]]; then
  inside python3 -c 'import weft; print(len(weft.adapt(weft.box((3, 3, 3)), metric_fn="uniform:0.3").mesh.tets), "tets from Python")'
  inside sh -c 'cd /tmp && python3 -c "import weft; m = weft.read(\"box.meshb\"); weft.write(\"from-python.meshb\",
    weft.adapt(m, weft.read_metric(\"box.solb\", m), hgrad=1.5, threads=1))" && cmp from-c.meshb from-python.meshb'
fi
inside apt-get remove -y -qq libweft0 >/dev/null
if inside sh -c 'ls /usr/lib/x86_64-linux-gnu/libweft*' 2>/dev/null; then
  echo "chroot_test: files are left" >&2
  exit 1
fi
echo "chroot_test: installed, used, removed"
