#!/usr/bin/python3
"""How hard did the hand press in this run, in which phase, and what did the wrist bear?

    how_hard_it_pressed.py RECORDING [--picture FILE]

Reads a recording of the graph (prehend record, or out/demo/recording.mcap of a demo) and prints, for each phase of the
cycle, the greatest sum of each tactile pad and the greatest force at the wrist, both in newtons.
"""

import argparse
import sys

import numpy as np

import prehend
from picture_option import new_picture, picture_option, save_picture


def phases_of(recording):
    """(from [ns], phase) in order, and when they end."""
    return [(one.publish_time, one.message.phase.lower())
            for one in recording.messages(["/cycle/state"])]


def greatest_by_phase(recording, phases):
    """{pad or "wrist": {phase: [N]}}"""
    found = {}
    wanted = [topic for topic in recording.topics
              if topic.startswith("/tactile/") or topic == "/wrench"]
    begins = np.array([begin for begin, _ in phases])
    for one in recording.messages(wanted) if wanted else ():
        at = np.searchsorted(begins, one.publish_time, side="right") - 1
        if at < 0:
            continue
        message = one.message
        if one.topic == "/wrench":
            name, force = "wrist", np.linalg.norm([getattr(message.wrench.force, axis) for axis in "xyz"])
        else:
            name, force = one.topic.removeprefix("/tactile/"), message.sum
        by_phase = found.setdefault(name, {})
        by_phase[phases[at][1]] = max(by_phase.get(phases[at][1], 0.0), float(force))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", help="MCAP file")
    words, picture = picture_option(sys.argv[1:])
    recording = prehend.Recording(parser.parse_args(words).recording)
    if "/cycle/state" not in recording.topics:
        raise SystemExit("The recording has no /cycle/state: nothing was grasped in it.")
    phases = phases_of(recording)
    order = list(dict.fromkeys(phase for _, phase in phases))
    print("greatest force [N]".ljust(20), *(phase.rjust(9) for phase in order))
    greatest = greatest_by_phase(recording, phases)
    for name, by_phase in sorted(greatest.items()):
        print(name.ljust(20), *(f"{by_phase[phase]:9.1f}" if phase in by_phase else " " * 9
                                for phase in order))
    for problem in recording.problems:
        print("problem:", problem)
    if picture:
        figure, axes = new_picture("Greatest force by phase [N]")
        for name, by_phase in sorted(greatest.items()):
            axes.plot(order, [by_phase.get(phase, float("nan")) for phase in order], marker="o", label=name)
        axes.set(ylabel="force [N]")
        axes.tick_params(axis="x", rotation=30)
        axes.legend()
        save_picture(figure, picture)


if __name__ == "__main__":
    main()
