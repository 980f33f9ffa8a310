"""Agents: programs that drive a `Robot`, and policies that act on observations.

An agent is any object with one of two methods. `async def run(self, robot, assignment)` is a program: when it returns,
it says STOP. `act(self, observation)` returns an action (3,) in [-1, 1] for each step of a `3we/...` environment around
the same robot; three commands below 5 % for half a second are STOP.

What else it may have: `reset(assignment)`, called as an episode begins; `options`, of `EnvOptions`
`observations` (lidar, pose, velocity and the task's own where it names none), `lidar_beams`, `image_size`,
`control_rate` and `goal_frame`; `privileged = True`, with
which `run` finds `robot.simulation` and `robot_options(episode, place)` may change what the robot is made with. A new
agent is made for each episode.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import unknown_name
from threewe._extras import needed_for
from threewe.benchmark.episodes import Episode
from threewe.benchmark.mlp import STOP_WITHIN, MlpPolicy
from threewe.benchmark.search import SemanticSearch
from threewe.benchmark.tasks import TASKS, Place
from threewe.errors import ConfigError
from threewe.gym.batch import TASK_FIELDS
from threewe.robot import Robot

Observation = dict[str, NDArray[Any]]
OPTIONS = ("observations", "lidar_beams", "image_size", "control_rate", "goal_frame")
"""What an agent that acts may choose; the rest is the run's."""


@dataclass(frozen=True)
class Assignment:
    """What an agent is asked to do. It says nothing of where in the scene the robot is."""

    task: str
    goal: tuple[float, float] | None  # x, y [m] in the robot's `map` frame, of PointNav
    category: str | None  # of what is looked for, of ObjectNav
    time_limit: float  # [s] of robot time
    seed: int  # of the agent's own choices


class Navigator:
    """The robot's own autonomy stack."""

    async def run(self, robot: Robot, assignment: Assignment) -> None:
        """Drives to the goal, or explores."""
        if assignment.goal is not None:
            await robot.move_to(*assignment.goal)
        else:
            await robot.explore()


class Random:
    """Uniform actions, each held for half a second."""

    options: dict[str, Any] = {"observations": ("velocity",)}  # noqa: RUF012

    def reset(self, assignment: Assignment) -> None:
        """Draws anew."""
        self._draws = np.random.default_rng(assignment.seed)
        self._steps = 0

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """An action."""
        del observation
        if self._steps % 5 == 0:
            self._action = self._draws.uniform(-1.0, 1.0, 3).astype(np.float32)
        self._steps += 1
        return self._action


class Straight:
    """Turns to the goal and drives straight there, blind to what stands in between."""

    options: dict[str, Any] = {"observations": ("goal",)}  # noqa: RUF012

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """An action; none where the goal is reached."""
        x, y = observation["goal"].tolist()
        if math.hypot(x, y) < 0.25:
            return np.zeros(3, np.float32)
        bearing = math.atan2(y, x)
        ahead = max(0.0, 1.0 - abs(bearing))
        return np.array([min(ahead, 2.0 * math.hypot(x, y)), 0.0, np.clip(2.0 * bearing, -1.0, 1.0)], np.float32)


class Oracle(Navigator):
    """The robot's own autonomy stack with a given map and the true pose."""

    privileged = True

    @staticmethod
    def robot_options(episode: Episode, place: Place) -> dict[str, Any]:
        """What its robot is made with."""
        return {"map": place.true_map, "initial_pose": episode.start, "localization": "truth"}


class OracleExplorer(Navigator):
    """The robot's own autonomy stack with the true pose. A given map would leave nothing to explore."""

    privileged = True

    @staticmethod
    def robot_options(episode: Episode, place: Place) -> dict[str, Any]:
        """What its robot is made with."""
        del episode, place
        return {"localization": "truth"}


class OptimisticReplanning:
    """The baseline of the frozen episodes: no drive of a robot, and not a bound."""

    privileged = True
    yardstick = True


