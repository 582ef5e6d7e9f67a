import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import prehend

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(prehend.__file__).resolve().parents[2]
MISSING = [name for name in ("pip", "setuptools", "wheel") if importlib.util.find_spec(name) is None]


@unittest.skipIf(MISSING, f"{', '.join(MISSING)} are missing")
class Wheels(unittest.TestCase):
    def test_a_wheel_has_all_that_it_needs(self):
        with tempfile.TemporaryDirectory() as folder:
            environment = {**os.environ, "PREHEND_BUILD": str(BUILD), "PYTHONPATH": "",
                           "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_NO_INDEX": "1"}
            pip = [sys.executable, "-m", "pip", "--quiet"]
            made = subprocess.run([*pip, "wheel", str(ROOT), "--no-build-isolation", "--no-deps", "-w",
                                   folder], env=environment, capture_output=True, text=True)
            self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
            wheel, = pathlib.Path(folder).glob("prehend-*.whl")
            site = pathlib.Path(folder) / "site"
            put = subprocess.run([*pip, "install", "--no-deps", "--target", str(site), str(wheel)],
                                 env=environment, capture_output=True, text=True)
            self.assertEqual(put.returncode, 0, put.stdout + put.stderr)
            script = "import prehend; print(prehend.__file__, prehend.platform('kr5_sdh').hand)"
            said = subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True,
                                  text=True, env={**os.environ, "PYTHONPATH": str(site)})
            self.assertEqual(said.stdout.split(), [str(site / "prehend" / "__init__.py"), "<Hand",
                                                   "sdh2>"], said.stderr)


if __name__ == "__main__":
    unittest.main()
