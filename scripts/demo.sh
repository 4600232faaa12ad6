#!/usr/bin/env bash
# From a bare machine to adapted meshes: a shock layer in a cube, and a delta wing; results in build/demo/.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh
scripts/build.sh release --no-tests
weft=build/bin/weft
out=build/demo
mkdir -p "$out"

say() { printf '\n=== %s\n' "$*"; }

say "A structured cube"
"$weft" mesh box -o "$out/cube-0.meshb" --cells 8 8 8
"$weft" stat "$out/cube-0.meshb" --metric-fn polar-2

# The metric is sampled at the vertices of the input: the coarse cube misses most of the thin layer. Each stage
# starts from the result of the one before, which shows the layer better.
say "The first stages cannot meet the goal yet: the coarse cube does not show the thin layer"
previous=$out/cube-0.meshb
for complexity in 1000 4000 16000 50000; do
  next=$out/cube-$complexity.meshb
  say "The cylindrical layer polar-2 at complexity $complexity"
  status=0
  "$weft" adapt "$previous" --metric-fn polar-2 --complexity "$complexity" -o "$next" \
    --report "$out/cube-$complexity-report" || status=$?
  ((status <= 1)) || exit "$status"
  previous=$next
done
"$weft" verify "$previous" --against "$out/cube-0.meshb"

say "A delta wing and its far field, from a coarse mesh"
previous=tests/data/delta-wing-coarse.meshb
for size in 1 0.3; do
  next=$out/wing-$size.meshb
  status=0
  "$weft" adapt "$previous" --metric-fn "uniform:$size" -o "$next" --report "$out/wing-$size-report" || status=$?
  ((status <= 1)) || exit "$status"
  previous=$next
done
"$weft" verify "$previous" --against tests/data/delta-wing-coarse.meshb

say "The same layer in 8 subdomains, with an account of what was done when"
status=0
"$weft" adapt "$out/cube-4000.meshb" --metric-fn polar-2 --complexity 16000 --subdomains 8 -o "$out/parts.meshb" \
  --report "$out/parts-report" || status=$?
((status <= 1)) || exit "$status"
"$weft" graph "$out/parts-report/graph.json" --collapse rounds -o "$out/parts-graph.svg"

for mesh in cube-50000 wing-0.3; do
  "$weft" convert "$out/$mesh.meshb" "$out/$mesh.vtu" --sol "$out/$mesh.solb" >/dev/null
done
say "Results in $out: meshes (.meshb), their metrics (.solb), reports (*-report/report.html, report.json), the task graph
(parts-graph.svg); for ParaView:"
ls -1 "$out"/*.vtu
