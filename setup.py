"""The Python package as a wheel: pip wheel . --no-build-isolation --no-deps

Builds the extension by CMake, in build/ where that is configured, and takes config/ along. It is of the interpreter that
builds it, and of Debian's libraries (apt-packages.txt), as the commands are.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent


def version():
    return re.search(r"project\(prehend VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)


class BuildByCMake(build_ext):
    def run(self):
        build = pathlib.Path(os.environ.get("PREHEND_BUILD", ROOT / "build"))
        if not (build / "CMakeCache.txt").is_file():
            subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release",
                            "-D", f"PREHEND_PYTHON={sys.executable}"], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "prehend_python"], check=True)
        made = build / "python" / "prehend"
        built_for = subprocess.run([sys.executable, "-c", "import prehend"], capture_output=True, text=True,
                                   env={**os.environ, "PYTHONPATH": str(build / "python")})
        if built_for.returncode != 0:
            raise SystemExit(f"What {build} has built does not work with {sys.executable}: {built_for.stderr}"
                             "Configure a build tree for it by -D PREHEND_PYTHON=..., and name it by PREHEND_BUILD.")
        package = pathlib.Path(self.build_lib) / "prehend"
        shutil.rmtree(package, ignore_errors=True)
        shutil.copytree(made, package, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copytree(ROOT / "config", package / "config")


setup(version=version(), packages=[], ext_modules=[Extension("prehend._prehend", sources=[])],
      cmdclass={"build_ext": BuildByCMake})
