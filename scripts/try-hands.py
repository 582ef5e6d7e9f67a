#!/usr/bin/env python3
"""Learns hands from robots' files and plans grasps of the demo's carton with each.

  scripts/try-hands.py [--prehend PROGRAM] [--out FOLDER] [--limit SECONDS] FILE...

Prints a table in Markdown, a line a file: fingers, motors, preshapes, the best grasp with its
preshape, how robust it is, and the seconds from the file to it; or the reason why there is none.
Each hand is left in FOLDER as NAME.yaml. Exit code 1: none of them has a grasp.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import time

CARTON = (0.072, 0.048, 0.115)  # m, as config/scenes/demo.yaml has it


def write_box(path, size):
    x, y, z = size
    corners = [(a * x / 2, b * y / 2, c * z) for c in (0, 1) for b in (-1, 1) for a in (-1, 1)]
    faces = [(1, 3, 2), (2, 3, 4), (5, 6, 7), (6, 8, 7), (1, 2, 5), (2, 6, 5), (3, 7, 4), (4, 7, 8),
             (1, 5, 3), (3, 5, 7), (2, 4, 6), (4, 8, 6)]
    lines = ["v %g %g %g" % corner for corner in corners] + ["f %d %d %d" % face for face in faces]
    path.write_text("\n".join(lines) + "\n")


def run(command, limit):
    """@returns exit code (None: it took too long), standard output, last line of standard error"""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return None, "", "took more than %g s" % limit
    lines = done.stderr.strip().splitlines()
    return done.returncode, done.stdout, lines[-1] if lines else ""


def shortened(words, length=140):
    words = words.replace("|", "/")
    return words if len(words) <= length else words[:length - 3] + "..."


def tried(prehend, file, name, out, carton, limit):
    """@returns the cells of a line of the table after the name, and whether there is a grasp"""
    hand = out / (name + ".yaml")
    begin = time.monotonic()
    code, text, error = run([prehend, "hand", "learn", str(file), "--out", str(hand), "--overwrite"],
                            limit)
    if code != 0:
        return ["", "", "", "", shortened(error.replace(str(file.parent) + "/", ""))], False
    last = [line for line in text.splitlines() if " fingers, " in line][-1]
    words = last.split(": ", 1)[1].split()
    preshapes = text[text.index("preshapes:"):].count("opens by")
    code, text, error = run([prehend, "plan", str(carton), "--hand", str(hand), "--json",
                             "--remedy-budget", "0"], limit)
    cells = [words[0], words[2], str(preshapes)]
    seconds = time.monotonic() - begin
    if code is None or not text:
        return cells + ["%.1f" % seconds, shortened(error)], False
    plan = json.loads(text)
    if not plan["grasps"]:
        return cells + ["%.1f" % seconds, shortened(plan["problem"])], False
    best = max(plan["grasps"], key=lambda grasp: grasp["score"])
    robust = best.get("robustness")
    said = "%s, score %.2f" % (best["preshape"], best["score"])
    if robust is not None:
        said += ", robust %.0f %%" % (100 * robust)
    return cells + ["%.1f" % seconds, said], True


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--prehend", default="build/bin/prehend", help="the program")
    parser.add_argument("--out", default="out/hands", type=pathlib.Path, help="folder of the hands")
    parser.add_argument("--limit", default=60.0, type=float, help="for each step of a hand [s]")
    parser.add_argument("file", nargs="+", type=pathlib.Path)
    choices = parser.parse_args()
    choices.out.mkdir(parents=True, exist_ok=True)
    carton = choices.out / "carton.obj"
    write_box(carton, CARTON)
    print("| file | fingers | motors | preshapes | seconds | grasp of the carton |")
    print("|---|---|---|---|---|---|")
    used, any_grasp = set(), False
    for file in choices.file:
        name = file.stem
        while name in used:
            name += "_2"
        used.add(name)
        cells, has_grasp = tried(choices.prehend, file, name, choices.out, carton, choices.limit)
        any_grasp = any_grasp or has_grasp
        shown = "/".join(file.parts[-2:])
        print("| %s | %s |" % (shown, " | ".join(cells)), flush=True)
    return 0 if any_grasp else 1


if __name__ == "__main__":
    sys.exit(main())
