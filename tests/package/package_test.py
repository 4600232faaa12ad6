"""weft installed, its prefix moved, and programs built against it by CMake and by pkg-config."""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

SOURCES = pathlib.Path(__file__).resolve().parent
BUILD = os.environ["WEFT_BUILD"]
CXX = os.environ["WEFT_CXX"]
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
MPICC = os.environ["WEFT_MPICC"]
SECONDS = 250


def run(*words, **more):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=SECONDS, **more)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, words))}\n{done.stdout}{done.stderr}")
    return done.stdout


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        run("cmake", "--install", BUILD, "--prefix", cls.folder / "first", "--strip")
        cls.prefix = cls.folder / "somewhere else" / "moved"
        cls.prefix.parent.mkdir()
        shutil.move(cls.folder / "first", cls.prefix)
        cls.programs = cls.folder / "programs"
        run("cmake", "-S", SOURCES, "-B", cls.programs, f"-DCMAKE_PREFIX_PATH={cls.prefix}",
            f"-DCMAKE_CXX_COMPILER={CXX}", "-DCMAKE_BUILD_TYPE=Release")
        run("cmake", "--build", cls.programs, "--parallel", "2")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_the_moved_command_runs(self):
        self.assertIn("weft", run(self.prefix / "bin" / "weft", "--version"))

    def test_the_public_headers_are_installed(self):
        headers = {p.relative_to(self.prefix / "include").as_posix() for p in (self.prefix / "include").rglob("*.h")}
        headers.discard("weft_petsc.h")  # where PETSc is
        self.assertEqual(headers, {"weft/weft.h", "weft/data.h", "weft/replay.h", "weft/on_ranks.h", "weft/weft-c.h"})

    def test_only_the_interface_is_exported(self):
        library = next((self.prefix).rglob("libweft.so"))
        symbols = run("nm", "-D", "--defined-only", "-C", library)
        strange = [line for line in symbols.splitlines()
                   if re.search(r" [TWVuB] ", line) and "weft::" not in line
                   and " WEFT_0" not in line and not re.search(r" weft_\w+@@WEFT_C_0$", line)
                   and " WEFT_C_0" not in line]
        self.assertEqual(strange, [])
        self.assertEqual([line for line in symbols.splitlines() if "::detail::" in line], [])
        self.assertNotIn("weft::meshing::Kernel", symbols)
        self.assertNotIn("MPI_", symbols)

    def test_the_library_is_never_unloaded(self):
        """Whoever opens it by name may close it, while threads of oneTBB still run."""
        self.assertIn("NODELETE", run("readelf", "-d", next(self.prefix.rglob("libweft.so"))))

    def test_a_project_that_has_the_sources_keeps_its_own_settings(self):
        host = self.folder / "host"
        host.mkdir()
        (host / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(host CXX)\n"
            f"add_subdirectory({SOURCES.parents[1]} weft EXCLUDE_FROM_ALL)\ninclude(CTest)\n"
            "add_executable(host host.cpp)\ntarget_link_libraries(host PRIVATE weft::weft)\n")
        (host / "host.cpp").write_text("#include <weft/weft.h>\nint main() { return weft::box({}).tets.empty(); }\n")
        run("cmake", "-S", host, "-B", host / "build", "-G", "Ninja", f"-DCMAKE_CXX_COMPILER={CXX}")
        cache = (host / "build" / "CMakeCache.txt").read_text()
        self.assertIn("BUILD_TESTING:BOOL=ON", cache)
        self.assertRegex(cache, "(?m)^CMAKE_BUILD_TYPE:STRING=$")
        commands = run("ninja", "-C", host / "build", "-t", "commands", "host")
        compiled = next(line for line in commands.splitlines() if "host.cpp.o -c" in line)
        self.assertNotRegex(compiled, r" -(O|W|march|f)")

    def test_a_copy_for_some_processors_finds_the_parts_that_are_loaded_by_name(self):
        """As the loader takes it from glibc-hwcaps; level v2, which any machine here has."""
        library = next(self.prefix.rglob("libweft.so.0"))
        copy = library.parent / "glibc-hwcaps" / "x86-64-v2"
        copy.mkdir(parents=True)
        try:
            for file in library.parent.glob("libweft.so.0*"):
                shutil.copy2(file, copy, follow_symlinks=False)
            for name in ("x.step", "x.cgns"):
                (self.folder / name).write_text("nothing\n")
            self.assertEqual(self.loaded_by("mesh", "box", "--cells", "2", "2", "2", "-o", "x.meshb"), {os.path.realpath(copy / "libweft.so.0")})
            for part, *words in [("libweft_cgns.so", "convert", "x.cgns", "y.meshb"), ("libweft_cairo.so", "view", "x.meshb", "-o", "x.png"),
                                 ("libweft_cad.so", "mesh", "x.step", "-o", "y.meshb")]:
                if part == "libweft_cad.so" and not list(library.parent.rglob(part)):
                    continue  # built without OpenCASCADE
                self.assertEqual(self.loaded_by(*words), {os.path.realpath(file) for file in (copy / "libweft.so.0", library.parent / "weft" / part)})
        finally:
            shutil.rmtree(copy.parent)

    def loaded_by(self, *words):
        """Which of weft's own libraries a command loads, as the loader tells it."""
        done = subprocess.run([self.prefix / "bin" / "weft", *words], cwd=self.folder, capture_output=True, text=True, timeout=SECONDS,
                              env=dict(os.environ, LD_DEBUG="files"))
        return {os.path.realpath(file) for file in re.findall(r"calling init: (.*/libweft\S*)", done.stderr)}

    def test_one_mesh(self):
        told = run(self.programs / "one_mesh", cwd=self.folder)
        self.assertRegex(told, r"weft [0-9.]+: \d+ tets")
        run(self.prefix / "bin" / "weft", "verify", "fine.meshb", cwd=self.folder)

    def test_a_solver_loop(self):
        self.assertIn("complexity 2000", run(self.programs / "solver_loop", cwd=self.folder))

    def test_parts_on_mpi_give_the_same_mesh_for_any_number_of_ranks(self):
        told = {ranks: run(*MPIRUN, "-n", ranks, self.programs / "parts_on_mpi") for ranks in (1, 2, 4)}
        summaries = {re.search(r"all: .*", text).group() for text in told.values()}
        self.assertEqual(len(summaries), 1, told)
        self.assertRegex(summaries.pop(), r"volume (1|0\.99999999\d+|1\.00000000\d+)$")
        for ranks, text in told.items():
            self.assertEqual(len(re.findall(r"rank \d: [1-9]\d* tets", text)), ranks)

    def test_by_pkg_config(self):
        pc = next(self.prefix.rglob("weft.pc")).parent
        known = dict(os.environ, PKG_CONFIG_PATH=str(pc))
        flags = shlex.split(run("pkg-config", "--cflags", "--libs", "weft", env=known))
        library = next(self.prefix.rglob("libweft.so")).parent
        run(CXX, "-std=c++20", SOURCES / "one_mesh.cpp", "-o", self.folder / "by-pc", *flags, f"-Wl,-rpath,{library}")
        run(self.folder / "by-pc", cwd=self.folder)


if __name__ == "__main__":
    unittest.main()
