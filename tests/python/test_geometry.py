import gc
import pathlib
import tempfile
import unittest

import numpy as np

import prehend
from scenes import cube


class Arrays(unittest.TestCase):
    def test_a_view_outlives_its_cloud_and_cannot_be_written(self):
        given = np.arange(12, dtype=np.float64).reshape(4, 3)
        cloud = prehend.PointCloud(given, colors=np.full((4, 3), 7, np.uint8))
        points = cloud.points
        given[:] = 0
        del cloud
        gc.collect()
        np.testing.assert_array_equal(points, np.arange(12).reshape(4, 3))
        self.assertFalse(points.flags.owndata)
        with self.assertRaises(ValueError):
            points[0, 0] = 1

    def test_strides_are_followed(self):
        wide = np.arange(48, dtype=np.float32).reshape(4, 12)
        np.testing.assert_array_equal(prehend.PointCloud(wide[::2, ::-4]).points, wide[::2, ::-4])

    def test_wrong_types_and_shapes_are_named(self):
        good = np.zeros((4, 3), np.float32)
        for wrong in (np.zeros((4, 3), complex), np.full((4, 3), "a"), np.zeros((4, 3), int), [[None] * 3]):
            with self.assertRaisesRegex(TypeError, "points"):
                prehend.PointCloud(wrong)
        for wrong in (np.zeros((4, 2)), np.zeros(12), np.zeros((2, 2, 3))):
            with self.assertRaisesRegex(ValueError, "n x 3"):
                prehend.PointCloud(wrong)
        with self.assertRaisesRegex(TypeError, "colors"):
            prehend.PointCloud(good, colors=good)
        with self.assertRaisesRegex(ValueError, "4 points, 3 colors"):
            prehend.PointCloud(good, colors=np.zeros((3, 3), np.uint8))
        with self.assertRaisesRegex(ValueError, "no image"):
            prehend.PointCloud(good, width=3, height=2)

    def test_a_mesh_knows_its_solid(self):
        mesh = prehend.TriangleMesh(*cube(0.1))
        self.assertTrue(mesh.is_watertight)
        self.assertAlmostEqual(mesh.volume, 1e-3, 12)
        self.assertAlmostEqual(mesh.area, 6e-2, 12)
        np.testing.assert_allclose(mesh.center_of_mass, [0, 0, 0.05], atol=1e-12)
        corners, triangles = cube()
        self.assertFalse(prehend.TriangleMesh(corners, triangles[1:]).is_watertight)
        for wrong in (-1, 8):
            triangles[0, 0] = wrong
            with self.assertRaisesRegex(ValueError, f"vertex {wrong}"):
                prehend.TriangleMesh(corners, triangles)
        with self.assertRaisesRegex(TypeError, "triangles"):
            prehend.TriangleMesh(corners, triangles.astype(float))


class Files(unittest.TestCase):
    def test_come_back_as_they_were(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            cloud = prehend.PointCloud(np.random.default_rng(1).random((50, 3)))
            prehend.write_cloud(folder / "a.pcd", cloud)
            np.testing.assert_array_equal(prehend.read_cloud(folder / "a.pcd").points, cloud.points)
            mesh = prehend.TriangleMesh(*cube())
            prehend.write_mesh(str(folder / "a.ply"), mesh)
            self.assertAlmostEqual(prehend.read_mesh(folder / "a.ply").volume, mesh.volume, 9)
            with self.assertRaisesRegex(prehend.InputError, "none.pcd"):
                prehend.read_cloud(folder / "none.pcd")
            (folder / "bad.ply").write_text("no mesh")
            with self.assertRaises(ValueError):
                prehend.read_mesh(folder / "bad.ply")


if __name__ == "__main__":
    unittest.main()
