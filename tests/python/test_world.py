import signal
import subprocess
import sys
import threading
import unittest

import numpy as np

import prehend
from scenes import box_on_table, cube


def grasped(step=0.001):
    """The SDH-2 with its best grasp of a standing box of 0.3 kg."""
    vertices, triangles = cube(0.06)
    mesh = prehend.TriangleMesh(vertices - [0, 0, vertices[:, 2].min()], triangles)
    hand = prehend.hand("sdh2")
    grasp = prehend.plan_grasps(prehend.model_of_mesh(mesh), hand).grasps[0]
    world = prehend.World(hand, grasp.hand_pose, grasp.preshape, step=step)
    world.add_object("box", mesh, mass=0.3)
    world.move_hand(grasp.open)
    world.run(0.3)
    world.move_hand(grasp.closed + 0.2 * (grasp.closed - grasp.open), until_contact=True)
    world.run(1.5)
    return world


class Worlds(unittest.TestCase):
    def test_what_falls_falls_as_it_should(self):
        away = np.eye(4)
        away[2, 3] = 5
        world = prehend.World(prehend.hand("sdh2"), away, gravity=3.7)
        vertices, triangles = cube(0.05)
        world.add_object("cube", prehend.TriangleMesh(vertices + [0, 0, 2], triangles), mass=1)
        world.run(0.5)
        self.assertAlmostEqual(world.time, 0.5)
        world.add_object("sunk", prehend.TriangleMesh(vertices - [1, 0, 0.02], triangles), mass=1)
        self.assertAlmostEqual(world.object("sunk")["pose"][2, 3], 0.02, delta=1e-4)
        fallen = -world.object("cube")["pose"][2, 3]
        self.assertAlmostEqual(fallen, 3.7 * 0.5**2 / 2, delta=3.7 * 0.5 * 0.001)
        np.testing.assert_allclose(world.object("cube")["velocity"], [0, 0, -3.7 * 0.5], atol=1e-6)

    def test_what_is_lifted_weighs_what_it_weighs(self):
        world = grasped()
        self.assertGreater(sum(pad["sum"] for pad in world.pads.values()), 1)
        up = world.hand_pose
        up[2, 3] += 0.1
        saved = world.save()
        world.carry(up, 1.0)
        world.run(2)
        self.assertTrue(world.carried)
        box = world.object("box")
        self.assertAlmostEqual(box["height"], 0.1, delta=0.005)
        self.assertFalse(box["touches_table"])
        self.assertAlmostEqual(np.linalg.norm(world.wrist[0]), 0.3 * 9.81, delta=0.05)
        first = box["pose"]
        world.restore(saved)
        world.carry(up, 1.0)
        world.step(2000)
        np.testing.assert_array_equal(world.object("box")["pose"], first)

    def test_an_arm_follows_a_path(self):
        arm = prehend.platform("kr5_sdh")
        vertices, triangles = cube(0.2)
        obstacle = prehend.TriangleMesh(vertices + [0.1, 0, 0.5], triangles)
        way = arm.plan_path(arm.home("home"), [arm.home("side")], obstacles=[obstacle])
        np.testing.assert_array_equal(way[0], arm.home("home"))
        np.testing.assert_array_equal(way[-1], arm.home("side"))
        again = arm.plan_path(arm.home("home"), [arm.home("side")], obstacles=[obstacle])
        np.testing.assert_array_equal(way, again)
        world = prehend.World(arm)
        world.follow(np.arange(len(way)) * 3.0, way)
        world.run(3.0 * len(way))
        np.testing.assert_allclose(world.arm_positions, arm.home("side"), atol=1e-6)
        self.assertFalse(world.arm_moves)
        wall = prehend.TriangleMesh(cube(3)[0], cube(3)[1])
        with self.assertRaisesRegex(RuntimeError, "There is no path: .*obstacle 0"):
            arm.plan_path(arm.home("home"), [arm.home("side")], obstacles=[wall])
        for options, words in (({"goals": []}, "goals is empty"), ({"planner": "x"}, "no planner"),
                               ({"goals": [np.zeros(3)]}, "6 joints"), ({"checker": "x"}, "x")):
            with self.assertRaisesRegex(ValueError, words):
                arm.plan_path(arm.home(), **{"goals": [arm.home("side")], **options})

    def test_wrong_use_is_named(self):
        hand = prehend.hand("sdh2")
        world = prehend.World(hand, np.eye(4))
        solid = prehend.TriangleMesh(*cube())
        world.add_object("box", solid, mass=1)
        for call, error, words in (
                (lambda: world.object("bok"), ValueError, "no object 'bok'"),
                (lambda: world.remove_object("bok"), prehend.InputError, "no object 'bok'"),
                (lambda: world.add_object("n", solid, mass=float("nan")), ValueError, "mass"),
                (lambda: world.add_object("n", solid, mass=0), ValueError, "mass"),
                (lambda: world.run(-1), ValueError, "-1"),
                (lambda: world.run(float("nan")), ValueError, "nan"),
                (lambda: world.step(-1), ValueError, "negative"),
                (lambda: world.move_hand([0.0]), ValueError, "7 joints"),
                (lambda: world.move_hand(np.full(7, np.nan)), ValueError, ""),
                (lambda: world.follow([0], [[0]]), RuntimeError, "without an arm"),
                (lambda: world.carry(np.zeros((4, 4)), 1), ValueError, "no pose"),
                (lambda: prehend.World(hand, np.eye(4), "fist"), prehend.InputError, "fist"),
                (lambda: prehend.World(hand, np.eye(4), step=0.0), ValueError, "step")):
            with self.assertRaisesRegex(error, words, msg=words):
                call()
        saved = world.save()
        world.remove_object("box")
        with self.assertRaises(ValueError):
            world.restore(saved)

    def test_one_thread_at_a_time(self):
        world = prehend.World(prehend.hand("sdh2"), np.eye(4))
        refused, ends = [], threading.Event()

        def look():
            while not ends.is_set():
                try:
                    world.time
                except RuntimeError as error:
                    refused.append(str(error))
                    return

        looks = threading.Thread(target=look)
        looks.start()
        for _ in range(100):
            try:
                world.run(0.2)
            except RuntimeError as error:
                refused.append(str(error))
            if refused:
                break
        ends.set()
        looks.join()
        self.assertIn("another thread is using this World", refused[0])

    def test_ctrl_c_ends_a_long_run(self):
        script = ("import prehend, numpy\n"
                  "world = prehend.World(prehend.hand('sdh2'), numpy.eye(4))\n"
                  "print('runs', flush=True)\n"
                  "world.run(1e5)\n")
        runs = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)
        self.assertEqual(runs.stdout.readline(), "runs\n")
        runs.send_signal(signal.SIGINT)
        self.assertIn("KeyboardInterrupt", runs.communicate(timeout=20)[1])


