"""A mesh of meshio's goes in, an adapted one comes out, and a picture is drawn."""

import meshio
import numpy as np

import weft

weft.to_meshio(weft.box(6)).write("start.vtu")  # stands for a mesh from elsewhere

mesh = meshio.read("start.vtu")
x, y, z = mesh.points.T
mach = np.tanh(30 * (x + 0.3 * y**2 - 0.6))
fine = weft.adapt(mesh, solutions={"mach": mach}, fields={"mach": mach}, complexity=1500, hgrad=1.5)
print(fine.summary())
weft.to_meshio(fine.mesh, fine.fields).write("fine.vtu")
weft.draw("fine.png", fine.mesh, field=fine.fields["mach"], clip="y=0.5", title="Mach number")
