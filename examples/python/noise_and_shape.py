#!/usr/bin/python3
"""How much does the camera's noise change what is predicted?

    noise_and_shape.py CLOUD [--picture FILE]

adds noise along the lines of sight to a recorded cloud (an image, in metres), ten times for each of some deviations, predicts
its largest object each time, and prints the predicted volume, its deviation, and how sure the prediction is of itself.
"""

import sys

import numpy as np

import prehend
from picture_option import new_picture, picture_option, save_picture

DEVIATIONS = [0, 0.0005, 0.001, 0.002, 0.004]  # m
TRIALS = 10


def predicted(cloud, points):
    """(volume [m^3], confidence) of the largest object, or None."""
    noisy = prehend.PointCloud(points, width=cloud.width, height=cloud.height)
    try:
        scene = prehend.segment(noisy)
    except prehend.InputError:
        return None
    if not len(scene):
        return None
    largest = max(range(len(scene)), key=lambda i: len(scene.objects[i].cloud))
    completion = scene.complete()[largest]
    return None if completion.problem else (completion.model().mesh.volume, completion.confidence)


def main(arguments):
    arguments, picture = picture_option(arguments)
    if len(arguments) != 1:
        sys.exit(__doc__)
    cloud = prehend.read_cloud(arguments[0])
    points = np.asarray(cloud.points, dtype=float)
    ways = points / np.maximum(np.linalg.norm(points, axis=1, keepdims=True), 1e-9)
    random = np.random.default_rng(1)
    means, spreads = [], []
    print("noise [mm]   volume [cm^3]   deviation   sure   none")
    for deviation in DEVIATIONS:
        found = [predicted(cloud, (points + ways * random.normal(0, deviation, (len(points), 1)))
                           .astype(np.float32)) for _ in range(TRIALS if deviation else 1)]
        known = np.array([one for one in found if one])
        if not len(known):
            print(f"{1000 * deviation:10.1f}   nothing is predicted")
            means.append(np.nan)
            spreads.append(np.nan)
            continue
        volumes = 1e6 * known[:, 0]
        means.append(volumes.mean())
        spreads.append(volumes.std())
        print(f"{1000 * deviation:10.1f}   {means[-1]:13.1f}   {spreads[-1]:9.1f}   {known[:, 1].mean():4.0%}"
              f"   {len(found) - len(known):4}")
    if picture:
        figure, axes = new_picture("Predicted volume against the camera's noise")
        axes.errorbar([1000 * one for one in DEVIATIONS], means, spreads, marker="o", capsize=4)
        axes.set(xlabel="standard deviation of the noise [mm]", ylabel="volume [cm³]")
        axes.set_ylim(bottom=0)
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
