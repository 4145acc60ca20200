"""Builds the extension by CMake, with the preset `release` of the project."""

import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parents[1]


class BuildByCmake(build_ext):
    """The build folder is the same as for `make python`, so that nothing is compiled twice."""

    def build_extension(self, ext):
        build = ROOT / "build"
        subprocess.run(["cmake", "--preset", "release", "-DBISS_PYTHON=ON",
                        f"-DPython3_EXECUTABLE={sys.executable}"], cwd=ROOT, check=True)
        subprocess.run(["cmake", "--build", build, "--target", "biss_python_module"], check=True)
        target = pathlib.Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(build / "python" / "biss" / target.name, target)


def version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(biss VERSION ([0-9.]+)", text).group(1)


setup(version=version(), ext_modules=[Extension("biss._core", sources=[])],
      cmdclass={"build_ext": BuildByCmake})
