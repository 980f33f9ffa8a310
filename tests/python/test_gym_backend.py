"""Environments around a robot of any backend: against the native form, and against a program that drives the robot."""

from __future__ import annotations

import asyncio
import itertools
import math
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import threewe
import yaml
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray
from threewe import ConfigError, ConnectionError, ContractError, Pose2D, Robot
from threewe.backend import BackendOptions, Truth
from threewe.gym import TASKS, Env, MultiAgentEnv, VectorEnv

from .toy_backend import QuietBackend, Simulator

ROBOTS = Path(__file__).parents[2] / "assets/robots"
IDS = [f"3we/{name}-v1" for name in TASKS]
SMALL: dict[str, Any] = {"scene": [threewe.Scene.generate(1, size=(8.0, 6.0))], "max_steps": 15}
Policy = Callable[[dict[str, NDArray[Any]]], NDArray[np.float32]]


def register(backend: type[QuietBackend], _number: itertools.count[int] = itertools.count()) -> str:  # noqa: B008
    name = f"{backend.__name__}_{next(_number)}"
    threewe.register_backend(name, backend)
    return name


def same(ours: Any, theirs: Any) -> bool:
    """Equal in every bit."""
    if isinstance(theirs, dict):
        return bool(ours.keys() == theirs.keys()) and all(same(ours[key], theirs[key]) for key in theirs)
    if isinstance(theirs, tuple):
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    if isinstance(theirs, np.ndarray):
        return bool(ours.dtype == theirs.dtype) and bool(ours.tobytes() == theirs.tobytes())
    return bool(ours == theirs)


