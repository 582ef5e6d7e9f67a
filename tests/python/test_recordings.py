import gc
import pathlib
import tempfile
import unittest

import numpy as np

import prehend


class Recordings(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.file = pathlib.Path(self._folder.name) / "a.mcap"

    def tearDown(self):
        self._folder.cleanup()

    def write(self, count=10):
        with prehend.RecordingWriter(self.file) as writer:
            for i in range(count):
                writer.write("/joint_states", {"name": ["a"], "position": np.array([0.5 * i])},
                             time=i * 10**9, type="JointState")
                writer.write("/touch", {"header": {"stamp": i}, "rows": 1, "columns": 2,
                                        "intensity": [i, 2 * i]}, time=i * 10**9,
                             type="prehend.msgs.TactileFrame", latched=1)

    def test_what_is_written_is_read(self):
        self.write()
        recording = prehend.Recording(self.file)
        self.assertEqual(recording.topics["/touch"], ("prehend.msgs.TactileFrame", 10))
        self.assertEqual((recording.start_time, recording.end_time), (0, 9 * 10**9))
        frames = [one.message for one in recording.messages(["/touch"])]
        self.assertEqual([frame.header.stamp for frame in frames], list(range(10)))
        np.testing.assert_array_equal(frames[3].intensity, [3, 6])
        self.assertEqual(recording.problems, [])

    def test_any_time_can_be_begun_at(self):
        self.write()
        recording = prehend.Recording(self.file)
        some = [one for one in recording.messages(["/joint*"], start=2.5, end=5)]
        self.assertEqual([one.publish_time for one in some], [3 * 10**9, 4 * 10**9, 5 * 10**9])
        self.assertEqual(some[0].message.position[0], 1.5)
        self.assertEqual(len(list(recording.messages())), 20)
        for start, end in ((-1, None), (float("nan"), None), (3, 2)):
            with self.assertRaises(ValueError):
                recording.messages(start=start, end=end)

    def test_arrays_view_their_message_and_outlive_the_recording(self):
        self.write()
        one = next(iter(prehend.Recording(self.file).messages(["/touch"], start=4)))
        intensity = one.message.intensity
        del one
        gc.collect()
        np.testing.assert_array_equal(intensity, [4, 8])
        self.assertFalse(intensity.flags.owndata)
        with self.assertRaises(ValueError):
            intensity[0] = 1

    def test_messages_are_copied_whatever_their_type(self):
        self.write(2)
        other = self.file.with_name("b.mcap")
        with prehend.RecordingWriter(other, compression="zstd") as writer:
            for one in prehend.Recording(self.file).messages():
                writer.write(one.topic, one, one.publish_time)
                if one.topic == "/touch":
                    writer.write("/again", one.message, one.publish_time)
        self.assertEqual(sorted(prehend.Recording(other).topics), ["/again", "/joint_states", "/touch"])

    def test_wrong_input_is_named(self):
        with prehend.RecordingWriter(self.file) as writer:
            writer.write("/j", {}, 0, type="JointState")
            for message, error, words in (
                    ({"positon": [1.0]}, prehend.InputError, 'did you mean "position"'),
                    ({"position": ["x"]}, TypeError, "JointState.position"),
                    ({"position": np.zeros(2, bool)}, TypeError, "bool"),
                    ({"name": "abc"}, TypeError, "give a list"),
                    ({"header": {"stamp": 2**63}}, ValueError, "Header.stamp"),
                    ({"header": {"stamp": 0.5}}, TypeError, "a whole number"),
                    ({"header": 3}, TypeError, "a prehend.Message or a dict"),
                    ([1], TypeError, "a prehend.Message or a dict")):
                with self.assertRaisesRegex(error, words):
                    writer.write("/j", message, 1)
            with self.assertRaisesRegex(TypeError, "not prehend.msgs.Wrench"):
                writer.write("/j", {}, 1, type="Wrench")
            with self.assertRaisesRegex(prehend.InputError, "no message type 'Wrensh'"):
                writer.write("/w", {}, 1, type="Wrensh")
            with self.assertRaisesRegex(TypeError, "type of /w is not known"):
                writer.write("/w", {}, 1)
            with self.assertRaisesRegex(ValueError, "begin with /"):
                writer.write("w", {}, 1, type="Wrench")
            with self.assertRaisesRegex(ValueError, "negative"):
                writer.write("/j", {}, -1)
        with self.assertRaisesRegex(ValueError, "is closed"):
            writer.write("/j", {}, 1)
        self.assertEqual(prehend.Recording(self.file).topics["/j"][1], 1)
        with self.assertRaisesRegex(prehend.InputError, "exists"):
            prehend.RecordingWriter(self.file)
        with self.assertRaisesRegex(ValueError, "none, lz4 or zstd"):
            prehend.RecordingWriter(self.file.with_name("x"), compression="gzip")
        with self.assertRaisesRegex(prehend.InputError, "no topic /k"):
            prehend.Recording(self.file).messages(["/k"])

    def test_what_is_no_recording_is_refused(self):
        self.file.write_bytes(b"nothing of that kind")
        with self.assertRaisesRegex(prehend.InputError, "no.* MCAP"):
            prehend.Recording(self.file)
        with self.assertRaises(prehend.InputError):
            prehend.Recording(self.file.with_name("none"))

    def test_what_is_cut_off_is_read_as_far_as_it_goes_and_said(self):
        self.write(2000)
        whole = self.file.read_bytes()
        self.file.write_bytes(whole[:len(whole) // 2])
        recording = prehend.Recording(self.file)
        self.assertLess(len(list(recording.messages())), 4000)
        self.assertTrue(recording.problems)


if __name__ == "__main__":
    unittest.main()
