"""What single and batched environments share: their options, their spaces, and the C++ batch behind them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Generic, TypedDict, TypeVar

import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from threewe import _core
from threewe._arguments import as_asset, as_image_size, as_list, as_number, as_pose, as_seed, as_switch, as_text
from threewe._core import RobotProfile, Scene
from threewe.backend import known_backend
from threewe.errors import ConfigError, ContractError

Observation = dict[str, NDArray[Any]]
Core = TypeVar("Core", _core.EnvBatch, _core.RobotEnv)
TASK_FIELDS = {
    "navigation": ("goal",),
    "exploration": ("coverage_map",),
    "object_nav": ("object_goal",),
    "vln": ("instruction_tokens", "instruction_embedding"),
}
TEAM_TASKS = ("exploration", "navigation")  # for several robots in one place
RESET_OPTIONS = ("start", "goal", "object_goal", "scene", "episode_number", "reset_mask")


class UnknownOptionError(ConfigError, TypeError):
    """An unknown keyword argument. A TypeError as of any function, by which libraries find out what they can pass."""


class EnvOptions(TypedDict, total=False):
    """Keyword arguments that all environments take.

    - `observations`: names of what is observed, each paid for only when asked for. `image` (64, 64, 3) uint8 BGR,
      `depth` (64, 64) float32 [m] along the optical axis (0 = invalid; profiles with a depth camera), `lidar` (360,)
      float32 [m] counter-clockwise from behind (`range_max` = no return, 0 = invalid), `pose` (3,) float32 x, y [m],
      theta [rad] in the map frame, `velocity` (3,) float32 vx, vy [m/s], omega [rad/s] in the body frame, and the
      task's own. By default all that the robot has but `depth`.
    - `lidar_beams`: every k-th of the profile's beams (360, 180, 120, 90, 72, 60, ...).
    - `image_size`: (height, width) [px], up to 2048 each.
    - `scene`: a name, a file, a Scene, or a list of them, of which each episode draws one; `"procedural"` for generated
      ones.
    - `difficulty`, `num_scenes`, `scene_seed`: of procedural scenes, 0 to 1; how many; the first one's seed.
    - `hardware`: a robot profile, or a file.
    - `backend`: of a single environment: around a `Robot` on that backend, which must be a simulator that can reset.
      With `"mock"` it is the embedded simulator, through all that a robot is made of.
    - `noise`: `"realistic"` or `"ideal"`.
    - `localization`: where `pose`, `velocity` and goals in the robot's frame come from: `"noisy"`: wheel odometry
      between corrections that are off as those of our own SLAM are; `"odometry"`: the wheels alone; `"truth"`. With a
      backend: `"slam"`, the robot's own (the default), or `"truth"`.
    - `localization_model`: of `"noisy"`, or a file: see assets/localization.
    - `gate`: `"full"`, as in `Robot`; `"limits"` without the collision monitor. By default `"full"`, but `"limits"` in
      the native form for a robot without the lidar that the monitor goes by there.
    - `randomization`: `"none"`, `"mild"`, `"paper"`, `"hard"`, a file, or a dict of the same form as the files:
      `{"reset": {"mass": [0.9, 1.1]}}`; see assets/randomization.
    - `max_steps`: an episode is truncated after so many.
    - `control_rate`: steps a second: 50 over a whole number.
    - `episodes`: of Navigation: `"standard"` (2 to 15 m, a fifth with a detour), `"reactive"` (2 to 8 m, none); of
      ObjectNav: `"standard"` (nothing of the kind is in view), `"in_sight"` (something is, 1.5 to 5 m away).
    - `goal_frame`: of Navigation's `goal`: `"robot"` or `"map"`.
    - `stop`: of Navigation: it succeeds only where the robot says STOP, by actions below 5 % for half a second.
    - `contact`: of Navigation: `"end"`, a contact ends the episode; `"count"`, contacts are counted.
    """

    observations: Sequence[str] | None
    lidar_beams: int | None
    image_size: tuple[int, int]
    scene: Any
    difficulty: float
    num_scenes: int
    scene_seed: int
    hardware: str
    backend: str | None
    noise: str
    localization: str | None
    localization_model: str
    gate: str | None
    randomization: str | Mapping[str, Any]
    max_steps: int
    control_rate: float
    episodes: str
    goal_frame: str
    stop: bool
    contact: str


DEFAULTS = EnvOptions(
    observations=None,
    lidar_beams=None,
    image_size=(64, 64),
    scene="office_v2",
    difficulty=0.5,
    num_scenes=16,
    scene_seed=0,
    hardware="3we_standard_v2",
    backend=None,
    noise="realistic",
    localization=None,
    localization_model="slam_v2",
    gate=None,
    randomization="none",
    max_steps=500,
    control_rate=10.0,
    episodes="standard",
    goal_frame="robot",
    stop=False,
    contact="end",
)


@dataclass
class Batch(Generic[Core]):
    """The C++ batch, or the environment around a robot, and what Gymnasium wants to know about it."""

    core: Core
    scenes: list[Scene]
    hardware: RobotProfile
    options: EnvOptions
    observation_space: spaces.Dict
    action_space: spaces.Box

    def reset(
        self, seeds: Sequence[int | None], options: Mapping[str, Any] | None, mask: NDArray[np.bool_] | None
    ) -> None:
        """Begins an episode in every environment, or in those of the mask."""
        options = options or {}
        for name in options:
            if name not in RESET_OPTIONS:
                raise ConfigError(_core.unknown_name("reset option", name, list(RESET_OPTIONS)))
        n = len(seeds)
        scene = self._scene_index(options["scene"]) if options.get("scene") is not None else None
        number = options.get("episode_number")
        episode = None if number is None else as_seed("options['episode_number']", number, 32)
        start = as_pose("options['start']", options["start"]) if options.get("start") is not None else None
        goal = as_pose("options['goal']", options["goal"]) if options.get("goal") is not None else None
        category = options.get("object_goal")
        self.core.reset(
            seeds=list(seeds),
            episodes=[episode] * n,
            scenes=[scene] * n,
            start=start,
            goal=None if goal is None else (goal.x, goal.y),
            category=None if category is None else as_text("options['object_goal']", category),
            mask=[] if mask is None else mask.tolist(),
        )

    def observation(self, row: int) -> Observation:
        """A copy of what one robot observes."""
        return {name: values[row].copy() for name, values in self.core.observations.items()}

    def info(self, robot: int = 0) -> dict[str, Any]:
        """What there is to know about a robot of the first environment. Privileged."""
        core, episode = self.core, self.core.episode(0)
        info: dict[str, Any] = dict(zip(core.metric_names, core.metrics[robot].tolist(), strict=True))
        info["success"] = info["success"] > 0.0
        info["true_pose"] = core.true_poses[robot].copy()
        info["scan_age"] = float(core.scan_ages[robot])
        if core.instruction_name:
            info[core.instruction_name] = core.instruction(0)
        info["scene"] = self.scenes[episode.scene].name
        info["seed"] = episode.seed
        info["episode_number"] = episode.episode
        return info

    def first_info(self, robot: int = 0) -> dict[str, Any]:
        """As `info`, when an episode begins."""
        return {**self.info(robot), "randomization": self.core.variation(0, robot)}

    def _scene_index(self, scene: Any) -> int:
        names = [known.name for known in self.scenes]
        if scene in names:
            return names.index(scene)
        raise ConfigError(_core.unknown_name("scene of this environment", str(scene), names))


def make_batch(
    task: str, *, num_envs: int, num_robots: int, num_threads: int, autoreset: str, **given: Any
) -> Batch[_core.EnvBatch]:
    """A batch of environments. Raises ConfigError for an unknown option, with the nearest right name."""
    options = filled(given)
    if options["backend"] is not None:
        raise ConfigError(
            f"backend: batches and teams are of the embedded simulator alone; gymnasium.make() gives an environment on "
            f"{options['backend']!r}, gymnasium.make_vec(..., vectorization_mode='sync') several"
        )
    if num_robots > 1 and task not in TEAM_TASKS:
        raise ConfigError(f"num_robots: {task} is for one robot, {' and '.join(TEAM_TASKS)} are for teams")
    hardware = options["hardware"]
    profile = hardware if isinstance(hardware, RobotProfile) else RobotProfile.load(as_asset("hardware", hardware))
    scenes = load_scenes(options)
    core = _core.EnvBatch(
        task=task,
        scenes=scenes,
        hardware=profile,
        observations=observation_names(task, options["observations"]),
        localization=as_text("localization", options["localization"] or "noisy"),
        localization_model=as_asset("localization_model", options["localization_model"]),
        num_envs=as_seed("num_envs", num_envs),
        num_robots=as_seed("num_robots", num_robots),
        num_threads=as_seed("num_threads", num_threads),
        autoreset=autoreset,
        randomization=load_randomization(options["randomization"]),
        **common_arguments(options),
    )
    return Batch(core, scenes, profile, options, observation_space(core), action_space())


def make_robot_env(task: str, **given: Any) -> Batch[_core.RobotEnv]:
    """An environment around a robot of any backend, in the form of a batch of one."""
    options = filled(given)
    backend = known_backend(as_text("backend", options["backend"] or ""))
    if isinstance(options["hardware"], RobotProfile):
        raise ConfigError("hardware: with a backend it is a name or a file")
    hardware = as_asset("hardware", options["hardware"])
    if given.get("localization_model") is not None:
        raise ConfigError(
            "localization_model: with a backend the robot's own localisation is there, and no model of it"
        )
    with scene_files(options) as scenes, randomization_file(options) as randomization:
        core = _core.RobotEnv(
            backend=backend,
            task=task,
            scenes=scenes,
            hardware=hardware,
            observations=observation_names(task, options["observations"]),
            localization=as_text("localization", options["localization"] or "slam"),
            randomization=randomization,
            **common_arguments(options),
        )
    return Batch(core, core.scenes, core.hardware, options, observation_space(core), action_space())


def filled(given: Mapping[str, Any]) -> EnvOptions:
    """All options. Raises ConfigError for an unknown one, with the nearest right name."""
    for name in given:
        if name not in DEFAULTS:
            raise UnknownOptionError(
                f"unexpected keyword argument {name!r}: {_core.unknown_name('option', name, list(DEFAULTS))}"
            )
    return EnvOptions(**{**DEFAULTS, **given})  # type: ignore[typeddict-item]


def common_arguments(options: EnvOptions) -> dict[str, Any]:
    """What batches and environments around robots are asked in the same way."""
    control_rate = as_number("control_rate", options["control_rate"])
    if not control_rate > 0.0:
        raise ConfigError(f"control_rate must be positive, got {control_rate:g}")
    return {
        "noise": as_text("noise", options["noise"]),
        "lidar_beams": as_seed("lidar_beams", options["lidar_beams"] or 0, 31),
        "image_size": as_image_size("image_size", options["image_size"]),
        "gate": None if options["gate"] is None else as_text("gate", options["gate"]),
        "max_steps": as_seed("max_steps", options["max_steps"], 31),
        "control_period": round(1e9 / control_rate) * 1e-9,
        "episodes": as_text("episodes", options["episodes"]),
        "goal_frame": as_text("goal_frame", options["goal_frame"]),
        "stop": as_switch("stop", options["stop"]),
        "contact": as_text("contact", options["contact"]),
    }


def with_limit(spec: EnvSpec | None, max_steps: int) -> EnvSpec | None:
    """A spec that tells after how many steps an episode is truncated, which some wrappers and libraries ask for."""
    if spec is None:
        return None
    given = spec.max_episode_steps or 0  # of a wrapper around the environment
    return replace(spec, max_episode_steps=given if 0 < given < max_steps else max_steps)


def action_space() -> spaces.Box:
    """Forward, left, counter-clockwise."""
    return spaces.Box(-1.0, 1.0, (3,), np.float32)


def load_randomization(given: str | Mapping[str, Any]) -> _core.Randomization:
    """A randomisation by name, from a file or from a dict."""
    if not isinstance(given, Mapping):
        return _core.Randomization.load(as_asset("randomization", given))
    try:
        text = json.dumps(given, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ContractError(f"randomization must hold names, finite numbers and lists: {error}") from None
    return _core.Randomization.parse(text, "randomization")  # JSON is YAML


@contextmanager
def randomization_file(options: EnvOptions) -> Iterator[str]:
    """The randomisation as any backend takes it, by name or file."""
    given = options["randomization"]
    load_randomization(given)  # what is wrong with it is said of what the user wrote
    if not isinstance(given, Mapping):
        yield as_asset("randomization", given)
        return
    with TemporaryDirectory() as folder:
        file = Path(folder, "randomization.yaml")
        file.write_text(json.dumps(given))  # JSON is YAML
        yield as_asset("randomization", file)


def load_scenes(options: EnvOptions) -> list[Scene]:
    """The scenes that episodes are drawn from."""
    scene = options["scene"]
    if isinstance(scene, str) and scene == "procedural":
        first = as_seed("scene_seed", options["scene_seed"])
        difficulty = as_number("difficulty", options["difficulty"])
        count = as_seed("num_scenes", options["num_scenes"], 31)
        return [Scene.generate(seed, difficulty=difficulty) for seed in range(first, first + count)]
    several: Iterable[Any] = [scene] if isinstance(scene, str | Scene) or hasattr(scene, "__fspath__") else scene
    return [s if isinstance(s, Scene) else Scene.load(as_asset("scene", s)) for s in as_list("scene", several)]


@contextmanager
def scene_files(options: EnvOptions) -> Iterator[list[str]]:
    """The scenes as any backend takes them, by name or file: others are in files for as long as worlds are made."""
    scene = options["scene"]
    wanted = [scene] if isinstance(scene, str | Scene) or hasattr(scene, "__fspath__") else as_list("scene", scene)
    if wanted == ["procedural"]:
        wanted = load_scenes(options)
    with TemporaryDirectory() as folder:
        names = []
        for i, one in enumerate(wanted):
            if isinstance(one, Scene):
                file = Path(folder, str(i), f"{one.name}.yaml")
                file.parent.mkdir()
                file.write_text(one.to_yaml())
                one = file
            names.append(as_asset("scene", one))
        yield names


def observation_names(task: str, wanted: Sequence[str] | None) -> list[str] | None:
    """What is observed; None for all that the robot has but depth."""
    if wanted is None:
        return None
    names = [as_text("observations", name) for name in as_list("observations", wanted)]
    known = ["image", "depth", "lidar", "pose", "velocity", *TASK_FIELDS[task]]
    for name in names:
        if name not in known:
            raise ConfigError(_core.unknown_name("observation", name, known))
    if not names:
        raise ConfigError(f"observations: at least one is needed, such as {known[-1]!r}")
    return names


def observation_space(core: _core.EnvBatch | _core.RobotEnv) -> spaces.Dict:
    """The space of one robot's observations."""
    boxes: dict[str, spaces.Space[Any]] = {
        field.name: spaces.Box(field.low, field.high, tuple(field.shape), np.dtype(field.dtype).type)
        for field in core.fields
    }
    return spaces.Dict(boxes)


def as_actions(values: Any, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Actions as the core takes them. Raises ContractError for what is no floating-point array of the shape."""
    actions = np.asarray(values)
    if actions.dtype.kind != "f":
        raise ContractError(f"action must hold floating-point numbers, got dtype {actions.dtype}")
    if actions.shape != shape:
        raise ContractError(f"action must have shape {shape}, got {actions.shape}")
    return np.ascontiguousarray(actions, dtype=np.float32).reshape(-1, 3)
