"""prehend: grasping objects that nobody has seen before::

    cloud = prehend.read_cloud("table.pcd")
    scene = prehend.segment(cloud)
    model = scene.complete()[0].model()
    plan = prehend.plan_grasps(model, prehend.hand("sdh2"), table=scene.table)

Lengths are metres, angles radians, poses 4 x 4 arrays; X_WC is the pose of C in W. Arrays of a
cloud, mesh or image are read-only views of its memory. Bad input raises InputError (a ValueError)
that says what, where and what to do; arrays of a wrong type TypeError, of a wrong shape ValueError.
Calls that take long release the interpreter's lock, so that threads go on.
"""

import os
import pathlib

from ._prehend import (
    ActionServer,
    Belief,
    Chain,
    Completion,
    Goal,
    GoalContext,
    Grasp,
    GraspPlan,
    Hand,
    InputError,
    Node,
    ObjectModel,
    Platform,
    PointCloud,
    Probe,
    Publisher,
    RecordedMessage,
    Recording,
    RecordingError,
    RecordingWriter,
    Rejection,
    Scene,
    SeenObject,
    Service,
    Subscription,
    SurfaceOrigin,
    TriangleMesh,
    World,
    WorldState,
    choose_chain as _choose_chain,
    get_parameter,
    model_of_mesh,
    nodes,
    plan_grasps,
    read_cloud,
    read_mesh,
    segment,
    set_parameter,
    topics,
    write_cloud,
    write_mesh,
)
from .graph import GoalEnded, Launch, Stream, launch, run_node
from .messages import Message

__all__ = [
    "ActionServer", "Belief", "Chain", "Completion", "Goal", "GoalContext", "GoalEnded", "Grasp", "GraspPlan", "Hand",
    "InputError", "Launch", "Message", "Node", "ObjectModel", "Platform", "PointCloud", "Probe", "Publisher",
    "RecordedMessage", "Recording", "RecordingError", "RecordingWriter", "Rejection", "Scene", "SeenObject",
    "Service", "Stream", "Subscription", "SurfaceOrigin", "TriangleMesh", "World", "WorldState", "chain",
    "config_folder", "get_parameter", "hand", "launch", "model_of_mesh", "nodes", "plan_grasps", "platform",
    "read_cloud", "read_mesh", "run_node", "segment", "set_parameter", "topics", "write_cloud", "write_mesh",
]


InputError.__doc__ = "Input that cannot be used: the thing, the place and the mend, in words."
RecordingError.__doc__ = "A recording that cannot be written, in words."


def config_folder():
    """The folder of robots, scenes and tasks: $PREHEND_CONFIG, else that of the installation or
    build tree that this module is in. Raises InputError where there is none."""
    given = os.environ.get("PREHEND_CONFIG")
    if given:
        return pathlib.Path(given)
    for above in pathlib.Path(__file__).resolve().parents:
        for folder in (above / "share" / "prehend" / "config", above / "config"):
            if (folder / "robots").is_dir():
                return folder
    raise InputError("There is no folder config/robots above the module prehend. "
                     "Set PREHEND_CONFIG to prehend's folder config.")


def _robot_file(name):
    """config/robots/NAME.yaml, or the file itself where NAME is one."""
    path = pathlib.Path(name)
    if path.suffix == ".yaml" or path.parent != pathlib.Path("."):
        return path
    robots = config_folder() / "robots"
    file = robots / f"{name}.yaml"
    if not file.is_file():
        known = ", ".join(sorted(one.stem for one in robots.glob("*.yaml")))
        raise InputError(f"There is no robot '{name}' in {robots}. Give one of: {known}.")
    return file


def hand(name):
    """A Hand: of config/robots by its name, or a YAML file of one's own."""
    return Hand.read(_robot_file(name))


def platform(name):
    """A Platform: of config/robots by its name, or a YAML file of one's own."""
    return Platform.read(_robot_file(name))


def chain(hand, *, budget=0.0, tolerance=0.0):
    """A Chain for a Hand, or one of config/robots by its name: how segment, complete, model and
    plan_grasps work, chosen together from the chains that were measured (config/fidelity): the most
    often lifted within a budget [s of processor, from a cloud], or the fastest within a
    tolerance [m, mean error of the mesh]. Raises InputError, with the nearest, where none keeps it."""
    if not isinstance(hand, Hand):
        hand = Hand.read(_robot_file(hand))
    return _choose_chain(config_folder() / "fidelity", hand, budget=budget, tolerance=tolerance)
