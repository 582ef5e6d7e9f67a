"""ros1_bridge beside ROS itself: a real master and rospy."""

import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


# rospy reads these when it is imported.
PORT = free_port()
LOGS = tempfile.TemporaryDirectory()
os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{PORT}", ROS_IP="127.0.0.1",
                  ROS_HOSTNAME="127.0.0.1", ROS_LOG_DIR=LOGS.name)

import genpy.dynamic
import numpy as np
import rospy
from actionlib_msgs.msg import GoalID, GoalStatusArray
from geometry_msgs.msg import TransformStamped, WrenchStamped
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

import prehend
from graph_here import Registry, program

ARM_JOINTS = [f"arm_axis_{i}" for i in range(1, 7)]
RULE = "=" * 80 + "\n"
HEADER = RULE + "MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
GOAL_ID = RULE + "MSG: actionlib_msgs/GoalID\ntime stamp\nstring id\n"
POINT = (RULE + "MSG: trajectory_msgs/JointTrajectoryPoint\nfloat64[] positions\n"
         "float64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
         "duration time_from_start\n")
ACTION_GOAL = ("std_msgs/Header header\nactionlib_msgs/GoalID goal_id\n"
               "control_msgs/FollowJointTrajectoryGoal goal\n" + HEADER + GOAL_ID +
               RULE + "MSG: control_msgs/FollowJointTrajectoryGoal\n"
               "trajectory_msgs/JointTrajectory trajectory\n"
               "control_msgs/JointTolerance[] path_tolerance\n"
               "control_msgs/JointTolerance[] goal_tolerance\nduration goal_time_tolerance\n" +
               RULE + "MSG: trajectory_msgs/JointTrajectory\nstd_msgs/Header header\n"
               "string[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points\n" + POINT +
               RULE + "MSG: control_msgs/JointTolerance\nstring name\nfloat64 position\n"
               "float64 velocity\nfloat64 acceleration\n")
ACTION_RESULT = ("std_msgs/Header header\nactionlib_msgs/GoalStatus status\n"
                 "control_msgs/FollowJointTrajectoryResult result\n" + HEADER + GOAL_ID +
                 RULE + "MSG: actionlib_msgs/GoalStatus\nuint8 PENDING=0\nuint8 ACTIVE=1\n"
                 "uint8 PREEMPTED=2\nuint8 SUCCEEDED=3\nuint8 ABORTED=4\nuint8 REJECTED=5\n"
                 "uint8 PREEMPTING=6\nuint8 RECALLING=7\nuint8 RECALLED=8\nuint8 LOST=9\n"
                 "actionlib_msgs/GoalID goal_id\nuint8 status\nstring text\n" +
                 RULE + "MSG: control_msgs/FollowJointTrajectoryResult\nint32 SUCCESSFUL = 0\n"
                 "int32 INVALID_GOAL = -1\nint32 INVALID_JOINTS = -2\n"
                 "int32 OLD_HEADER_TIMESTAMP = -3\nint32 PATH_TOLERANCE_VIOLATED = -4\n"
                 "int32 GOAL_TOLERANCE_VIOLATED = -5\nint32 error_code\nstring error_string\n")

MAPPING = """
to_ros:
  - {prehend: /wrench, ros: /prehend/wrench, type: geometry_msgs/WrenchStamped}
  - {prehend: /viewer/cloud, ros: /prehend/cloud, type: sensor_msgs/PointCloud2, latched: true}
  - {prehend: /viewer/frames, ros: /tf, type: tf2_msgs/TFMessage}
from_ros:
  - {ros: /wrist, prehend: /wrist, type: geometry_msgs/WrenchStamped}
  - {ros: /talk, prehend: /talk, type: sensor_msgs/JointState}
  - {ros: /rosout_agg, prehend: /unused, type: rosgraph_msgs/Log}
  - {ros: /tf_static, type: tf2_msgs/TFMessage}
camera: {depth: /cam/depth/image, color: /cam/rgb/image, world_frame: world}
arm: {action: /ctrl/follow, loss_time: 1, settle_time: 2, joints: {arm_axis_1: a1}}
"""