@pytest.mark.parametrize("name", IDS)
def test_check_env_finds_nothing(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(name, backend="mock", **SMALL)
        check_env(env.unwrapped, skip_render_check=True)
        assert env.observation_space == gymnasium.make(name, **SMALL).observation_space
        python = gymnasium.make(name, backend=register(Simulator), observations=("lidar", "pose", "velocity"), **SMALL)
        check_env(python.unwrapped, skip_render_check=True)


@pytest.mark.parametrize("noise", ["realistic", "ideal"])
@pytest.mark.parametrize("task", list(TASKS.values()))
def test_with_the_truth_it_is_the_native_form_to_the_bit(task: str, noise: str) -> None:
    options: dict[str, Any] = {**SMALL, "task": task, "noise": noise, "localization": "truth", "image_size": (32, 48)}
    robot, native = Env(backend="mock", **options), Env(**options)
    rng = np.random.default_rng(7)
    assert same(robot.reset(seed=5), native.reset(seed=5))
    for step in range(4 * 15):
        if step % 6 == 0:
            action = rng.uniform(-1.0, 1.0, 3).astype(np.float32)
        ours, theirs = robot.step(action), native.step(action)
        assert same(ours, theirs), f"step {step}"
        if theirs[2] or theirs[3]:
            assert same(robot.reset(), native.reset())


@pytest.mark.parametrize("randomization", ["hard", {"startup": {"camera_yaw": [-0.1, 0.1]}, "reset": {"mass": 1.3}}])
def test_a_randomised_robot_is_the_native_forms_to_the_bit(randomization: Any) -> None:
    options: dict[str, Any] = {**SMALL, "task": "navigation", "localization": "truth", "randomization": randomization}
    options["observations"] = ("lidar", "image", "pose", "velocity")
    robot, native = Env(backend="mock", **options), Env(**options)
    rng = np.random.default_rng(9)
    for seed in range(4):
        assert same(robot.reset(seed=seed), native.reset(seed=seed))
        for step in range(15):
            action = rng.uniform(-1.0, 1.0, 3).astype(np.float32)
            ours, theirs = robot.step(action), native.step(action)
            assert same(ours, theirs), f"seed {seed}, step {step}"
            if theirs[2] or theirs[3]:
                break


@pytest.mark.parametrize("dropped", ["ultrasonics", "camera", "imu"])
def test_an_episode_begins_as_the_last_sensor_has_spoken_whichever_there_are(tmp_path: Path, dropped: str) -> None:
    profile = yaml.safe_load((ROBOTS / "3we_standard_v2.yaml").read_text())
    del profile["sensors"][dropped], profile["link"]
    hardware = tmp_path / "robot.yaml"
    hardware.write_text(yaml.safe_dump(profile))
    options: dict[str, Any] = {**SMALL, "observations": ("lidar", "pose"), "localization": "truth"}
    robot, native = (Env(task="navigation", hardware=hardware, backend=name, **options) for name in ("mock", None))
    assert same(robot.reset(seed=3), native.reset(seed=3))


def towards_goal(observation: dict[str, NDArray[Any]]) -> NDArray[np.float32]:
    """A policy: turns to the goal, and drives."""
    ahead, left = observation["goal"].tolist()
    bearing = math.atan2(left, ahead)
    near = observation["lidar"][observation["lidar"] > 0.0].min()
    return np.array([0.8 * math.cos(bearing), 0.1 * float(near), np.clip(2.0 * bearing, -1.0, 1.0)], np.float32)


def driven_by_env(env: Env, policy: Policy, seed: int, episode: int, place: dict[str, Any]) -> list[tuple[float, ...]]:
    observation, info = env.reset(seed=seed, options={"episode_number": episode, **place})
    way = [info["true_pose"]]
    for _ in range(15):
        observation, _, terminated, _, info = env.step(policy(observation))
        way.append(info["true_pose"])
        if terminated:
            break
    return [tuple(pose.tolist()) for pose in way]


async def driven_by_robot(robot: Robot, policy: Policy, goal: tuple[float, float], steps: int) -> Any:
    assert robot.simulation is not None
    way = [tuple(robot.simulation.true_pose())]
    goal_in_map = robot.simulation.scene_from_map.inverse().transform(goal)
    for _ in range(steps):
        ahead_and_left = robot.get_pose().inverse().transform(goal_in_map)
        observation = {"lidar": robot.get_lidar_scan().ranges[::5], "goal": np.array(ahead_and_left, np.float32)}
        await robot.execute_action(policy(observation), period=0.1)
        way.append(tuple(robot.simulation.true_pose()))
    return way


@pytest.mark.parametrize("noise", ["realistic", "ideal"])
@pytest.mark.parametrize("localization", ["truth", "slam"])
def test_a_policy_drives_a_robot_as_it_drives_the_environment(localization: str, noise: str) -> None:
    place = {"start": (0.0, 0.0, 0.4), "goal": (3.0, 1.5)}
    common = {"scene": "corridor_v1", "noise": noise, "localization": localization}
    shared: dict[str, Any] = {**common, "task": "navigation", "observations": ("lidar", "goal"), "lidar_beams": 72}
    envs = [Env(backend="mock", **shared)] + ([Env(**shared)] if localization == "truth" else [])

    async def drive(seed: int, episode: int, steps: int) -> Any:
        async with Robot(**common) as robot:  # type: ignore[arg-type]
            assert robot.simulation is not None
            robot.simulation.reset(seed=seed, pose=place["start"], episode=episode)
            return await driven_by_robot(robot, towards_goal, place["goal"], steps)  # type: ignore[arg-type]

    for seed, episode in [(1, 0), (1, 3), (2, 0)]:
        ways = [driven_by_env(env, towards_goal, seed, episode, place) for env in envs]
        ways.append(asyncio.run(drive(seed, episode, len(ways[0]) - 1)))
        assert all(way == ways[0] for way in ways)
        assert math.dist(ways[0][0][:2], ways[0][-1][:2]) > 0.3


def test_a_robot_drives_and_maps_by_the_truth() -> None:
    async def drive() -> None:
        async with Robot(scene="corridor_v1", localization="truth", initial_pose=(1.0, 2.0, 0.5)) as robot:
            result = await robot.move_to(4.0, 3.0)
            assert result.success
            assert robot.simulation is not None
            off = (robot.simulation.scene_from_map * robot.get_pose()).distance(robot.simulation.true_pose())
            assert off < 1e-9
            grid = robot.get_map()
            assert (grid.data == 0).any() or (grid.data < 25).any()

    asyncio.run(drive())


def test_pictures_have_the_size_that_is_asked_for() -> None:
    async def look() -> None:
        async with Robot(scene="corridor_v1", image_size=(64, 48)) as robot:
            assert robot.get_camera_image().shape == (64, 48, 3)
            assert robot.profile.camera is not None
            assert robot.profile.camera.intrinsics.width == 48

    asyncio.run(look())
    with pytest.raises(ContractError, match=r"image_size must be \(height, width\), got \(64,\)"):
        Robot(image_size=(64,))
    with pytest.raises(ConfigError):
        Robot(image_size=(0, 48))


def test_episodes_of_a_seed_differ_and_repeat() -> None:
    async def scan(episode: int) -> Any:
        async with Robot(scene="corridor_v1") as robot:
            assert robot.simulation is not None
            robot.simulation.reset(seed=4, episode=episode)
            return robot.get_lidar_scan().ranges

    first, second, again = (asyncio.run(scan(episode)) for episode in (1, 2, 1))
    assert same(first, again)
    assert not same(first, second)


def test_a_simulator_in_python_has_a_robot_with_a_truth() -> None:
    async def drive() -> None:
        async with Robot(backend=register(Simulator), scene="corridor_v1", start_pose=(0.2, 0.1, 0.0)) as robot:
            truth = robot.simulation
            assert truth is not None
            assert truth.scene.name == "corridor_v1"
            await robot.execute_action((1.0, 0.0, 0.0), period=1.0)
            assert truth.distance_driven() == pytest.approx(0.4, abs=0.1)
            assert truth.true_pose().distance(Pose2D(0.2 + truth.distance_driven(), 0.1)) < 1e-9
            assert truth.start_pose() == Pose2D(0.2, 0.1, 0.0)
            assert math.isfinite(truth.geodesic((0.0, 0.0), (2.0, 0.0)))
            assert truth.look().ids.max() > 0

    asyncio.run(drive())


def test_episodes_of_a_simulator_in_python() -> None:
    backend = register(Simulator)
    env = Env(task="navigation", backend=backend, scene=["corridor_v1", "office_v2"], observations=("goal", "pose"))
    starts = []
    for seed in (1, None, None):
        _, info = env.reset(seed=seed)
        starts.append(tuple(info["true_pose"]))
        _, reward, *_, after = env.step(np.array([1.0, 0.0, 0.0], np.float32))
        assert after["path_length"] > 0.0
        assert reward == pytest.approx(info["distance_to_goal"] - after["distance_to_goal"] - 0.01, abs=1e-9)
    assert len(set(starts)) == 3
    env.reset(seed=1, options={"episode_number": 2})
    assert tuple(env.step(np.zeros(3, np.float32))[4]["true_pose"]) == pytest.approx(starts[2])


class Lying(Simulator):
    def truth(self) -> Truth:
        return Truth(start=Pose2D(), pose=(math.nan, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), distance_driven=0.0)


class Broken(Simulator):
    steps = 0

    def step(self, t: float, velocity: Any) -> Any:
        Broken.steps += 1
        if Broken.steps == 20:
            raise OSError("the physics exploded")
        return super().step(t, velocity)


class Secretive(QuietBackend):
    @property
    def features(self) -> threewe.Features:
        quiet = super().features
        return threewe.Features(quiet.sensors, quiet.kinematics, lockstep=True, can_reset=True)

    def reset(self, seed: int, pose: Pose2D | None) -> None:
        pass


class OwnRobot(Simulator):
    """Its camera has the size that it has."""

    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.profile = threewe.RobotProfile.load(options.hardware)

    @property
    def features(self) -> threewe.Features:
        more = [*super().features.sensors, threewe.SensorInfo("camera", threewe.SensorType.camera, 30.0)]
        return threewe.Features(more, super().features.kinematics, lockstep=True, can_reset=True)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"backend": "mokc"}, "unknown backend 'mokc'; did you mean 'mock'?"),
        ({"backend": QuietBackend}, "backend: 'QuietBackend' cannot reset, which every episode begins with"),
        ({"backend": Secretive}, "backend: 'Secretive' tells no truth about its robot, which rewards are made of"),
        (
            {"backend": Simulator, "observations": ("image",)},
            "observations: 'image' needs a camera, which '3we_standard_v2' lacks on backend 'Simulator'",
        ),
        ({"backend": OwnRobot, "observations": ("image",)}, "image_size: the pictures of backend 'OwnRobot' are"),
        ({"backend": "mock", "hardware": "3we_base_v2", "observations": ("lidar",)}, "observations: 'lidar' needs a"),
        ({"backend": "mock", "gate": "limits"}, "gate: with a backend it is 'full', the one that every Robot has"),
        ({"backend": "mock", "randomization": "papr"}, "unknown randomization 'papr'; did you mean 'paper'?"),
        ({"backend": "mock", "randomization": {"reset": {"mas": 1}}}, "randomization:1: reset.mas: unknown knob 'mas'"),
        ({"backend": Simulator, "randomization": "mild"}, "backend 'Simulator' does not say that it can randomize"),
        ({"backend": "mock", "localization": "noisy"}, "unknown localization 'noisy'; known: slam, truth"),
        ({"backend": "mock", "localization_model": "slam_v2"}, "localization_model: with a backend the robot's own"),
        ({"backend": "mock", "hardware": threewe.RobotProfile.load("3we_base_v2")}, "hardware: with a backend it is"),
        ({"backend": "mock", "scene": "ofice_v2"}, "unknown scene 'ofice_v2'; did you mean 'office_v2'?"),
        ({"backend": "mock", "control_rate": 60}, "control_rate: 50 Hz over a whole number"),
        ({"backend": "mock", "num_threads": 2}, "unknown option 'num_threads'"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(options: dict[str, Any], says: str) -> None:
    backend = options["backend"]
    if isinstance(backend, type):
        threewe.register_backend(backend.__name__, backend)
        options = {**options, "backend": backend.__name__}
    with pytest.raises(ConfigError) as error:
        Env(**{"task": "navigation", "scene": "corridor_v1", **options})
    assert says in str(error.value)


def test_batches_and_teams_have_no_backend() -> None:
    with pytest.raises(ConfigError, match="backend: batches and teams are of the embedded simulator alone"):
        VectorEnv(task="navigation", backend="mock")
    pytest.importorskip("pettingzoo")
    with pytest.raises(ConfigError, match="backend: batches and teams"):
        MultiAgentEnv(task="navigation", backend="mock")


def test_several_at_once_are_gymnasiums_own() -> None:
    envs = gymnasium.make_vec(
        "3we/Navigation-v1", 2, vectorization_mode="sync", backend="mock", observations=("goal",), **SMALL
    )
    observations, _ = envs.reset(seed=3)
    assert observations["goal"].shape == (2, 2)


def drive_on(env: Env, action: NDArray[np.float32]) -> None:
    for _ in range(20):
        env.step(action)


def test_a_robot_that_fails_says_so_and_the_next_episode_begins() -> None:
    env = Env(task="navigation", backend=register(Broken), scene="corridor_v1", observations=("goal",))
    forward = np.array([0.5, 0.0, 0.0], np.float32)
    env.reset(seed=1)
    with pytest.raises(ConnectionError, match="the physics exploded"):
        drive_on(env, forward)
    with pytest.raises(ContractError, match="is over; reset it first"):
        env.step(forward)
    env.reset()
    env.step(forward)


def test_a_truth_that_nobody_can_believe_is_refused() -> None:
    with pytest.raises(ContractError, match=r"truth\(\): pose is not finite"):
        Env(task="navigation", backend=register(Lying), scene="corridor_v1", observations=("goal",)).reset(seed=1)


def test_nobody_knows_the_truth_of_a_real_robot() -> None:
    with pytest.raises(ContractError, match="localization 'truth' needs a simulator that states it"):
        Robot(backend=register(QuietBackend), localization="truth")


def test_it_is_drawn_from_above() -> None:
    pytest.importorskip("PIL")
    env = Env(task="navigation", backend="mock", render_mode="rgb_array", localization="truth", **SMALL)
    native = Env(task="navigation", render_mode="rgb_array", localization="truth", **SMALL)
    for one in (env, native):
        one.reset(seed=1)
        one.step(np.array([0.5, 0.0, 0.2], np.float32))
    np.testing.assert_array_equal(env.render(), native.render())
