"""Agents: programs that drive a `Robot`, and policies that act on observations.

An agent is any object with one of two methods. `async def run(self, robot, assignment)` is a program: when it returns,
it says STOP. `act(self, observation)` returns an action (3,) in [-1, 1] for each step of a `3we/...` environment around
the same robot; three commands below 5 % for half a second are STOP.

What else it may have: `reset(assignment)`, called as an episode begins; `options`, of `EnvOptions`
`observations` (lidar, pose, velocity and the task's own where it names none), `lidar_beams`, `image_size`,
`control_rate` and `goal_frame`, of which a program has `image_size` alone; `privileged = True`, with
which `run` finds `robot.simulation` and `robot_options(episode, place)` may change what the robot is made with. A new
agent is made for each episode.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import math
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.machinery import ModuleSpec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import unknown_name
from threewe._extras import needed_for
from threewe._model_client import ModelAddress
from threewe.benchmark.episodes import Episode
from threewe.benchmark.mlp import STOP_WITHIN, MlpPolicy
from threewe.benchmark.search import SemanticSearch
from threewe.benchmark.tasks import TASKS, Assignment, Place
from threewe.errors import ConfigError, ConnectionError
from threewe.gym.batch import TASK_FIELDS
from threewe.robot import Robot

Observation = dict[str, NDArray[Any]]
OPTIONS = ("observations", "lidar_beams", "image_size", "control_rate", "goal_frame")
"""What an agent that acts may choose; the rest is the run's."""


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


class Instructed:
    """The robot's own instructions: grammar, detector and semantic map, no network. Not privileged."""

    async def run(self, robot: Robot, assignment: Assignment) -> None:
        """Does what there is to do, said in words."""
        await robot.execute_instruction(instruction_of(robot, assignment), timeout=assignment.time_limit, model="")


class InstructedByModel:
    """The same with a model of vision and language: `vlm@ADDRESS`, or `vlm` for that of THREEWE_MODEL."""

    def __init__(self, address: str, replayed: Path | None = None) -> None:
        """With `replayed`, the record of a conversation, nothing is asked."""
        self._address, self._replayed = address, replayed
        self.talk = b""
        """the conversation, as `record` of `Robot.execute_instruction` writes it"""

    async def run(self, robot: Robot, assignment: Assignment) -> None:
        """Does what there is to do. Raises where the model or its server fails."""
        text, limit = instruction_of(robot, assignment), assignment.time_limit
        if self._replayed is not None:
            result = await robot.execute_instruction(text, timeout=limit, replay=self._replayed)
        else:
            with TemporaryDirectory() as folder:
                record = Path(folder, "talk.jsonl")
                try:
                    result = await robot.execute_instruction(text, timeout=limit, model=self._address, record=record)
                finally:
                    self.talk = record.read_bytes() if record.exists() else b""
        if result.reason == "model_error":
            raise ConnectionError(result.detail)


def instruction_of(robot: Robot, assignment: Assignment) -> str:
    """An assignment as an instruction; the robot learns the names of the rooms that it is given."""
    for name, border in assignment.places:
        robot.name_place(name, border)
    return assignment.instruction or f"find the {assignment.category}"


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
    "objectnav": {"semantic": SemanticSearch, "detector": Instructed, "random": Random},
    "vln": {"language": Instructed},
    "exploration": {
        "navigator": Navigator,
        "random": Random,
        "optimistic": OptimisticReplanning,
        "oracle": OracleExplorer,
    },
}
"""By task and name."""
MODEL = "vlm"
SAID = ("objectnav", "vln")
"""Tasks whose assignments can be said as an instruction, to the agent `vlm`."""


@dataclass(frozen=True)
class Identity:
    """Which agent a result is of."""

    name: str  # as it was asked for
    kind: str  # "run", "act" or "yardstick"
    privileged: bool
    source: str  # SHA-256 of what it was read from; empty for a shipped one


LEARNED = "policy:"
"""What the name of an agent begins with that is a folder of a learned policy."""
POLICIES: dict[str, Callable[[Path], Any]] = {".onnx": OnnxPolicy, ".safetensors": MlpPolicy.load}
"""By how their files end."""