def eventually(test, condition, what, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        test.assertLess(time.monotonic(), end, what)
        time.sleep(0.02)


def dynamic(name, text):
    return genpy.dynamic.generate_dynamic(name, text)[name]


class Ros1Bridge(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.master = subprocess.Popen(["rosmaster", "--core", "-p", str(PORT)],
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = time.monotonic() + 20
        while True:
            try:
                socket.create_connection(("127.0.0.1", PORT), 1).close()
                break
            except OSError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)
        rospy.init_node("tester", disable_signals=True, disable_rosout=True)
        cls.registry = Registry()
        cls.folder = tempfile.TemporaryDirectory()
        mapping = pathlib.Path(cls.folder.name) / "mapping.yaml"
        mapping.write_text(MAPPING)
        cls.log = open(pathlib.Path(cls.folder.name) / "log.txt", "w+")
        cls.bridge = subprocess.Popen(
            [program("ros1_bridge"), "--registry", cls.registry.endpoint, "--param",
             f"mapping:={mapping}", "--param", "platform:=kr5_sdh", "--param",
             "platforms:=config/robots"], stdout=cls.log, stderr=cls.log)
        cls.node = prehend.Node("tester", registry=cls.registry.endpoint)

    @classmethod
    def tearDownClass(cls):
        cls.node.close()
        cls.bridge.send_signal(signal.SIGINT)
        cls.bridge.wait(20)
        rospy.signal_shutdown("done")
        cls.master.terminate()
        cls.master.wait(20)
        cls.registry.stop()
        cls.log.close()
        cls.folder.cleanup()

    def said(self):
        self.log.flush()
        return pathlib.Path(self.log.name).read_text()

    def until(self, condition, what):
        eventually(self, condition, lambda: f"{what}: {self.said()}")

    def test_a_wrench_goes_to_ros(self):
        heard = []
        rospy.Subscriber("/prehend/wrench", WrenchStamped, heard.append)
        out = self.node.advertise("/wrench", "Wrench")

        def come():
            out.publish({"header": {"stamp": 1234567890123456789, "frame_id": "wrist"},
                         "wrench": {"force": {"x": 1.5, "y": -2, "z": 1e-9},
                                    "torque": {"z": 0.25}}})
            return heard
        self.until(come, "no wrench came")
        self.assertEqual(heard[0].header.stamp.to_nsec(), 1234567890123456789)
        self.assertEqual(heard[0].header.frame_id, "wrist")
        self.assertEqual((heard[0].wrench.force.x, heard[0].wrench.force.z), (1.5, 1e-9))
        self.assertEqual(heard[0].wrench.torque.z, 0.25)

    def test_a_wrench_comes_from_ros(self):
        heard = self.node.stream("/wrist")
        out = rospy.Publisher("/wrist", WrenchStamped, queue_size=5)
        message = WrenchStamped()
        message.header.stamp = rospy.Time(12, 34)
        message.wrench.force.y = 3

        def come():
            out.publish(message)
            try:
                self.wrench = heard.next(0.2)
                return True
            except TimeoutError:
                return False
        self.until(come, "no wrench came")
        self.assertEqual(self.wrench.wrench.force.y, 3)
        self.assertEqual(self.wrench.header.stamp, 12_000_000_034)

    def test_a_cloud_is_what_is_seen(self):
        heard = []
        rospy.Subscriber("/prehend/cloud", PointCloud2, heard.append)
        points = np.arange(12, dtype=np.float32).reshape(4, 3)
        out = self.node.advertise("/objects", "ObjectHypotheses", latched=1)
        out.publish({"objects": [{"id": 1, "cloud": {
            "count": 4, "stride": 12, "data": points.tobytes()}}]})
        self.until(lambda: heard, "no cloud came")
        cloud = heard[0]
        self.assertEqual(cloud.width * cloud.height, 4)
        self.assertEqual([field.name for field in cloud.fields], ["x", "y", "z", "object", "rgb"])
        seen = np.frombuffer(cloud.data, np.uint8).reshape(4, cloud.point_step)
        np.testing.assert_array_equal(
            np.ascontiguousarray(seen[:, :12]).view(np.float32), points)

    def test_pictures_come_with_where_they_were_taken(self):
        infos = self.node.stream("/camera/info")
        pictures = self.node.stream("/camera/depth")
        depth = rospy.Publisher("/cam/depth/image", Image, queue_size=5)
        color = rospy.Publisher("/cam/rgb/image", Image, queue_size=5)
        info = rospy.Publisher("/cam/depth/camera_info", CameraInfo, queue_size=5)
        static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        frame = TransformStamped()
        frame.header.frame_id, frame.child_frame_id = "world", "eye"
        frame.transform.translation.z = 0.75
        frame.transform.rotation.x = 1  # looks down
        static.publish(TFMessage([frame]))
        taken = []

        def come():
            stamp = rospy.Time.now()
            one = Image(height=2, width=3, encoding="16UC1", step=6,
                        data=np.arange(500, 506, dtype=np.uint16).tobytes())
            two = Image(height=2, width=3, encoding="rgb8", step=9, data=bytes(range(18)))
            three = CameraInfo(height=2, width=3, K=[9, 0, 1, 0, 9, 1, 0, 0, 1])
            for message in (one, two, three):
                message.header.stamp, message.header.frame_id = stamp, "eye"
            info.publish(three)
            depth.publish(one)
            color.publish(two)
            try:
                taken.append(pictures.next(0.3))
            except TimeoutError:
                pass
            return taken and taken[-1].has_color
        self.until(come, "no picture came")
        picture = taken[-1]
        self.assertEqual((picture.width, picture.height), (3, 2))
        self.assertAlmostEqual(picture.unit, 1e-3)
        self.assertEqual(picture.X_WC.position.z, 0.75)
        self.assertEqual(picture.X_WC.orientation.x, 1)
        self.assertEqual(infos.next(10).fx, 9)

    def test_the_log_and_another_type_are_told(self):
        out = rospy.Publisher("/rosout_agg", Log, queue_size=5)
        lines = self.node.stream("/log", queue=200)
        other = rospy.Publisher("/talk", String, queue_size=5)
        self.until(lambda: out.get_num_connections() > 0, "the log has no reader")
        out.publish(Log(level=Log.WARN, name="/arm_driver", msg="it is warm"))
        self.until(lambda: "[/arm_driver] it is warm" in self.said(), "no line came")

        def come():
            other.publish("hello")
            return "std_msgs/String" in self.said()
        self.until(come, "the other type was not told")
        self.assertIn("/talk", self.said())
        lines.close()

    def test_an_arm_follows(self):
        goal_type = dynamic("control_msgs/FollowJointTrajectoryActionGoal", ACTION_GOAL)
        result_type = dynamic("control_msgs/FollowJointTrajectoryActionResult", ACTION_RESULT)
        goals, cancels = [], []
        joints = rospy.Publisher("/joint_states", JointState, queue_size=10)
        results = rospy.Publisher("/ctrl/follow/result", result_type, queue_size=5)
        rospy.Publisher("/ctrl/follow/status", GoalStatusArray, queue_size=1)
        rospy.Subscriber("/ctrl/follow/goal", goal_type, goals.append)
        rospy.Subscriber("/ctrl/follow/cancel", GoalID, cancels.append)
        names = ["a1"] + ARM_JOINTS[1:]
        start = [0.0, 0.5, -0.5, 0.0, 0.3, 0.0]
        timer = rospy.Timer(rospy.Duration(0.02), lambda _: joints.publish(
            JointState(name=names, position=start)))
        self.addCleanup(timer.shutdown)
        told = self.node.stream("/joint_states")
        first = told.next(20)
        self.assertEqual(list(first.name), ARM_JOINTS)
        np.testing.assert_allclose(first.position, start)

        def trajectory(by):
            return {"trajectory": {"joint_name": ARM_JOINTS, "points": [
                {"time": 0, "position": start},
                {"time": 0.5, "position": [q + by for q in start]}]}}

        def follow(by):
            count = len(goals)
            goal = self.node.send_goal("/arm/follow", trajectory(by))
            self.until(lambda: len(goals) > count, "no goal came")
            return goal

        def answer(status, code=0, text=""):
            result = result_type()
            result.status.goal_id = goals[-1].goal_id
            result.status.status = status
            result.result.error_code = code
            result.result.error_string = text
            results.publish(result)

        self.until(lambda: results.get_num_connections() > 0, "nobody reads results")
        goal = follow(0.05)
        sent = goals[-1].goal.trajectory
        self.assertEqual(list(sent.joint_names), names)
        np.testing.assert_allclose(sent.points[-1].positions, [q + 0.05 for q in start])
        self.assertEqual(sent.points[-1].time_from_start.to_sec(), 0.5)
        self.assertEqual(sent.header.stamp.to_sec(), 0)
        answer(3)
        self.assertTrue(goal.wait(10).reached)
        goal = follow(0.05)
        answer(4, -5, "a6 was late")
        ended = goal.wait(10)
        self.assertFalse(ended.reached)
        self.assertIn("goal tolerance violated", ended.reason)
        self.assertIn("a6 was late", ended.reason)
        goal = follow(0.05)
        goal.cancel()
        self.until(lambda: cancels, "no cancel came")
        self.assertEqual(cancels[-1].id, goals[-1].goal_id.id)
        answer(2)
        # Beyond a limit nothing is sent.
        count = len(goals)
        refused = self.node.send_goal("/arm/follow", trajectory(50)).wait(10)
        self.assertIn("outside", refused.reason)
        self.assertEqual(len(goals), count)
        # Its joints fall silent while it moves.
        goal = follow(0.02)
        timer.shutdown()
        cancelled = len(cancels)
        self.until(lambda: len(cancels) > cancelled, "it was not stopped")
        self.assertIn("nothing comes of joint", goal.wait(15).reason)


class WithoutAMaster(unittest.TestCase):
    def test_it_says_so(self):
        registry = Registry()
        self.addCleanup(registry.stop)
        ended = subprocess.run(
            [program("ros1_bridge"), "--registry", registry.endpoint, "--param",
             "mapping:=config/ros/default.yaml", "--param", "patience:=0.2", "--param",
             f"master:=http://127.0.0.1:{free_port()}"], capture_output=True, text=True, timeout=30)
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn("no ROS master answers", ended.stderr + ended.stdout)

    def test_an_arm_needs_a_platform(self):
        registry = Registry()
        self.addCleanup(registry.stop)
        ended = subprocess.run(
            [program("ros1_bridge"), "--registry", registry.endpoint, "--param",
             "mapping:=config/ros/arm.yaml"], capture_output=True, text=True, timeout=30)
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn("platform", ended.stderr + ended.stdout)


if __name__ == "__main__":
    unittest.main(warnings="ignore")  # rospy's
