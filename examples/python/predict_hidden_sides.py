#!/usr/bin/python3
"""What does the camera not see of these objects, and how sure is that?

    predict_hidden_sides.py CLOUD.pcd [FOLDER] [--picture FILE]

prints a line for each object on the table; with FOLDER its predicted mesh goes to FOLDER/object_N.ply.
"""

import pathlib
import sys

import prehend
from picture_option import new_picture, picture_option, save_picture


def main(arguments):
    arguments, picture = picture_option(arguments)
    if len(arguments) not in (1, 2):
        sys.exit(__doc__)
    scene = prehend.segment(prehend.read_cloud(arguments[0]))
    completions = scene.complete()
    for note in scene.notes:
        print(f"# {note}")
    print("object  method       sure    l x w x h [mm]       nobody saw")
    for seen, completion in zip(scene.objects, completions):
        if completion.problem:
            print(f"{seen.id:6}  none: {completion.problem}")
            continue
        model = completion.model()
        size = 1000 * (model.mesh.vertices.max(axis=0) - model.mesh.vertices.min(axis=0))
        print(f"{seen.id:6}  {completion.method:11}  {completion.confidence:4.0%}  "
              f"{size[0]:5.0f} x {size[1]:4.0f} x {size[2]:4.0f}   {model.guessed_area:4.0%} of its surface")
        if len(arguments) == 2:
            folder = pathlib.Path(arguments[1])
            folder.mkdir(parents=True, exist_ok=True)
            prehend.write_mesh(folder / f"object_{seen.id}.ply", model.mesh)
    if picture:
        figure, axes = new_picture("What was seen, and what is predicted, by how sure that is", projection="3d")
        for completion in completions:
            if completion.problem:
                continue
            points, predicted = completion.cloud.points, completion.is_predicted
            axes.scatter(*points[~predicted].T, s=1, color="gray")
            drawn = axes.scatter(*points[predicted].T, s=2, c=completion.point_confidence[predicted], vmin=0,
                                 vmax=1, cmap="viridis")
            figure.colorbar(drawn, ax=axes, shrink=0.6)
        axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
        axes.set_aspect("equal")
        save_picture(figure, picture)


if __name__ == "__main__":
    main(sys.argv[1:])
