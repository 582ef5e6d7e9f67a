"""The program `prehend`: where it is, and runs of it."""

import os
import shutil
import subprocess

import bpy

_TIME = 120  # s, for one run at most


class NotDone(RuntimeError):
    """What an operator cannot do, in words for its user."""


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program prehend", subtype="FILE_PATH",
        description="Empty: that which the environment's PREHEND names, or of the path")

    def draw(self, _context):
        self.layout.prop(self, "program")


def path():
    """That of the preferences, else of $PREHEND, else of the path."""
    addon = bpy.context.preferences.addons.get(__package__)
    given = (addon.preferences.program if addon and addon.preferences else "") or \
        os.environ.get("PREHEND", "")
    if given:
        given = bpy.path.abspath(given)
        if not os.access(given, os.X_OK):
            raise NotDone(f"'{given}' is no program. Mend the add-on's preferences or PREHEND")
        return given
    found = shutil.which("prehend")
    if found is None:
        raise NotDone("The program prehend is not found. Name it in the add-on's preferences, "
                      "or by the environment's PREHEND")
    return found


def run(*words):
    """Its exit code, and what it said. Raises NotDone when it does not end."""
    try:
        done = subprocess.run([path(), *map(str, words)], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=_TIME,
                              check=False)
    except subprocess.TimeoutExpired:
        raise NotDone(f"prehend {words[0]} has not ended within {_TIME} s") from None
    return done.returncode, done.stdout.decode("utf-8", "replace")


def tell(title, text):
    """Writes a report to the text block 'prehend report', the newest."""
    block = bpy.data.texts.get("prehend report") or bpy.data.texts.new("prehend report")
    block.clear()
    block.write(f"{title}\n\n{text}")


class Operator(bpy.types.Operator):
    """An operator whose failures are words, and whose every step can be undone."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            said = self.act(context)
        except NotDone as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if said:
            self.report({"INFO"}, said)
        return {"FINISHED"}


def register():
    bpy.utils.register_class(Preferences)


def unregister():
    bpy.utils.unregister_class(Preferences)
