"""What other people's learning code does with an environment: Gymnasium's, and trainers on a task each, most by night.

`./dev interop rl` trains with every library on every task.
"""

from __future__ import annotations

import copy
import itertools
import os
import pickle
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import threewe
import threewe.sync
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from gymnasium.wrappers import (
    ClipAction,
    FlattenObservation,
    FrameStackObservation,
    NormalizeObservation,
    NormalizeReward,
    RecordEpisodeStatistics,
    TimeAwareObservation,
    TransformObservation,
    TransformReward,
)
from gymnasium.wrappers import vector as of_vectors
from threewe import ConfigError, ContractError
from threewe.gym import TASKS, Env, VectorEnv

ROOT = Path(__file__).resolve().parents[2]
IDS = [f"3we/{name}-v1" for name in TASKS]
SMALL: dict[str, Any] = {"scene": [threewe.Scene.generate(1, size=(8.0, 6.0))], "max_steps": 4}
GOAL: dict[str, Any] = {**SMALL, "task": "navigation", "observations": ("goal",)}


@pytest.fixture(autouse=True)
def no_warnings() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def chain(name: str) -> Callable[[], gymnasium.Env[Any, Any]]:
    """The wrappers of PPO in one file."""

    def make() -> gymnasium.Env[Any, Any]:
        env: gymnasium.Env[Any, Any] = FlattenObservation(gymnasium.make(name, **SMALL))
        env = NormalizeObservation(ClipAction(RecordEpisodeStatistics(env)))
        env = TransformObservation(env, lambda values: np.clip(values, -10, 10), env.observation_space)
        return TransformReward(NormalizeReward(env), lambda reward: float(np.clip(reward, -10, 10)))

    return make


@pytest.mark.parametrize("name", IDS)
def test_statistics_of_an_episode_have_their_key(name: str) -> None:
    env = RecordEpisodeStatistics(gymnasium.make(name, **SMALL))
    _, info = env.reset(seed=1)
    assert info["episode_number"] == 0
    for _ in range(4):
        assert "episode" not in info
        *_, info = env.step(np.ones(3, np.float32))
    assert info["episode"]["l"] == 4
    assert info["episode_number"] == 0
    assert env.reset()[1]["episode_number"] == 1


@pytest.mark.parametrize("kind", [SyncVectorEnv, AsyncVectorEnv])
@pytest.mark.parametrize("name", IDS)
def test_the_usual_chain_of_wrappers(name: str, kind: type[SyncVectorEnv] | type[AsyncVectorEnv]) -> None:
    envs = kind([chain(name)] * 2)
    envs.reset(seed=1)
    lengths = []
    for _ in range(12):
        observations, rewards, *_, infos = envs.step(envs.action_space.sample())
        assert np.isfinite(observations).all()
        assert np.isfinite(rewards).all()
        if "episode" in infos:
            lengths += infos["episode"]["l"][infos["_episode"]].tolist()
    envs.close()
    assert lengths
    assert max(lengths) == 4


@pytest.mark.parametrize("mode", ["sync", "async", "vector_entry_point"])
@pytest.mark.parametrize("name", IDS)
def test_statistics_of_vectors(name: str, mode: str) -> None:
    envs = of_vectors.RecordEpisodeStatistics(gymnasium.make_vec(name, 2, vectorization_mode=mode, **SMALL))
    envs.reset(seed=1)
    for _ in range(4):
        *_, infos = envs.step(np.ones((2, 3), np.float32))
    envs.close()
    assert infos["episode"]["l"].max() == 4


@pytest.mark.parametrize("name", IDS)
def test_the_longest_episode_is_in_the_spec(name: str) -> None:
    env = gymnasium.make(name, **SMALL)
    assert env.spec is not None
    assert env.spec.max_episode_steps == 4
    assert gymnasium.make(name, **SMALL, max_episode_steps=3).spec.max_episode_steps == 3  # type: ignore[union-attr]
    assert gymnasium.make_vec(name, 2, **SMALL).spec.max_episode_steps == 4  # type: ignore[union-attr]


