"""What the scripts of these tests have in common: the add-on is registered, its operators are
called; what is wrong raises, which --python-exit-code makes an exit code."""

import json
import os
import pathlib
import subprocess
import sys

import bpy

_ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(_ROOT / "tools" / "blender"))

import prehend_robot_editor  # noqa: E402
from prehend_robot_editor import model, program  # noqa: E402

prehend_robot_editor.register()
ARGUMENTS = sys.argv[sys.argv.index("--") + 1:]


def clear():
    """A scene with nothing in it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def do(name, /, **words):
    """An operator of the add-on; raises what it says when it does not do it."""
    done = getattr(bpy.ops.prehend, name)(**words)
    if done != {"FINISHED"}:
        raise AssertionError(f"{name}: {done}")


def refused(name, /, **words):
    """What an operator that must refuse says."""
    try:
        done = getattr(bpy.ops.prehend, name)(**words)
    except RuntimeError as error:
        return str(error)
    raise AssertionError(f"{name} was done: {done}")


def prehend(*words, code=0):
    """What the program prints. Raises when its exit code is another one."""
    done = subprocess.run([os.environ["PREHEND"], *map(str, words)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=100,
                          check=False)
    said = done.stdout.decode("utf-8", "replace")
    if done.returncode != code:
        raise AssertionError(f"{words}: exit code {done.returncode}:\n{said}")
    return said


def select(thing):
    for one in bpy.context.selected_objects:
        one.select_set(False)
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing


def exported(robot, file):
    """The JSON of a robot, written to a file."""
    select(robot)
    do("export_robot", filepath=str(file))
    with open(file, encoding="utf-8") as stream:
        return json.load(stream)
