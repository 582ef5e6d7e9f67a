"""prehend's robot editor: robots of any file that `prehend model` reads, in Blender.

docs/robot_editor.md says how it is used, model.py how a robot is kept in a scene.
"""

bl_info = {
    "name": "prehend robot editor",
    "author": "prehend",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "View3D > Sidebar > prehend; File > Import, Export",
    "description": "Links, joints, inertia, collision shapes, tactile pads and preshapes of robots",
    "category": "Import-Export",
}

from . import (check, collision, hand, import_export, inertia, joints, jog, model, pads, panels,
               program)

_MODULES = (program, model, import_export, joints, inertia, collision, pads, hand, check, jog,
            panels)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
