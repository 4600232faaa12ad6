#!/usr/bin/env bash
# From a bare machine to adapted meshes and their pictures: a shock layer in a cube, and a delta wing; all in build/demo/.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh
scripts/build.sh release --no-tests
weft=build/bin/weft
out=build/demo
mkdir -p "$out"

say() { printf '\n=== %s\n' "$*"; }

# An adaptation that misses its goal still writes a valid mesh, and exits with 1.
adapt() {
  local status=0
  "$weft" adapt "$@" || status=$?
  ((status <= 1)) || exit "$status"
}

say "A structured cube"
"$weft" mesh box -o "$out/cube-0.meshb" --cells 8 8 8
"$weft" stat "$out/cube-0.meshb" --metric-fn polar-2

# The metric is sampled at the vertices of the input: the coarse cube misses most of the thin layer. Each stage
# starts from the result of the one before, which samples the layer better.
say "The first stages cannot meet the goal: the coarse cube does not resolve the thin layer"
previous=$out/cube-0.meshb
for complexity in 1000 4000 16000; do
  next=$out/cube-$complexity.meshb
  say "The cylindrical layer polar-2 at complexity $complexity"
  adapt "$previous" --metric-fn polar-2 --complexity "$complexity" -o "$next" --quiet
  "$weft" stat "$next" --metric "${next%.meshb}.solb"
  previous=$next
done

say "The same layer in 8 subdomains at complexity 20,000, with a report"
adapt "$previous" --metric-fn polar-2 --complexity 20000 --subdomains 8 -o "$out/cube.meshb" --report "$out/report"
"$weft" verify "$out/cube.meshb" --against "$out/cube-0.meshb"

say "A delta wing and its far field: an initial mesh, then one of the same sizes with three times the complexity"
"$weft" mesh delta-wing --size 0.05 -o "$out/wing-0.meshb" --progress none
adapt "$out/wing-0.meshb" --implied --complexity 12000 -o "$out/wing.meshb" --quiet
"$weft" stat "$out/wing.meshb" --metric "$out/wing.solb"
"$weft" verify "$out/wing.meshb" --against "$out/wing-0.meshb"

say "Pictures"
"$weft" view "$out/cube-0.meshb" -o "$out/cube-before.png" --title "before"
"$weft" view "$out/cube.meshb" --metric "$out/cube.solb" -o "$out/cube-after.png" --title "after"
"$weft" view "$out/cube.meshb" --metric "$out/cube.solb" --clip z=0.5 --from z --color-by quality -o "$out/cube-cut.png" \
  --title "cut at z = 0.5"
"$weft" view "$out/wing.meshb" --only 1,2,3,4 -o "$out/wing.png" --title "delta wing"
"$weft" graph "$out/report/graph.json" --collapse rounds -o "$out/graph.svg"

for mesh in cube wing; do
  "$weft" convert "$out/$mesh.meshb" "$out/$mesh.vtu" --sol "$out/$mesh.solb" --quiet
done

say "Done. Open in a browser:"
printf '  %s\n' "$PWD/$out/report/report.html"
echo "Pictures:"
printf '  %s\n' "$PWD/$out"/cube-{before,after,cut}.png "$PWD/$out/wing.png" "$PWD/$out/graph.svg"
echo "For ParaView:"
printf '  %s\n' "$PWD/$out"/{cube,wing}.vtu
