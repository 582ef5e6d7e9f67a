"""Every third robot that `prehend model` reads (with PREHEND_THOROUGH_TESTS in the environment every
one) goes through the editor and comes out the same."""

import json
import os
import pathlib
import sys
import tempfile
import time

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from editor import ARGUMENTS, clear, do, model, prehend, program  # noqa: E402

_ORIGIN = {"position": [0.0, 0.0, 0.0], "quaternion": [1.0, 0.0, 0.0, 0.0]}
_ENDINGS = (".urdf", ".sdf", ".xml", ".dae", ".zae")


def robots(shared):
    for folder in ("models", "robots"):
        for file in sorted((shared / folder).rglob("*")):
            if file.suffix.lower() in _ENDINGS and file.is_file():
                yield file


def differences(one, other, path=""):
    """Where two JSON values differ by more than rounding; meshes' names may."""
    if path.endswith("pose"):  # absent is at the origin
        one, other = one or _ORIGIN, other or _ORIGIN
    if isinstance(one, dict) and isinstance(other, dict):
        for key in sorted(set(one) | set(other)):
            if key != "mesh":
                yield from differences(one.get(key), other.get(key), f"{path}.{key}")
    elif path.endswith("quaternion") and one and other:  # q and -q are one rotation
        if min(max(abs(a - sign * b) for a, b in zip(one, other)) for sign in (1, -1)) > 1e-14:
            yield f"{path}: {one} {other}"
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for i, pair in enumerate(zip(one, other)):
            yield from differences(*pair, f"{path}[{i}]")
    elif one != other:
        yield f"{path}: {str(one)[:60]} {str(other)[:60]}"


def main():
    shared = pathlib.Path(ARGUMENTS[0])
    step = 1 if os.environ.get("PREHEND_THOROUGH_TESTS") else 3
    seconds, count, meshes, unread = 0.0, 0, 0, set()
    with tempfile.TemporaryDirectory() as folder:
        again = pathlib.Path(folder) / "again.robot.json"
        for file in list(robots(shared))[::step]:
            read = pathlib.Path(folder) / "read.robot.json"
            code, _ = program.run("model", "convert", file, read)
            if code != 0:
                continue  # parts, worlds, faults that are wanted
            clear()
            begin = time.monotonic()
            do("import_robot", filepath=str(file))
            unread.update(line.split(": ", 1)[1].split(";")[0]
                          for line in bpy.data.texts["prehend report"].as_string().splitlines()
                          if line.endswith("it is kept by its name"))
            robot = model.robots()[0]
            links = len(model.things(robot, "link"))
            meshes += sum(1 for one in model.things(robot, "shape") if one.data is not None)
            do("export_robot", filepath=str(again))
            seconds += time.monotonic() - begin
            said = prehend("model", "diff", file, again, "--samples", "50")
            assert links > 0 and len(said.strip().splitlines()) == 1, f"{file}: {said}"
            with open(read, encoding="utf-8") as first, open(again, encoding="utf-8") as second:
                differ = list(differences(json.load(first), json.load(second)))
            assert not differ, f"{file}: {differ[:5]}"
            report = bpy.data.texts["prehend report"].as_string()
            assert report.startswith("Wrote "), report
            count += 1
    print(f"{count} robots with {meshes} shapes that are seen, {seconds:.1f} s")
    print("kept by their names alone:", *sorted(unread), sep="\n  ")
    assert count >= 50 // step


main()
