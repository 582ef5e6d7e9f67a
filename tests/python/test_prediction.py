import gc
import threading
import unittest

import numpy as np

import prehend
from scenes import box_on_table, cube


class Prediction(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.size = (0.06, 0.08, 0.12)
        points, width, height = box_on_table(cls.size)
        cls.cloud = prehend.PointCloud(points, width=width, height=height)
        cls.scene = prehend.segment(cls.cloud)
        cls.completion = cls.scene.complete()[0]
        cls.model = cls.completion.model()

    def test_one_object_stands_on_the_table(self):
        self.assertEqual(len(self.scene), 1)
        seen = self.scene.objects[0]
        self.assertEqual(seen.mask.shape, (self.cloud.height, self.cloud.width))
        self.assertEqual(self.scene.depth.shape, seen.mask.shape)
        normal, offset = self.scene.table
        np.testing.assert_allclose(normal, [0, 0, 1], atol=1e-6)
        self.assertAlmostEqual(offset, 0, 6)
        self.assertAlmostEqual(seen.cloud.points[:, 2].max(), self.size[2], delta=0.003)
        self.assertAlmostEqual(np.linalg.norm(self.scene.camera_pose[:3, :3] @ [0, 0, 1.0]), 1, 9)

    def test_what_was_not_seen_is_predicted(self):
        completion = self.completion
        self.assertEqual(completion.problem, "")
        self.assertGreater(completion.confidence, 0.5)
        self.assertEqual(len(completion.is_predicted), len(completion.cloud))
        self.assertTrue(0 < completion.is_predicted.sum() < len(completion.cloud))
        mesh = self.model.mesh
        self.assertTrue(mesh.is_watertight)
        self.assertAlmostEqual(mesh.volume / np.prod(self.size), 1, delta=0.15)
        self.assertEqual(len(self.model.vertex_origin), len(mesh.vertices))
        self.assertGreater(sum(piece.volume for piece in self.model.convex_pieces), 0.9 * mesh.volume)

    def test_parts_outlive_the_whole(self):
        mask = prehend.segment(self.cloud).objects[0].mask
        points = prehend.segment(self.cloud).complete()[0].cloud.points
        gc.collect()
        self.assertEqual(set(np.unique(mask)), {0, 255})
        self.assertTrue(np.isfinite(points).all())

    def test_grasps_are_ranked_and_all_candidates_accounted_for(self):
        plan = prehend.plan_grasps(self.model, prehend.hand("pg70"), table=self.scene.table)
        self.assertEqual(plan.problem, "")
        scores = [grasp.score for grasp in plan.grasps]
        self.assertEqual(plan.candidates, len(plan.grasps) + sum(one.count for one in plan.rejections))
        self.assertGreater(len(scores), 0)
        best = plan.grasps[0]
        self.assertEqual(best.tool_pose.shape, (4, 4))
        self.assertAlmostEqual(np.linalg.norm(best.approach_direction), 1, 9)
        again = prehend.plan_grasps(self.model, prehend.hand("pg70"), table=self.scene.table)
        self.assertEqual(scores, [grasp.score for grasp in again.grasps])

    def test_other_threads_go_on_meanwhile(self):
        ticks, ended = [0], threading.Event()

        def tick():
            while not ended.wait(0.001):
                ticks[0] += 1

        thread = threading.Thread(target=tick)
        thread.start()
        prehend.plan_grasps(self.model, prehend.hand("pg70"))
        ended.set()
        thread.join()
        self.assertGreater(ticks[0], 3)

    def test_bad_input_is_said_in_words(self):
        with self.assertRaises(prehend.InputError):
            prehend.segment(prehend.PointCloud(np.zeros((0, 3))))
        with self.assertRaises(prehend.InputError):
            prehend.segment(prehend.PointCloud(np.full((9, 3), np.nan)))
        with self.assertRaisesRegex(ValueError, "tops"):
            prehend.segment(self.cloud, split="top")
        with self.assertRaisesRegex(ValueError, "viewpoint"):
            prehend.segment(self.cloud, viewpoint=np.ones((4, 4)))
        with self.assertRaises(ValueError):
            prehend.segment(self.cloud, table="1 2")
        with self.assertRaisesRegex(ValueError, "unit"):
            prehend.plan_grasps(self.model, prehend.hand("pg70"), table=([0, 0, 2], 0))
        with self.assertRaisesRegex(prehend.InputError, "pg70"):
            prehend.hand("pg71")
        corners, triangles = cube()
        with self.assertRaises(prehend.InputError):
            prehend.model_of_mesh(prehend.TriangleMesh(corners[:0], triangles[:0]))


class Chains(unittest.TestCase):
    """One budget or tolerance for all stages."""

    @classmethod
    def setUpClass(cls):
        points, width, height = box_on_table((0.06, 0.08, 0.12))
        cls.cloud = prehend.PointCloud(points, width=width, height=height)

    def test_tolerance_sets_every_stage(self):
        chain = prehend.chain("pg70", tolerance=0.003)
        self.assertLessEqual(chain.mesh_error, 0.003)
        self.assertEqual({name.split(".")[0] for name in chain.knobs}, {"segmentation", "shape", "plan", "motion"})
        self.assertIn(chain.knobs["shape.thinning"], repr(chain))
        scene = prehend.segment(self.cloud, chain=chain)
        self.assertEqual(scene.chain.knobs, chain.knobs)
        model = scene.complete()[0].model()
        alternatives = int(chain.knobs["shape.alternatives"])
        self.assertLessEqual(len(model.alternatives), alternatives)
        usual = prehend.segment(self.cloud)
        self.assertIsNone(usual.chain)
        self.assertNotEqual(len(model.mesh.vertices), len(usual.complete()[0].model().mesh.vertices))
        hand = prehend.hand("pg70")
        plan = prehend.plan_grasps(model, hand, table=scene.table, chain=chain)
        self.assertEqual(plan.problem, "")
        self.assertNotEqual(plan.candidates, prehend.plan_grasps(model, hand, table=scene.table).candidates)

    def test_what_does_not_apply_is_refused(self):
        with self.assertRaisesRegex(prehend.InputError, "budget"):
            prehend.chain("pg70")
        with self.assertRaises(prehend.InputError):
            prehend.chain("pg70", budget=1, tolerance=0.003)
        with self.assertRaisesRegex(prehend.InputError, "fastest"):
            prehend.chain("pg70", budget=1e-3)
        for wrong in (float("nan"), -1):
            with self.assertRaises(prehend.InputError):
                prehend.chain("pg70", budget=wrong)
        chain = prehend.chain("pg70", tolerance=0.003)
        with self.assertRaisesRegex(prehend.InputError, "alternatives"):
            prehend.segment(self.cloud, chain=chain).complete(alternatives=2)
        model = prehend.segment(self.cloud).complete()[0].model()
        with self.assertRaisesRegex(prehend.InputError, "sdh2"):
            prehend.plan_grasps(model, prehend.hand("sdh2"), chain=chain)
        with self.assertRaisesRegex(prehend.InputError, "budget"):
            prehend.plan_grasps(model, prehend.hand("pg70"), budget=1, chain=chain)


class Robots(unittest.TestCase):
    def test_inverse_kinematics_come_back(self):
        arm = prehend.platform("kr5_sdh")
        self.assertEqual(len(arm.joint_names), 6)
        low, high = arm.limits.T
        generator = np.random.default_rng(3)
        for _ in range(20):
            q = low + (high - low) * generator.uniform(0.2, 0.8, 6)
            pose = arm.forward(q)
            solutions = arm.inverse(pose, seed=q)
            np.testing.assert_allclose(arm.forward(solutions[0]), pose, atol=1e-9)
            np.testing.assert_allclose(solutions[0], q, atol=1e-6)
        far = np.eye(4)
        far[0, 3] = 50
        self.assertEqual(arm.inverse(far), [])

    def test_wrong_sizes_are_named(self):
        arm = prehend.platform("kr5_sdh")
        with self.assertRaisesRegex(ValueError, "6 joints"):
            arm.forward([0, 0])
        with self.assertRaisesRegex(ValueError, "no pose"):
            arm.inverse(np.zeros((4, 4)))


if __name__ == "__main__":
    unittest.main()
