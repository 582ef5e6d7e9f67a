"""The graph: streams of messages, goals, programs that are nodes, launches."""

import asyncio
import atexit
import collections
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading
import time

from . import _prehend
from ._prehend import Goal, InputError, Node

atexit.register(_prehend._close_nodes)

_TURN = 0.05  # s, how often a wait looks whether the node is still there


class GoalEnded(RuntimeError):
    """A goal that was not done. `status`: failed, cancelled, preempted, server gone; `result`: a
    Message where the server gave one all the same, else None."""

    def __init__(self, status, error, result):
        super().__init__(error or status)
        self.status = status
        self.result = result


def _wait(self, timeout=None):
    """The result, once the goal is done. Raises TimeoutError after `timeout` [s] (the goal goes on)
    and GoalEnded for one that was not done. `await goal` is the same without a timeout."""
    status, error, result = self.wait_status(timeout)
    if status == "ok":
        return result
    if status == "timeout":
        raise TimeoutError(f"{self.action} has not ended within {timeout} s")
    raise GoalEnded(status, error, result)


Goal.wait = _wait
Goal.__await__ = lambda self: asyncio.to_thread(self.wait).__await__()


class Stream:
    """The messages of a topic, one by one, in order:

        for message in node.stream("/touch"): ...
        async for message in node.stream("/touch"): ...

    Ends when the node is shut down. Of what waits, the newest `queue` messages are kept; `dropped`
    counts the others.
    """

    def __init__(self, node, topic, queue=100, latched=0):
        self._node = node
        self._waiting = collections.deque(maxlen=queue)
        self._news = threading.Condition()
        self._awaiting = set()  # (loop, event)
        self.dropped = 0
        self._subscription = node.subscribe(topic, self._take, queue=queue, latched=latched)

    def _take(self, message):
        with self._news:
            self.dropped += len(self._waiting) == self._waiting.maxlen
            self._waiting.append(message)
            self._news.notify()
            for loop, event in self._awaiting:
                loop.call_soon_threadsafe(event.set)

    def next(self, timeout=None):
        """The next message. Raises TimeoutError after `timeout` [s], EOFError when the node has
        been shut down or the stream closed."""
        end = None if timeout is None else time.monotonic() + timeout
        with self._news:
            while not self._waiting:
                if self._subscription is None or not self._node.ok:
                    raise EOFError("the node was shut down, or the stream closed")
                left = _TURN if end is None else min(_TURN, end - time.monotonic())
                if left <= 0:
                    raise TimeoutError(f"no message came within {timeout} s")
                self._news.wait(left)
            return self._waiting.popleft()

    def __iter__(self):
        return self

    def __next__(self):
        try:
            return self.next()
        except EOFError:
            raise StopIteration from None

    def __aiter__(self):
        return self

    async def __anext__(self):
        event = asyncio.Event()
        me = (asyncio.get_running_loop(), event)
        try:
            while True:
                with self._news:
                    if self._waiting:
                        return self._waiting.popleft()
                    if self._subscription is None or not self._node.ok:
                        raise StopAsyncIteration
                    event.clear()
                    self._awaiting.add(me)
                try:
                    await asyncio.wait_for(event.wait(), _TURN)
                except asyncio.TimeoutError:
                    pass
        finally:
            with self._news:
                self._awaiting.discard(me)

    def close(self):
        """Nothing comes any more."""
        if self._subscription is not None:
            self._subscription.close()
            self._subscription = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def _stream(self, topic, queue=100, latched=0):
    """A Stream of the topic's messages. latched: so many of those before come, too."""
    return Stream(self, topic, queue, latched)


def _wait_for_message(self, topic, timeout=5.0, latched=1):
    """The next message of a topic, or the last one that was latched. Raises TimeoutError."""
    with Stream(self, topic, 1, latched) as stream:
        return stream.next(timeout)


Node.stream = _stream
Node.wait_for_message = _wait_for_message


def run_node(work, name, summary="", argv=None):
    """Makes a program of one node, which a launch file can name by its path, of a script:

        def work(node):
            gain = node.declare_parameter("gain", 1.0, unit="", minimum=0.0)
            ...
            node.spin()

        if __name__ == "__main__":
            prehend.run_node(work, "scaler", "Scales what it hears.")

    Parameters have to be declared before anything else is done with the node: that is how --help
    and launches know them. The command line is that of every node (--name, --param, ...). Ends the
    process, with exit code 0, 2 for wrong input, and 1 for any other exception of `work`.
    """
    try:
        code = _prehend.run_node(work, name, summary, list(sys.argv[1:] if argv is None else argv))
    except KeyboardInterrupt:
        code = 0
    except (ValueError, TypeError, RuntimeError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        code = 2 if isinstance(error, (ValueError, TypeError)) else 1
    sys.exit(code)


def _program():
    """The program `prehend`: $PREHEND_PROGRAM, that beside this module, or of the path."""
    given = os.environ.get("PREHEND_PROGRAM")
    if given:
        return given
    for above in pathlib.Path(__file__).resolve().parents:
        if (above / "bin" / "prehend").is_file():
            return str(above / "bin" / "prehend")
    found = shutil.which("prehend")
    if found is None:
        raise InputError("The program prehend is not found. Set PREHEND_PROGRAM to it.")
    return found


class Launch:
    """A launch that runs; with `with`, it is stopped at the end."""

    def __init__(self, process, registry):
        self._process = process
        self.registry = registry

    @property
    def returncode(self):
        """Its exit code; None: it runs. 0 success, 3 nothing can be grasped, else a node failed."""
        return self._process.poll()

    def wait(self, timeout=None):
        """Its exit code, once it has ended by itself. Raises TimeoutError after `timeout` [s]."""
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"the launch has not ended within {timeout} s") from None

    def stop(self, timeout=30.0):
        """Stops all nodes, as Ctrl-C does, and returns the exit code."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            self._process.terminate()
            return self._process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()


def launch(file, registry=None, output=None, **arguments):
    """Starts the nodes of a launch file with its arguments, e.g. launch("demo", speed=0), and
    returns a Launch. registry: endpoint where its registry listens; None: $PREHEND_REGISTRY, else
    that of this machine. output: a file for what it says; None: this process'."""
    words = [_program(), "launch", str(file)]
    if registry is not None:
        words += ["--registry", registry]
    for name, value in arguments.items():
        text = str(value).lower() if isinstance(value, bool) else str(value)
        words.append(f"{name}:={text}")
    if output is None:
        return Launch(subprocess.Popen(words), registry)
    with open(output, "wb") as told:
        return Launch(subprocess.Popen(words, stdout=told, stderr=subprocess.STDOUT), registry)
