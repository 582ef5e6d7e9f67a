#!/usr/bin/python3
"""What does the camera not see of these objects, and how sure is that?

    predict_hidden_sides.py CLOUD.pcd [FOLDER]

prints a line for each object on the table; with FOLDER its predicted mesh goes to FOLDER/object_N.ply.
"""

import pathlib
import sys

import prehend


def main(arguments):
    if len(arguments) not in (1, 2):
        sys.exit(__doc__)
    scene = prehend.segment(prehend.read_cloud(arguments[0]))
    for note in scene.notes:
        print(f"# {note}")
    print("object  method       sure    l x w x h [mm]       nobody saw")
    for seen, completion in zip(scene.objects, scene.complete()):
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


if __name__ == "__main__":
    main(sys.argv[1:])