class OnnxPolicy:
    """A policy as an ONNX graph: inputs are observations by their names, the first output is the action.

    An output `next_NAME` is what input `NAME` is in the next step, zeros at first; an input `chance` is uniform in
    [0, 1). Where `goal` is an input, it stops within 0.3 m of it, by its own belief.
    """

    def __init__(self, path: Path) -> None:
        """Reads the graph."""
        with needed_for("ONNX policies", "policy"):
            import onnxruntime
        settings = onnxruntime.SessionOptions()
        settings.intra_op_num_threads = 1
        self._session = onnxruntime.InferenceSession(str(path), settings, providers=["CPUExecutionProvider"])
        self._outputs = [output.name for output in self._session.get_outputs()]
        self._shapes = {
            one.name: [n if isinstance(n, int) else 1 for n in one.shape] for one in self._session.get_inputs()
        }
        recurrent = {name.removeprefix("next_") for name in self._outputs if name.startswith("next_")}
        self._recurrent = [name for name in self._shapes if name in recurrent]
        seen = tuple(name for name in self._shapes if name not in recurrent and name != "chance")
        self.options: dict[str, Any] = {"observations": seen}
        if "lidar" in seen:
            self.options["lidar_beams"] = self._shapes["lidar"][-1]
        if "image" in seen:
            self.options["image_size"] = tuple(self._shapes["image"][1:3])

    def reset(self, assignment: Assignment) -> None:
        """Forgets."""
        self._draws = np.random.default_rng(assignment.seed)
        self._memory = {name: np.zeros(self._shapes[name], np.float32) for name in self._recurrent}

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """An action."""
        if "goal" in observation and float(np.linalg.norm(observation["goal"])) < STOP_WITHIN:
            return np.zeros(3, np.float32)
        inputs = {name: observation[name][None] for name in self.options["observations"]}
        if "chance" in self._shapes:
            inputs["chance"] = self._draws.random(self._shapes["chance"], np.float32)
        results = dict(zip(self._outputs, self._session.run(None, {**inputs, **self._memory}), strict=True))
        self._memory = {name: results[f"next_{name}"] for name in self._recurrent}
        return np.asarray(results[self._outputs[0]][0], np.float32)


SHIPPED: dict[str, dict[str, Callable[[], Any]]] = {
    "pointnav": {
        "navigator": Navigator,
        "random": Random,
        "straight": Straight,
        "optimistic": OptimisticReplanning,
        "oracle": Oracle,
    },
    "objectnav": {"semantic": SemanticSearch, "random": Random},
    "exploration": {
        "navigator": Navigator,
        "random": Random,
        "optimistic": OptimisticReplanning,
        "oracle": OracleExplorer,
    },
}
"""By task and name."""


@dataclass(frozen=True)
class Identity:
    """Which agent a result is of."""

    name: str  # as it was asked for
    kind: str  # "run", "act" or "yardstick"
    privileged: bool
    source: str  # SHA-256 of the file that it was read from; empty for a shipped one


POLICIES: dict[str, Callable[[Path], Any]] = {".onnx": OnnxPolicy, ".safetensors": MlpPolicy.load}
"""By how their files end."""


def make_agent(task: str, name: str) -> Any:
    """A shipped agent, one of a module (`module:Class`) or a policy (a file that ends in .onnx or .safetensors)."""
    if Path(name).suffix in POLICIES:
        if not Path(name).is_file():
            raise ConfigError(f"agent: {name}: no such file")
        return POLICIES[Path(name).suffix](Path(name))
    if ":" in name:
        return _class_of(name)()
    known = SHIPPED[task]
    if name not in known:
        raise ConfigError(f"agent: {unknown_name(f'agent of {task}', name, sorted(known))}, or module:Class")
    return known[name]()


def identify(task: str, name: str) -> Identity:
    """Which agent that is. Raises ConfigError for one that cannot be made or can do nothing."""
    try:
        agent = make_agent(task, name)
    except ConfigError:
        raise
    except Exception as error:  # whatever its module or its constructor does
        raise ConfigError(f"agent: {name} cannot be made: {type(error).__name__}: {error}") from error
    for option in getattr(agent, "options", {}):
        if option not in OPTIONS:
            raise ConfigError(f"agent: {name}: {unknown_name('option', option, list(OPTIONS))}")
    known = ("image", "depth", "lidar", "pose", "velocity", *TASK_FIELDS[TASKS[task].environment])
    for seen in getattr(agent, "options", {}).get("observations") or ():
        if seen not in known:
            raise ConfigError(f"agent: {name}: {unknown_name(f'observation of {task}', str(seen), list(known))}")
    kinds = [kind for kind in ("yardstick", "run", "act") if hasattr(agent, kind)]
    if not kinds:
        raise ConfigError(f"agent: {name}: expected a method `run(robot, assignment)` or `act(observation)`")
    if kinds[0] == "run" and not inspect.iscoroutinefunction(agent.run):
        raise ConfigError(f"agent: {name}: `run` must be `async def run(self, robot, assignment)`")
    source = Path(name) if Path(name).suffix in POLICIES else Path(inspect.getfile(type(agent)))
    shipped = name in SHIPPED[task]
    digest = "" if shipped else hashlib.sha256(source.read_bytes()).hexdigest()
    return Identity(name, kinds[0], bool(getattr(agent, "privileged", False)), digest)


def _class_of(name: str) -> Callable[[], Any]:
    module, _, attribute = name.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:  # as with `python -m`
        sys.path.insert(0, here)
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise ConfigError(f"agent: {name}: {error}") from None
    if not callable(found):
        raise ConfigError(f"agent: {name}: not a class")
    return found  # type: ignore[no-any-return]
