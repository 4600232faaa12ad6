#!/usr/bin/env python3
"""breakdown.py profile.json > breakdown.svg: the paper's figure, the shares of each rank's time by operation."""

import itertools
import json
import sys

COLOURS = "#2f6fb0 #e07b16 #2f9e77 #b0529c #7aa52b #2aa3bd #c4a000 #8d6e63 #8795a5 #9cc3ea #d4d9e0".split()

profile = json.load(open(sys.argv[1], encoding="utf-8"))
bars = [("all", profile["total"])] + [(f"rank {rank['rank']}", rank) for rank in profile["ranks"]]
print(f'<svg xmlns="http://www.w3.org/2000/svg" width="860" height="{24 * (len(bars) + len(COLOURS)) + 20}" font-family="sans-serif">')
for row, (label, bar) in enumerate(bars):
    ends = [100 * end / sum(bar["seconds"].values()) for end in itertools.accumulate(bar["seconds"].values(), initial=0)]
    print(f'<text y="{24 * row + 16}">{label}</text>')
    for name, colour, begin, end in zip(profile["operations"], COLOURS, ends, ends[1:]):
        print(f'<rect x="{90 + 7.5 * begin}" y="{24 * row}" width="{7.5 * (end - begin)}" height="20" fill="{colour}"><title>{label}: {name} {end - begin:.1f} %</title></rect>')
print(*[f'<text x="90" y="{24 * row + 30}" fill="{colour}">\u25a0 {name}</text>' for row, (name, colour) in enumerate(zip(profile["operations"], COLOURS), len(bars))], "</svg>", sep="\n")
