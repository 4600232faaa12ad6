# A recipe for Spack. Not run here: written by its documentation and its recipes for what weft needs.
from spack.package import *


class Weft(CMakePackage):
    """Adapts tetrahedral meshes to anisotropic metric fields, on threads and over MPI."""

    license("LGPL-3.0-or-later")
    version("main", branch="main")

    variant("python", default=False, description="The module for Python")
    variant("fortran", default=False, description="The module for Fortran")
    variant("cad", default=False, description="CAD models, through OpenCASCADE")
    variant("simgrid", default=False, description="SimGrid's networks for simulated ranks")
    variant("petsc", default=False, description="The adaptor for PETSc: -dm_adaptor weft")
    variant("native", default=False, description="For the processor that it is built on alone")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("fortran", type="build", when="+fortran")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("python@3.9:", type="build")
    generator("ninja")

    depends_on("mpi@3:")
    depends_on("intel-oneapi-tbb")
    depends_on("cgal@5.5:")
    depends_on("ceres-solver")
    depends_on("eigen@3.4:")
    depends_on("fmt@9:")
    depends_on("cli11@2.3:")
    depends_on("nlohmann-json@3.11:")
    depends_on("pugixml")
    depends_on("zlib-api")
    depends_on("cgns@3.4:~mpi")
    depends_on("hdf5~mpi")
    depends_on("cairo+fc+ft+pdf+png+svg")
    depends_on("metis@5:")
    depends_on("opencascade@7.6:7.7", when="+cad")  # from 7.8 on its libraries have other names
    depends_on("simgrid@3.32:", when="+simgrid")
    depends_on("petsc@3.18~hdf5", when="+petsc")  # HDF5 is the serial one of CGNS
    extends("python", when="+python")
    depends_on("py-pybind11@2.10:", when="+python", type="build")
    depends_on("py-numpy", when="+python", type=("build", "run"))

    conflicts("%gcc@:11", msg="C++20")

    def cmake_args(self):
        # WEFT_JAVASCRIPT_DIR: Chart.js and three.js, as Debian's libjs-chart.js and libjs-three lay them out.
        return [
            self.define("WEFT_TESTS", self.run_tests),
            self.define_from_variant("WEFT_NATIVE", "native"),
            self.define_from_variant("WEFT_PYTHON", "python"),
            self.define_from_variant("WEFT_FORTRAN", "fortran"),
            self.define_from_variant("WEFT_CAD", "cad"),
            self.define_from_variant("WEFT_SIMGRID", "simgrid"),
            self.define("WEFT_ARCH", ""),
        ]