@pytest.mark.parametrize("name", IDS)
def test_observations_are_stacked(name: str) -> None:
    env = FrameStackObservation(TimeAwareObservation(FlattenObservation(gymnasium.make(name, **SMALL))), 3)
    env.action_space.seed(1)
    seen = [env.reset(seed=1)[0]]
    ended = False
    while not ended:
        observation, _, terminated, truncated, _ = env.step(env.action_space.sample())
        seen.append(observation)
        ended = terminated or truncated
    assert all(observation in env.observation_space for observation in seen)
    assert len(seen) == 5
    assert all(np.array_equal(after[:2], before[1:]) for before, after in itertools.pairwise(seen))


def test_a_spec_can_be_written_down() -> None:
    spec = gymnasium.make("3we/Navigation-v1").spec
    assert spec is not None
    read = gymnasium.envs.registration.EnvSpec.from_json(spec.to_json())
    assert gymnasium.make(pickle.loads(pickle.dumps(read))).spec.max_episode_steps == 500  # type: ignore[union-attr]


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_are_new_environments_with_the_same_arguments(copied: Callable[[Any], Any]) -> None:
    for env in (gymnasium.make("3we/Navigation-v1", **SMALL), VectorEnv(num_envs=2, **GOAL)):
        expected = env.reset(seed=3)[0]["goal"]
        again = copied(env)
        with pytest.raises(ContractError, match="before the first reset"):
            again.step(again.action_space.sample())
        np.testing.assert_array_equal(again.reset(seed=3)[0]["goal"], expected)


@pytest.mark.parametrize("missing", ["rerun", "PIL"])
def test_render_modes_are_those_that_can_work(missing: str) -> None:
    program = f"""
import sys
sys.modules[{missing!r}] = None
import gymnasium, threewe
from gymnasium.utils.env_checker import check_env
for name in {IDS!r}:
    env = gymnasium.make(name, scene=[threewe.Scene.generate(1, size=(8.0, 6.0))], observations=("pose",)).unwrapped
    check_env(env)
print(env.metadata["render_modes"])
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert said.strip() == ("['rgb_array']" if missing == "rerun" else "[]")


def test_an_unknown_argument_is_a_type_error_as_of_any_function() -> None:
    """TorchRL finds out so that there is no `frameskip`."""
    with pytest.raises(TypeError, match="unexpected keyword argument 'frameskip'"):
        gymnasium.make("3we/Navigation-v1", frameskip=1)
    with pytest.raises(ConfigError, match="did you mean 'max_steps'"):
        Env(task="navigation", max_step=1)  # type: ignore[call-arg]


def test_a_robot_without_lidar_has_its_own_default_observations() -> None:
    for name in ("Navigation", "ObjectNav", "VLN"):
        env = gymnasium.make(f"3we/{name}-v1", **SMALL, hardware="3we_base_v2")
        check_env(env.unwrapped, skip_render_check=True)
        assert isinstance(env.observation_space, gymnasium.spaces.Dict)
        assert {"image", "pose", "velocity"} < set(env.observation_space)
        assert "lidar" not in env.observation_space
    with pytest.raises(ConfigError, match="'3we_base_v2' has none"):
        gymnasium.make("3we/Exploration-v1", **SMALL, hardware="3we_base_v2")
    with pytest.raises(ConfigError, match="use 'limits'"):
        gymnasium.make("3we/Navigation-v1", **SMALL, hardware="3we_base_v2", gate="full")


@pytest.mark.parametrize("backend", [None, "mock"])
def test_what_is_observed_has_the_types_of_a_robot(backend: str | None) -> None:
    options: dict[str, Any] = {**SMALL, "hardware": "3we_depth_v2", "image_size": (48, 64), "backend": backend}
    env = Env(task="navigation", observations=("image", "depth", "lidar", "pose", "velocity"), **options)
    observation, _ = env.reset(seed=0)
    with threewe.sync.Robot(scene="office_v2", hardware="3we_depth_v2", image_size=(48, 64)) as robot:
        pictures = robot.get_rgbd_image()
        own = {"image": pictures.color, "depth": pictures.depth, "lidar": robot.get_lidar_scan().ranges}
    for name, values in own.items():
        assert (observation[name].dtype, observation[name].shape) == (values.dtype, values.shape)
    assert [observation[name].dtype for name in ("pose", "velocity")] == [np.float32, np.float32]


@pytest.mark.parametrize("backend", [None, "mock"])
def test_object_nav_always_has_a_way_to_drive(backend: str | None) -> None:
    options: dict[str, Any] = {"task": "object_nav", "observations": ("object_goal",)}
    many = VectorEnv(num_envs=300, **options)
    _, infos = many.reset(seed=0)
    assert infos["shortest_path"].min() >= 1.0
    env = Env(**options, backend=backend)
    for seed in np.argsort(infos["shortest_path"])[:3].tolist():
        _, info = env.reset(seed=seed)
        assert info["shortest_path"] == infos["shortest_path"][seed]
        assert info["object_goal"] == many.instruction(seed)


@pytest.mark.parametrize("env", [2, -1, 10**9, 10**30, 0.5])
def test_an_environment_that_is_not_there_is_refused(env: Any) -> None:
    envs = VectorEnv(num_envs=2, **GOAL)
    envs.reset(seed=0)
    for ask in (envs.episode, envs.instruction, envs.randomization):
        with pytest.raises(ContractError, match=r"^env"):
            ask(env)
    assert envs.episode(1).seed == 1


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"num_envs": 10**12}, "num_envs: 1 to 1000000, got 1000000000000"),
        ({"num_envs": 0.5}, "num_envs must be a whole number"),
        ({"num_threads": -1}, "num_threads must be a whole number"),
        ({"image_size": (8192, 8192), "observations": ("image",)}, "image_size: 1 to 2048 pixels each way"),
        ({"image_size": 64}, "image_size must be a list"),
        ({"max_steps": 1.5}, "max_steps must be a whole number"),
    ],
)
def test_sizes_beyond_what_there_is_are_refused(options: dict[str, Any], says: str) -> None:
    with pytest.raises((ConfigError, ContractError)) as error:
        VectorEnv(**{**GOAL, **options})
    assert says in str(error.value)


def test_more_threads_than_the_system_gives_are_refused() -> None:
    program = """
