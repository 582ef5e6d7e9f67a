"""A registry of its own for a test, on loopback."""

import os
import pathlib
import subprocess

import prehend


def program(name):
    """Of the build tree that the package is of."""
    return str(pathlib.Path(prehend.__file__).resolve().parents[2] / "bin" / name)


class Registry:
    def __init__(self):
        environment = {k: v for k, v in os.environ.items() if k != "PREHEND_REGISTRY"}
        self._process = subprocess.Popen(
            [program("registry"), "--registry", "tcp://127.0.0.1:*"], stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True, env=environment)
        self.endpoint = next(word for line in self._process.stdout for word in line.split()
                             if word.startswith("tcp://")).rstrip(".,")

    def stop(self):
        self._process.terminate()
        self._process.wait(10)
        self._process.stdout.close()
