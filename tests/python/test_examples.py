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
sys.path.insert(0, str(EXAMPLES))


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

    def test_which_sizes_fit(self):
        said = run("which_sizes_fit.py", "pg70")
        self.assertRegex(said, r"pg70 grasps [2-4]\d of 54 sizes")
        self.assertRegex(said.splitlines()[1], r"\. +\.$")  # 8 and 10 cm are wider than it opens

    def test_noise_and_shape(self):
        with tempfile.TemporaryDirectory() as folder:
            points, width, height = box_on_table()
            cloud = pathlib.Path(folder) / "box.pcd"
            prehend.write_cloud(cloud, prehend.PointCloud(points, width=width, height=height))
            rows = run("noise_and_shape.py", cloud).splitlines()
            volumes = [float(row.split()[1]) for row in rows[1:4]]
            for volume in volumes:  # 576 cm^3
                self.assertTrue(480 < volume < 640, rows)

    def test_way_around_an_obstacle(self):
        rows = run("way_around_an_obstacle.py", "kr5_sdh").splitlines()
        self.assertGreater(float(rows[6].split()[1]), float(rows[1].split()[1]) + 0.5)

    def test_how_slippery(self):
        with tempfile.TemporaryDirectory() as folder:
            mesh = pathlib.Path(folder) / "cube.ply"
            prehend.write_mesh(mesh, prehend.TriangleMesh(*cube()))
            said = run("how_slippery.py", mesh, "pg70", 1.0)
            self.assertRegex(said, r"0\.70 +yes")
            self.assertRegex(said, r"0\.03 +no")

    def test_a_picture_is_drawn(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "reach.png"
            run("map_reach.py", "kr5_sdh", "--picture", file)
            self.assertEqual(file.read_bytes()[:4], b"\x89PNG")
            with self.assertRaises(SystemExit):
                run("map_reach.py", "--picture")

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