import resource, threewe
from threewe.gym import VectorEnv
options = dict(task="navigation", scene="corridor_v1", observations=("goal",))
VectorEnv(**options)
resource.setrlimit(resource.RLIMIT_AS, (4 << 30, resource.RLIM_INFINITY))
try:
    VectorEnv(**options, num_envs=4096, num_threads=4096)
except threewe.ConfigError as error:
    print(error)
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert said.startswith("num_threads: the system gives")
    VectorEnv(num_envs=2, num_threads=10**12, **GOAL).reset(seed=0)  # no more than there are environments


def test_a_second_thread_is_refused_by_name() -> None:
    envs = VectorEnv(num_envs=64, **GOAL)
    envs.reset(seed=0)
    refused: list[str] = []

    def drive() -> None:
        while not refused:
            try:
                envs.step(np.ones((64, 3), np.float32))
            except ContractError as error:
                refused.append(str(error))

    threads = [threading.Thread(target=drive) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert refused[0].startswith("step() while another thread is in a call of the same environment")


def test_a_batch_with_threads_is_refused_after_a_fork() -> None:
    program = """
import os, signal, threewe, numpy as np
from threewe.gym import VectorEnv
made = {n: VectorEnv(task="navigation", scene="corridor_v1", num_envs=2, num_threads=n) for n in (1, 2)}
for envs in made.values():
    envs.reset(seed=0)
pid = os.fork()
if pid == 0:
    signal.alarm(20)
    made[1].step(np.ones((2, 3), np.float32))
    try:
        made[2].step(np.ones((2, 3), np.float32))
    except threewe.ContractError as error:
        print(error, flush=True)
    raise SystemExit(0)
assert os.waitpid(pid, 0)[1] == 0
made[2].step(np.ones((2, 3), np.float32))
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert "before the process was forked" in said


@pytest.mark.parametrize(
    ("library", "task"),
    [
        pytest.param("sb3", "Navigation", marks=pytest.mark.nightly),
        pytest.param("cleanrl", "ObjectNav", marks=pytest.mark.nightly),
        ("sb3_tools", "VLN"),
    ],
)
def test_other_peoples_trainers_learn_without_a_warning(library: str, task: str) -> None:
    pytest.importorskip("stable_baselines3", reason="not shown: stable-baselines3 is not installed")
    pytest.importorskip("moviepy", reason="not shown: moviepy is not installed")
    command = [sys.executable, "-m", "tests.interop.rl", library, task]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
