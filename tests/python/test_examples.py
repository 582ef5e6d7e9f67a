import io
import pathlib
import runpy
import sys
import tempfile
import unittest
from contextlib import redirect_stdout

import prehend
from scenes import box_on_table, cube

EXAMPLES = pathlib.Path("examples/python")


def run(name, *arguments):
    """What the example prints."""
    before, sys.argv = sys.argv, [name, *map(str, arguments)]
    try:
        with redirect_stdout(io.StringIO()) as said:
            runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return said.getvalue()
    finally:
        sys.argv = before


class Examples(unittest.TestCase):
    def test_predict_hidden_sides(self):
        with tempfile.TemporaryDirectory() as folder:
            points, width, height = box_on_table()
            cloud = pathlib.Path(folder) / "box.pcd"
            prehend.write_cloud(cloud, prehend.PointCloud(points, width=width, height=height))
            said = run("predict_hidden_sides.py", cloud, folder)
            self.assertRegex(said, r"\n +0  mirror +\d+%")
            self.assertTrue(prehend.read_mesh(pathlib.Path(folder) / "object_0.ply").is_watertight)

    def test_compare_hands(self):
        with tempfile.TemporaryDirectory() as folder:
            mesh = pathlib.Path(folder) / "cube.ply"
            prehend.write_mesh(mesh, prehend.TriangleMesh(*cube()))
            self.assertRegex(run("compare_hands.py", mesh, "pg70"), r"\npg70 +[1-9]")
            wide = pathlib.Path(folder) / "wide.ply"
            prehend.write_mesh(wide, prehend.TriangleMesh(*cube(0.3)))
            self.assertRegex(run("compare_hands.py", wide, "pg70"), r"\npg70 +0 ")

    def test_map_reach(self):
        said = run("map_reach.py", "kr5_sdh")
        self.assertRegex(said, r"kr5_sdh reaches [1-9]\d* of 1369 places")

    def test_how_hard_it_pressed(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "run.mcap"
            with prehend.RecordingWriter(file) as writer:
                for i, phase in enumerate(("APPROACH", "GRASP", "LIFT")):
                    writer.write("/cycle/state", {"phase": phase}, i * 10, type="CycleState")
                    writer.write("/tactile/left", {"sum": 3.0 * i}, i * 10 + 5, type="TactileFrame")
                    writer.write("/wrench", {"wrench": {"force": {"x": 3, "z": -4}}}, i * 10 + 5,
                                 type="Wrench")
            said = run("how_hard_it_pressed.py", file)
            self.assertRegex(said, r"approach +grasp +lift\nleft +0\.0 +3\.0 +6\.0\nwrist +5\.0 +5\.0 +5\.0\n")

    def test_does_it_hold(self):
        with tempfile.TemporaryDirectory() as folder:
            mesh = pathlib.Path(folder) / "cube.ply"
            prehend.write_mesh(mesh, prehend.TriangleMesh(*cube(0.06)))
            self.assertRegex(run("does_it_hold.py", mesh, "bh8"), r"\n +0  spread_0 +\d+% +yes")
            self.assertRegex(run("does_it_hold.py", mesh, "sdh2", 0.3, 0.05), r"\n +0  parallel +\d+% +no")

    def test_where_to_touch(self):
        with tempfile.TemporaryDirectory() as folder:
            points, width, height = box_on_table()
            cloud = pathlib.Path(folder) / "box.pcd"
            prehend.write_cloud(cloud, prehend.PointCloud(points, width=width, height=height))
            self.assertRegex(run("where_to_touch.py", cloud), r"touched: [3-9]\.\d mm before, 0\.\d mm after")

    def test_without_arguments_they_say_what_they_do(self):
        for name in ("predict_hidden_sides.py", "compare_hands.py"):
            with self.assertRaisesRegex(SystemExit, name):
                run(name)


if __name__ == "__main__":
    unittest.main()