class Beliefs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        points, width, height = box_on_table()
        cloud = prehend.PointCloud(points, width=width, height=height)
        cls.completion = prehend.segment(cloud).complete(alternatives=4, other_methods=True)[0]

    def test_a_touch_moves_the_surface_there(self):
        belief = prehend.Belief(self.completion)
        belief.update()
        self.assertAlmostEqual(sum(belief.weights), 1)
        before = belief.mesh()
        self.assertTrue(before.is_watertight)
        probe = belief.best_probes(1)[0]
        self.assertGreater(probe.gain, 0)
        way = (probe.end - probe.start) / np.linalg.norm(probe.end - probe.start)
        touched = probe.at + 0.004 * way  # the object ends 4 mm sooner
        belief.add_contact(touched, -way, deviation=0.0005)
        belief.add_swept(probe.start, touched - 0.006 * way, 0.006)
        belief.update()
        self.assertFalse(belief.contradicted)
        nearest = [np.linalg.norm(mesh.vertices - touched, axis=1).min()
                   for mesh in (before, belief.mesh())]
        self.assertLess(nearest[1], 0.0025)
        self.assertLess(nearest[1], nearest[0])

    def test_where_it_was_not_seen_it_is_less_sure(self):
        belief = prehend.Belief(self.completion)
        belief.update()
        sites = belief.sites
        self.assertEqual(sites.shape[1], 8)
        seen = sites[:, 7] == 1
        self.assertGreater(sites[~seen, 6].mean(), 2 * sites[seen, 6].mean())
        np.testing.assert_allclose(np.linalg.norm(sites[:, 3:6], axis=1), 1, atol=1e-6)

    def test_wrong_evidence_is_named(self):
        belief = prehend.Belief(self.completion)
        for call in (lambda: belief.add_contact([np.nan, 0, 0]),
                     lambda: belief.add_contact([0, 0, 0], deviation=0.0),
                     lambda: belief.add_contact([0, 0, 0], [0, 0, 3.0]),
                     lambda: belief.best_probes(0),
                     lambda: belief.best_probes(1, radius=-1.0)):
            with self.assertRaises(ValueError):
                call()


if __name__ == "__main__":
    unittest.main()
