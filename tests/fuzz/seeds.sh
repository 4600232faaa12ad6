#!/usr/bin/env bash
# What fuzzing starts from, one file of each kind at least: files of other programs, and those that weft writes: seeds.sh WEFT FOLDER.
set -euo pipefail
weft=$(realpath "$1")
mkdir -p "$2"
cp "$(dirname "$0")"/../data/formats/*.* "$(dirname "$0")"/../data/*.meshb "$2"
cd "$2"
sed -i 's/weft-box_[01]/piece/' weft-box.pvtu  # that piece is there when it is read (readers.cpp)
"$weft" mesh box -o box.meshb --cells 1 1 1 >log
"$weft" adapt box.meshb --metric-fn uniform:0.9 -o one.meshb --threads 1 --checkpoint one --checkpoint-every 0.001 >>log
"$weft" adapt box.meshb --metric-fn uniform:0.9 -o two.meshb --threads 1 --subdomains 2 --report . >>log
for checkpoint in one/*/; do
  cp "${checkpoint}rank-0" state.rank
  cp "${checkpoint}complete" state.manifest
done
cat >loop.json <<END
{"mesh": "box.meshb", "solver": "solve {mesh} {solution}", "complexities": [300, 600], "metric": {"norm": 2, "hgrad": 1.5},
 "adapt": {"threads": 1, "subdomains": 2}, "transfer": "conservative"}
END
cat >done.json <<END
{"schema": "weft-cycle-1", "cycle": 0, "settings": {"solver": "false", "solution_extension": ".solb", "mesh": "input.json"},
 "goal_met": true, "solver_seconds": 0.5}
END
printf '2\n1 4000 wall\n2 5000 far field\n' >names.mapbc
rm -r one log report.html README.md
