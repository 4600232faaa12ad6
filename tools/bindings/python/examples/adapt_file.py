"""Adapts a mesh to a metric, both from files: adapt_file.py IN.meshb METRIC.solb OUT.meshb"""

import sys

import weft

mesh = weft.read(sys.argv[1])
fine = weft.adapt(mesh, weft.read_metric(sys.argv[2], mesh), hgrad=1.5, threads=1)
weft.write(sys.argv[3], fine)
print(fine.summary(), end="")