def make_agent(task: str, name: str) -> Any:
    """A shipped agent, a learned policy (`policy:FOLDER`), one of a module (`module:Class`), or a file that ends in
    .onnx or .safetensors."""
    if name.startswith(LEARNED):
        from threewe.ai.agent import PolicyAgent

        if task != "objectnav":
            raise ConfigError(f"agent: {name}: a learned policy goes to things; its task is objectnav, not {task}")
        return PolicyAgent(name.removeprefix(LEARNED))
    if (address := address_of(task, name)) is not None:
        return InstructedByModel(address)
    if Path(name).suffix in POLICIES:
        if not Path(name).is_file():
            raise ConfigError(f"agent: {name}: no such file")
        return POLICIES[Path(name).suffix](Path(name))
    if ":" in name:
        return _class_of(name)()
    known = SHIPPED[task]
    if name not in known:
        names = sorted([*known, *([MODEL] if task in SAID else [])])
        raise ConfigError(f"agent: {unknown_name(f'agent of {task}', name, names)}, or module:Class")
    return known[name]()


def address_of(task: str, name: str) -> str | None:
    """Where the model of `vlm@ADDRESS` is; None for other agents. Raises ConfigError where it is nowhere."""
    kind, _, address = name.partition("@")
    if kind != MODEL:
        return None
    if task not in SAID:
        raise ConfigError(f"agent: {MODEL} is for {' and '.join(SAID)}, not for {task}")
    address = address or os.environ.get("THREEWE_MODEL", "")
    if not address:
        raise ConfigError(f"agent: {MODEL} needs a model: {MODEL}@http://127.0.0.1:8080/v1, or THREEWE_MODEL")
    return str(ModelAddress.read(address))


def identify(task: str, name: str) -> Identity:
    """Which agent that is. Raises ConfigError for one that cannot be made or can do nothing."""
    if (address := address_of(task, name)) is not None:
        name = f"{MODEL}@{address}"
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
    kind = _kind_of(name, agent)
    if task == "vln" and kind == "act":
        raise ConfigError(f"agent: {name}: VLN is for programs: a method `async def run(self, robot, assignment)`")
    source = hashlib.sha256(_source_of(name, agent)).hexdigest() if has_source(name) else ""
    return Identity(name, kind, bool(getattr(agent, "privileged", False)), source)


def has_source(name: str) -> bool:
    """Whether it is the name of a policy or of a class of a module, and not of an agent that comes with 3we."""
    foreign = name.startswith(LEARNED) or Path(name).suffix in POLICIES or ":" in name
    return foreign and name.partition("@")[0] != MODEL


def file_of(name: str) -> Path | None:
    """The file that a module's agent or a policy's file is read from, found without running any of it; None for others.

    Raises ConfigError where there is none.
    """
    if not has_source(name) or name.startswith(LEARNED):
        return None
    file: Path | None = Path(name)
    if Path(name).suffix not in POLICIES:
        _find_modules_here()
        file = _file_of_module(name.partition(":")[0])
    if file is None or not file.is_file():
        raise ConfigError(f"agent: {name}: no such file")
    return file


def _source_of(name: str, agent: Any) -> bytes:
    """What an agent was read from."""
    if name.startswith(LEARNED):
        return bytes(agent.content)
    return (Path(name) if Path(name).suffix in POLICIES else Path(inspect.getfile(type(agent)))).read_bytes()


def _class_of(name: str) -> type:
    """A class that can be an agent, by what it has before one is made."""
    module, _, attribute = name.partition(":")
    _find_modules_here()
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise ConfigError(f"agent: {name}: {error}") from None
    if not isinstance(found, type) or found.__module__ != module:
        raise ConfigError(f"agent: {name}: expected a class that {module} defines")
    _kind_of(name, found)
    return found


def _kind_of(name: str, agent: Any) -> str:
    """How an agent, or those of a class, drive."""
    kinds = [kind for kind in ("yardstick", "run", "act") if hasattr(agent, kind)]
    if not kinds:
        raise ConfigError(f"agent: {name}: expected a method `run(robot, assignment)` or `act(observation)`")
    if kinds[0] == "run" and not inspect.iscoroutinefunction(agent.run):
        raise ConfigError(f"agent: {name}: `run` must be `async def run(self, robot, assignment)`")
    return kinds[0]


def _find_modules_here() -> None:
    """As with `python -m`."""
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)


def _file_of_module(name: str) -> Path | None:
    """Of the import system, which would run a package to find what is in it: so each is looked up in the one before."""
    path: Sequence[str] | None = None
    spec: ModuleSpec | None = None
    parts = name.split(".")
    for count in range(1, len(parts) + 1):
        try:
            found = (finder.find_spec(".".join(parts[:count]), path) for finder in sys.meta_path)
            spec = next((one for one in found if one is not None), None)
        except (ValueError, KeyError):  # no name, or a folder without __init__.py in another
            return None
        if spec is None or (path := spec.submodule_search_locations) is None:
            break
    return Path(spec.origin) if spec is not None and spec.name == name and spec.origin else None
