"""The site is built without warnings, its links lead somewhere, and the blocks of the guide run as they stand."""

import html.parser
import os
import pathlib
import re
import subprocess
import tempfile
import unittest
import urllib.parse

SOURCES = pathlib.Path(os.environ["WEFT_SOURCES"])
BUILD = pathlib.Path(os.environ["WEFT_BUILD"])
SITE = BUILD / "doc" / "html"
MPIRUN = os.environ["WEFT_MPIRUN"].split(";")
INCLUDES = [f"-I{folder}" for folder in os.environ["WEFT_INCLUDES"].split(";")]
PYTHON = os.environ.get("WEFT_PYTHON", "")
SECONDS = 250


def run(*words, **more):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=SECONDS, **more)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, words))}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


class Page(html.parser.HTMLParser):
    """The links and anchors of a page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loads, self.anchors = set(), set(), set()
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name"):
                self.anchors.add(value)
            elif value and name == "href":
                (self.loads if tag == "link" else self.links).add(value)
            elif value and name == "src":
                self.loads.add(value)


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not os.environ["WEFT_DOXYGEN"]:
            raise unittest.SkipTest("SKIPPED: no Doxygen: scripts/setup.sh --all")
        cls.told = run("cmake", "--build", BUILD, "--target", "doc")
        cls.pages = {path.relative_to(SITE).as_posix(): Page(path) for path in SITE.rglob("*.html")
                     if path.parent.name != "search"}

    def test_it_is_built_without_warnings(self):
        self.assertNotRegex(self.told, r"(?i)warning|error")

    def test_all_links_lead_to_a_page_and_a_place_on_it(self):
        checked = 0
        for name, page in self.pages.items():
            for link in page.links | page.loads:
                target = urllib.parse.urlsplit(link)
                if target.scheme or link.startswith(("javascript:", "$relpath")):
                    continue
                file = os.path.normpath(os.path.join(os.path.dirname(name), target.path)) if target.path else name
                place = urllib.parse.unquote(target.fragment)
                self.assertTrue((SITE / file).exists(), f"{name}: {link}")
                if place and file in self.pages:
                    self.assertIn(place, self.pages[file].anchors, f"{name}: {link}")
                checked += 1
        self.assertGreater(checked, 1000)

    def test_nothing_is_loaded_from_elsewhere(self):
        for name, page in self.pages.items():
            self.assertEqual([load for load in page.loads if load.startswith("http") or load.startswith("//")], [], name)

    def test_guide_command_and_references_are_reached_from_the_first_page(self):
        links = {link.split("#")[0] for link in self.pages["index.html"].links}
        for page in ("guide.html", "command.html", "python.html", "fortran.html", "petsc.html", "method.html", "figures.html"):
            self.assertIn(page, links)
        self.assertIn("weft-adapt", self.pages["command.html"].anchors)
        self.assertIn("--hgrad-space", (SITE / "command.html").read_text())
        self.assertTrue(any("weft-c_8h" in link for link in links))
        if PYTHON:
            python = (SITE / "python.html").read_text()
            for text in ("progress, cancel", "ghost_owners: np.ndarray", "conservative", "class weft.InputError"):
                self.assertIn(text, python)


class Guide(unittest.TestCase):
    """The blocks share a folder and build on each other."""

    def run_block(self, language, text, folder, environment):
        if language == "sh":
            run("bash", "-euo", "pipefail", "-c", text, cwd=folder, env=environment)
            return
        if language == "python":
            if not PYTHON:
                self.skipTest("SKIPPED: no module for Python: the guide's last block is not run")
            run(PYTHON, "-B", "-c", text, cwd=folder, env=environment)
            return
        source = folder / f"block.{language}"
        source.write_text(text)
        compiler = [os.environ["WEFT_CXX"], "-std=c++20"] if language == "cpp" else [os.environ["WEFT_CC"], "-std=c99"]
        run(*compiler, "-DOMPI_SKIP_MPICXX", "-DMPICH_SKIP_MPICXX", *INCLUDES, source, "-o", folder / language,
            f"-L{BUILD}/lib", f"-Wl,-rpath,{BUILD}/lib", "-lweft")
        run(folder / language, cwd=folder, env=environment)

    def test_every_block_runs(self):
        blocks = re.findall(r"^```(\w+)\n(.*?)^```$", (SOURCES / "tools/doc/guide.md").read_text(), re.M | re.S)
        self.assertEqual({language for language, _ in blocks}, {"sh", "cpp", "c", "python"})
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            mpirun = folder / "bin" / "mpirun"
            mpirun.parent.mkdir()
            mpirun.write_text("#!/bin/sh\nexec " + " ".join(MPIRUN) + ' "$@"\n')
            mpirun.chmod(0o755)
            environment = dict(os.environ, PATH=f"{mpirun.parent}:{BUILD}/bin:{os.environ['PATH']}")
            for language, text in blocks:
                self.run_block(language, text, folder, environment)
            for mesh in ("layer", "fine", "parallel", "from-cpp", "from-c", "from-python"):
                self.assertTrue((folder / f"{mesh}.meshb").exists(), mesh)


if __name__ == "__main__":
    unittest.main()
