#!/usr/bin/env python3
"""Makes a wheel of the module as cmake installs it, with libweft.so and its parts beside it. Needs no network."""

import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile

SETUP = '''
import setuptools
from setuptools.dist import Distribution

class Compiled(Distribution):
    def has_ext_modules(self):
        return True

setuptools.setup(
    name="weft", version={version!r}, description="Adapts tetrahedral meshes to anisotropic metric fields",
    license="LGPL-3.0-or-later", packages=["weft"], package_data={{"weft": ["*"]}}, distclass=Compiled,
    install_requires=["numpy"], python_requires=">=3.8", zip_safe=False)
'''


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, required=True, help="the build tree")
    parser.add_argument("--where", required=True, help="the folder of the module below a prefix")
    parser.add_argument("--library", type=pathlib.Path, required=True, help="libweft.so")
    parser.add_argument("--soname", required=True, help="the name by which programs look for it")
    parser.add_argument("--parts", type=pathlib.Path, nargs="+", required=True, help="libraries that it loads by name")
    parser.add_argument("--version", required=True)
    parser.add_argument("--to", type=pathlib.Path, required=True, help="the folder of the wheel")
    options = parser.parse_args()
    options.to.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        subprocess.run(["cmake", "--install", str(options.build), "--component", "python", "--prefix",
                        str(folder / "prefix")], check=True, stdout=subprocess.DEVNULL)
        shutil.move(folder / "prefix" / options.where / "weft", folder / "weft")
        shutil.copy(options.library, folder / "weft" / options.soname)
        for part in options.parts:
            shutil.copy(part, folder / "weft")
        (folder / "setup.py").write_text(SETUP.format(version=options.version))
        done = subprocess.run([sys.executable, "setup.py", "-q", "bdist_wheel", "-d", str(options.to.resolve())],
                              cwd=folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"make_wheel: {done.stdout}{done.stderr}")
    print(*(wheel.name for wheel in options.to.glob("*.whl")), sep="\n")


if __name__ == "__main__":
    main()
