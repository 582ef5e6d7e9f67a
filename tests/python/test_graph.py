import asyncio
import gc
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import prehend
from graph_here import Registry, program

NODE = """
import prehend

def work(node):
    gain = node.declare_parameter("gain", 2.0, description="of all it hears", minimum=0.0)
    out = node.advertise("/louder", "TactileFrame")
    heard = node.subscribe("/quiet", lambda frame: out.publish({"sum": gain * frame.sum}))
    node.report("listens")
    node.spin()

prehend.run_node(work, "louder", "Says it louder.")
"""


class Graph(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.registry = Registry()

    @classmethod
    def tearDownClass(cls):
        cls.registry.stop()

    def node(self, name, **options):
        node = prehend.Node(name, registry=self.registry.endpoint, **options)
        self.addCleanup(node.close)
        return node

    def test_a_topic_is_heard_in_order(self):
        talker, listener = self.node("talker"), self.node("listener")
        heard = listener.stream("/numbers", queue=1000)
        out = talker.advertise("/numbers", "TactileFrame", queue=1000)
        self.assertTrue(out.wait_for_subscribers(1, 5))
        for i in range(200):
            out.publish({"sum": i, "intensity": np.arange(i, dtype=np.uint32)})
        frames = [heard.next(5) for _ in range(200)]
        self.assertEqual([frame.sum for frame in frames], list(range(200)))
        self.assertEqual(frames[7].intensity.size, 7)
        self.assertEqual(heard.dropped, 0)
        self.assertEqual(prehend.topics(self.registry.endpoint)["/numbers"],
                         "prehend.msgs.TactileFrame")
        self.assertIn("/numbers", prehend.nodes(self.registry.endpoint)["listener"]["subscribes"])
        with self.assertRaises(TimeoutError):
            heard.next(0.1)
        heard.close()
        with self.assertRaises(EOFError):
            heard.next(1)

    def test_latched_messages_come_to_who_is_late(self):
        out = self.node("early").advertise("/kept", "TactileFrame", latched=1)
        out.publish({"sum": 7})
        self.assertEqual(self.node("late").wait_for_message("/kept").sum, 7)
        with self.assertRaises(TimeoutError):
            self.node("later").wait_for_message("/nothing", timeout=0.2)

    def test_it_is_awaited(self):
        out = self.node("a_talker").advertise("/awaited", "TactileFrame", queue=100)
        listener = self.node("a_listener")

        async def hear():
            sums = []
            async for frame in listener.stream("/awaited"):
                sums.append(frame.sum)
                if len(sums) == 20:
                    return sums

        async def both():
            hearing = asyncio.create_task(hear())
            await asyncio.to_thread(out.wait_for_subscribers, 1, 5)
            for i in range(20):
                out.publish({"sum": i})
            return await asyncio.wait_for(hearing, 10)

        self.assertEqual(asyncio.run(both()), list(range(20)))

    def test_a_callback_that_raises_ends_nothing(self):
        out = self.node("talker2").advertise("/raises", "TactileFrame")
        listener, heard = self.node("listener2"), []

        def hear(frame):
            heard.append(frame.sum)
            if len(heard) == 1:
                raise ValueError("not this one")

        kept = listener.subscribe("/raises", hear)
        out.wait_for_subscribers(1, 5)
        for i in range(3):
            out.publish({"sum": i})
        end = time.monotonic() + 5
        while len(heard) < 3 and time.monotonic() < end:
            time.sleep(0.01)
        self.assertEqual(heard, [0, 1, 2])
        self.assertEqual(kept.statistics["received"], 3)
        kept.close()
        with self.assertRaisesRegex(RuntimeError, "closed"):
            kept.statistics

    def test_wrong_use_is_named(self):
        node = self.node("wrong")
        out = node.advertise("/wrong", "TactileFrame")
        with self.assertRaisesRegex(prehend.InputError, "no field 'summ'"):
            out.publish({"summ": 1})
        for call, error, words in (
                (lambda: node.advertise("/x", "Nothing"), prehend.InputError, "no message type"),
                (lambda: node.advertise("no_slash", "Wrench"), ValueError, "no_slash"),
                (lambda: node.subscribe("/x", print, queue=0), ValueError, "1 or more"),
                (lambda: node.subscribe("/x", print, queue="newest"), ValueError, "latest"),
                (lambda: node.subscribe("/x", 5), TypeError, ""),
                (lambda: node.call("/no_service", timeout=0.2), RuntimeError, "no_service"),
                (lambda: node.send_goal("/no_action", timeout=0.2), RuntimeError, "no_action"),
                (lambda: node.parameter("none"), prehend.InputError, "declare_parameter"),
                (lambda: node.declare_parameter("d", {}), TypeError, "bool, int, float, str"),
                (lambda: node.log("x", "loud"), ValueError, "warning"),
                (lambda: node.sleep(float("nan")), ValueError, "no time"),
                (lambda: prehend.Node("clocked", clock="sun"), ValueError, "simulated"),
                (lambda: self.node("wrong"), RuntimeError, "wrong")):
            with self.assertRaisesRegex(error, words):
                call()
        node.close()
        with self.assertRaisesRegex(RuntimeError, "closed"):
            node.advertise("/y", "Wrench")

    def test_a_service_is_offered(self):
        server, client = self.node("serves"), self.node("calls")

        def weigh(request):
            if request.shows_robot:
                raise ValueError("it is too heavy")
            return {"success": True, "reason": "2 kg"}
        with server.serve("/weigh", "RenderRequest", "Acknowledge", weigh) as service:
            self.assertEqual(client.call("/weigh").reason, "2 kg")
            with self.assertRaisesRegex(RuntimeError, "it is too heavy"):
                client.call("/weigh", {"shows_robot": True})
            self.assertIn("/weigh", prehend.nodes(self.registry.endpoint)["serves"]["services"])
        service.close()  # again
        with self.assertRaises(RuntimeError):
            client.call("/weigh", timeout=0.3)
        with server.serve("/none", "Empty", "Acknowledge", lambda _: None):
            self.assertFalse(client.call("/none").success)
        with server.serve("/wrong", "Empty", "Acknowledge", lambda _: {"sucess": True}):
            with self.assertRaisesRegex(RuntimeError, "success"):
                client.call("/wrong")
        with self.assertRaisesRegex(prehend.InputError, "Acknowlege"):
            server.serve("/typed", "Empty", "Acknowlege", weigh)

    def test_an_action_is_offered(self):
        server, client = self.node("acts"), self.node("asks_for_acts")
        kept = []

        def move(goal, context):
            kept.append(context)
            for i in range(1000):
                context.feedback({"opening": 0.001 * i})
                if not context.sleep(0.005) or goal.opening < 0.001 * i:
                    break
            if goal.speed == 0:
                raise ValueError("without a speed")
            return {"reached": not context.cancelled, "opening": goal.opening}
        action = server.serve_action("/wave", "MoveGripperGoal", "MoveGripperFeedback",
                                     "MoveGripperResult", move)
        told = []
        result = client.send_goal("/wave", {"opening": 0.01, "speed": 1},
                                  lambda feedback: told.append(feedback.opening)).wait(10)
        self.assertTrue(result.reached)
        self.assertEqual(told[:3], [0, 0.001, 0.002])
        goal = client.send_goal("/wave", {"opening": 10, "speed": 1})
        self.assertEqual(goal.wait_status(0.1)[0], "timeout")
        goal.cancel()
        status, _, result = goal.wait_status(10)
        self.assertEqual((status, result.reached), ("cancelled", False))
        with self.assertRaisesRegex(prehend.GoalEnded, "without a speed"):
            client.send_goal("/wave", {"opening": 0}).wait(10)
        # What is kept of a goal that has ended does no harm.
        self.assertTrue(kept[0].cancelled)
        with self.assertRaisesRegex(RuntimeError, "ended"):
            kept[0].feedback({"opening": 1})
        # Closed while a goal runs.
        goal = client.send_goal("/wave", {"opening": 10, "speed": 1})
        self.assertEqual(goal.wait_status(0.1)[0], "timeout")
        action.close()
        self.assertNotEqual(goal.wait_status(10)[0], "timeout")

    def test_without_a_graph_it_says_so_soon(self):
        with self.assertRaisesRegex(RuntimeError, "registry"):
            prehend.Node("alone", registry="tcp://127.0.0.1:9", timeout=0.3)

    def test_nodes_that_are_let_go_of_leave(self):
        for i in range(3):
            node = self.node(f"short_{i}")
            kept = node.subscribe("/short", lambda _: None)
            out = node.advertise("/short", "Wrench")
            node = None
            self.doCleanups()
            gc.collect()
            del kept, out
        # They say so themselves: without that they would be there for the lease of three seconds.
        end = time.monotonic() + 2
        while "short_2" in prehend.nodes(self.registry.endpoint):
            self.assertLess(time.monotonic(), end)

    def test_of_a_fork_nothing_is_touched(self):
        node = self.node("forked")
        child = os.fork()
        if child == 0:
            code = 1
            try:
                node.advertise("/x", "Wrench")
            except RuntimeError as error:
                code = 0 if "before a fork" in str(error) else 2
            os._exit(code)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        self.assertTrue(node.ok)

    def test_threads_publish_at_once(self):
        out = self.node("many_talkers").advertise("/many", "TactileFrame", queue=10000)
        heard = self.node("many_hear").stream("/many", queue=10000)
        out.wait_for_subscribers(1, 5)
        threads = [threading.Thread(target=lambda: [out.publish({"sum": 1}) for _ in range(200)])
                   for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sum(heard.next(5).sum for _ in range(800)), 800)

    def test_ctrl_c_ends_a_wait(self):
        script = ("import prehend, sys\n"
                  "node = prehend.Node('waits', registry=sys.argv[1])\n"
                  "print('waits', flush=True)\n"
                  "node.sleep(60)\n")
        waiting = subprocess.Popen([sys.executable, "-c", script, self.registry.endpoint],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertEqual(waiting.stdout.readline(), "waits\n")
        waiting.send_signal(signal.SIGINT)
        _, told = waiting.communicate(timeout=10)
        self.assertIn("KeyboardInterrupt", told)

    def script(self, folder):
        file = pathlib.Path(folder) / "louder.py"
        file.write_text(f"#!{sys.executable}\n" + NODE)
        file.chmod(0o755)
        return file

    def test_a_script_is_a_node(self):
        with tempfile.TemporaryDirectory() as folder:
            file = self.script(folder)
            told = subprocess.run([file, "--help"], capture_output=True, text=True, timeout=20)
            self.assertIn("of all it hears", told.stdout)
            wrong = subprocess.run([file, "--param", "gian:=1", "--registry",
                                    self.registry.endpoint], capture_output=True, text=True,
                                   timeout=20)
            self.assertNotEqual(wrong.returncode, 0)
            self.assertIn("gain", wrong.stderr)
            running = subprocess.Popen([file, "--registry", self.registry.endpoint, "--param",
                                        "gain:=3"], stderr=subprocess.PIPE, text=True)
            node = self.node("asks")
            louder = node.stream("/louder")
            out = node.advertise("/quiet", "TactileFrame")
            self.assertTrue(out.wait_for_subscribers(1, 10))
            out.publish({"sum": 5})
            self.assertEqual(louder.next(5).sum, 15)
            self.assertEqual(prehend.get_parameter("louder", "gain", self.registry.endpoint), "3")
            prehend.set_parameter("louder", "gain", 4, self.registry.endpoint)
            with self.assertRaisesRegex(RuntimeError, "gain"):
                prehend.set_parameter("louder", "gain", -1, self.registry.endpoint)
            running.send_signal(signal.SIGINT)
            running.communicate(timeout=10)
            self.assertEqual(running.returncode, 0)


class Launches(unittest.TestCase):
    def test_a_launch_brings_services_and_actions(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "one.yaml"
            script = Graph.script(self, folder)
            file.write_text("arguments:\n  gain: {default: 1.0, description: of the node}\n"
                            f"nodes:\n  - node: {script}\n    parameters: {{gain: $(gain)}}\n"
                            "  - node: simulation\n")
            registry = Registry()
            self.addCleanup(registry.stop)
            free = registry.endpoint
            registry.stop()
            with prehend.launch(file, registry=free, gain=2.5,
                                output=pathlib.Path(folder) / "out.txt") as launched:
                end = time.monotonic() + 20
                while True:
                    try:
                        node = prehend.Node("asks", registry=free, clock="simulated", timeout=1)
                        break
                    except RuntimeError:
                        self.assertLess(time.monotonic(), end)
                with node:
                    out = node.advertise("/quiet", "TactileFrame")
                    louder = node.stream("/louder")
                    self.assertTrue(out.wait_for_subscribers(1, 15))
                    out.publish({"sum": 2})
                    self.assertEqual(louder.next(5).sum, 5)
                    answer = node.call("/clock/control", {"command": "PAUSE"}, timeout=15)
                    self.assertTrue(answer.paused)
                    before = node.now
                    node.call("/clock/control", {"command": "RESUME"})
                    self.assertTrue(node.sleep(0.05))
                    self.assertGreaterEqual(node.now - before, 5 * 10**7)
                    goal = node.send_goal("/gripper/move", {"opening": 0.03, "speed": 0.02})
                    self.assertEqual(goal.wait_status(0)[0], "timeout")
                    goal.cancel()
                    with self.assertRaises(prehend.GoalEnded) as ended:
                        goal.wait(10)
                    self.assertEqual(ended.exception.status, "cancelled")
                    done = node.send_goal("/gripper/move", {"opening": 0.06, "speed": 0.05})

                    async def ended_well():
                        return await done

                    self.assertAlmostEqual(asyncio.run(ended_well()).opening, 0.06, delta=0.001)
            self.assertIsNotNone(launched.returncode)


if __name__ == "__main__":
    unittest.main()
