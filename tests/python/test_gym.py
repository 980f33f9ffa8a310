"""Environments by the letter of Gymnasium; and the native batch against single environments, to the bit."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
import threewe
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from threewe import ConfigError, ContractError
from threewe.gym import TASKS, Env, VectorEnv
from threewe.gym.batch import TASK_FIELDS

IDS = [f"3we/{name}-v1" for name in TASKS]
SMALL: dict[str, Any] = {"scene": [threewe.Scene.generate(1, size=(8.0, 6.0))], "max_steps": 15}


def lean(task: str) -> dict[str, Any]:
    return {**SMALL, "observations": ("lidar", "pose", "velocity", *TASK_FIELDS[task]), "task": task}


@pytest.mark.parametrize("name", IDS)
def test_check_env_finds_nothing(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(name, **SMALL)
        check_env(env.unwrapped, skip_render_check=True)  # test_gym_rendering.py does
        assert env.observation_space == gymnasium.make(f"threewe:{name}", **SMALL).observation_space


@pytest.mark.parametrize("name", IDS)
def test_what_is_observed_by_default_and_on_request(name: str) -> None:
    env = gymnasium.make(name, **SMALL)
    spaces = env.observation_space
    assert isinstance(spaces, gymnasium.spaces.Dict)
    own = set(TASK_FIELDS[TASKS[name[4:-3]]])
    assert set(spaces) == {"image", "lidar", "pose", "velocity"} | own
    assert spaces["image"].shape == (64, 64, 3)
    assert spaces["lidar"].shape == (360,)
    observation, _ = env.reset(seed=0)
    assert observation in spaces
    assert observation["lidar"].max() > 0.5
    assert observation["image"].std() > 5

    fewer = gymnasium.make(
        name, **SMALL, observations=("depth", "lidar"), lidar_beams=72, image_size=(48, 64), hardware="3we_depth_v2"
    )
    assert {key: space.shape for key, space in fewer.observation_space.spaces.items()} == {  # type: ignore[attr-defined]
        "depth": (48, 64),
        "lidar": (72,),
    }
    few = [fewer.reset(seed=seed)[0] for seed in range(4)]  # one of them may face a wall that is too near to measure
    assert max(one["depth"].max() for one in few) > 0.3


def test_fewer_beams_are_every_kth() -> None:
    options: dict[str, Any] = {**SMALL, "observations": ("lidar",), "task": "navigation"}
    every, _ = Env(**options).reset(seed=4)
    for beams in (180, 120, 90, 72, 60):
        some, _ = Env(**options, lidar_beams=beams).reset(seed=4)
        np.testing.assert_array_equal(some["lidar"], every["lidar"][:: 360 // beams])


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("task", list(TASKS.values()))
def test_a_native_batch_does_what_gymnasium_makes_of_single_ones(task: str, mode: AutoresetMode) -> None:
    count = 3
    options = lean(task)
    native = VectorEnv(num_envs=count, autoreset_mode=mode, **options)
    sync = SyncVectorEnv([lambda: Env(**options)] * count, autoreset_mode=mode)
    assert native.observation_space == sync.observation_space
    assert native.action_space == sync.action_space
    assert_same(native.reset(seed=11), sync.reset(seed=11))
    rng = np.random.default_rng(5)
    for step in range(50):
        actions = rng.uniform(-1, 1, (count, 3)).astype(np.float32)
        ours, theirs = native.step(actions), sync.step(actions)
        assert_same(ours, theirs)
        over = ours[2] | ours[3]
        if mode == AutoresetMode.DISABLED and over.any():
            ours = native.reset(options={"reset_mask": over.copy()})
            theirs = sync.reset(options={"reset_mask": over.copy()})
            assert_same(ours[0], theirs[0])
        if step == 30:
            assert_same(native.reset(seed=[4, 1, 9]), sync.reset(seed=[4, 1, 9]))


TOLD_BY_METHODS = {
    *("scene", "seed", "episode_number", "true_pose", "scan_age", "randomization", "instruction", "object_goal")
}


def assert_same(ours: Any, theirs: Any, where: str = "") -> None:
    """Equal in every bit, except that a batch may say more in its infos."""
    if isinstance(theirs, dict):
        for key, value in theirs.items():
            if key.lstrip("_") in TOLD_BY_METHODS and key not in ours:
                continue
            assert_same(ours[key], value, f"{where}.{key}")
    elif isinstance(theirs, tuple):
        assert len(ours) == len(theirs)
        for i, (mine, other) in enumerate(zip(ours, theirs, strict=True)):
            assert_same(mine, other, f"{where}[{i}]")
    elif theirs.dtype == object:
        for i, (mine, other) in enumerate(zip(ours, theirs, strict=True)):
            assert (mine is None) == (other is None), f"{where}[{i}]"
            if mine is not None:
                assert_same(mine, other, f"{where}[{i}]")
    else:
        np.testing.assert_array_equal(ours, theirs, err_msg=where, strict=True)


def test_stopping_ends_object_nav_and_vln_right_or_wrong() -> None:
    for task in ("object_nav", "vln"):
        env = Env(**lean(task))
        _, info = env.reset(seed=0)
        words = info["object_goal" if task == "object_nav" else "instruction"]
        assert len(words) > 2
        for step in range(1, 6):  # 0.5 s at 10 Hz
            _, _, terminated, _, info = env.step(np.full(3, 0.04, np.float32))
            assert terminated == (step == 5)
        assert info["stopped"] == 1.0
        assert not info["success"]


def test_what_is_looked_for_can_be_asked_for() -> None:
    env = Env(**lean("object_nav"))
    observation, info = env.reset(seed=0, options={"object_goal": "chair"})
    assert info["object_goal"] == "chair"
    np.testing.assert_array_equal(observation["object_goal"], np.eye(10, dtype=np.float32)[0])
    with pytest.raises(ConfigError, match="did you mean 'chair'"):
        env.reset(options={"object_goal": "chiar"})


def test_object_nav_starts_where_it_is_asked_to() -> None:
    env = gymnasium.make("3we/ObjectNav-v1", scene="apartment_v1", observations=["object_goal"]).unwrapped
    env.reset(seed=1, options={"object_goal": "bed", "episode_number": 3})
    x, y, theta = env.reset(seed=1, options={"object_goal": "bed", "episode_number": 3})[1]["true_pose"]
    _, info = env.reset(seed=9, options={"object_goal": "bed", "start": (x, y, theta)})
    assert tuple(info["true_pose"]) == (x, y, theta)
    with pytest.raises(ConfigError, match="only with an object_goal"):
        env.reset(seed=9, options={"start": (x, y, theta)})


def test_navigation_with_stop_and_counted_contacts() -> None:
    env = gymnasium.make("3we/Navigation-v1", observations=["goal"], stop=True, contact="count").unwrapped
    env.reset(seed=1)
    info: dict[str, Any] = {}
    for step in range(5):  # half a second without a command is STOP
        _, _, terminated, _, info = env.step(np.zeros(3, np.float32))
        assert terminated == (step == 4)
    assert (info["stopped"], info["contacts"], info["success"]) == (1.0, 0.0, False)
    with pytest.raises(ConfigError, match="contact"):
        gymnasium.make("3we/Navigation-v1", contact="never")


def test_instructions_are_told_as_text_tokens_and_embedding() -> None:
    env = Env(**lean("vln"))
    observation, info = env.reset(seed=1)
    tokens = observation["instruction_tokens"]
    assert (tokens > 1).sum() == len(info["instruction"].replace(",", " ").replace(".", " ").split())
    assert tokens.dtype == np.int32
    assert np.linalg.norm(observation["instruction_embedding"]) == pytest.approx(1.0, abs=1e-6)


def test_make_vec_takes_the_native_batch() -> None:
    env = gymnasium.make_vec("3we/Navigation-v1", num_envs=4, observations=("goal",), **SMALL)
    assert isinstance(env.unwrapped, VectorEnv)
    env.reset(seed=0)
    for _ in range(14):
        *_, truncated, _ = env.step(np.zeros((4, 3), np.float32))
        assert not truncated.any()
    *_, truncated, _ = env.step(np.zeros((4, 3), np.float32))
    assert truncated.all()


def test_copies_are_safe_and_views_are_not_copies() -> None:
    options = {**lean("navigation"), "num_envs": 2}
    safe, fast = VectorEnv(**options), VectorEnv(**options, copy=False)
    first, begun = safe.reset(seed=1)
    seen, infos_of_reset = fast.reset(seed=1)
    kept = {name: values.copy() for name, values in first.items()}
    metrics = {name: values.copy() for name, values in begun.items()}
    assert_same(infos_of_reset, metrics)
    actions = np.ones((2, 3), np.float32)
    for env in (safe, fast):
        for _ in range(5):
            latest, *_, infos = env.step(actions)
    for name, values in kept.items():
        np.testing.assert_array_equal(first[name], values)
    for name, values in metrics.items():
        np.testing.assert_array_equal(begun[name], values)
    assert np.shares_memory(latest["pose"], seen["pose"])
    assert np.shares_memory(infos["path_length"], infos_of_reset["path_length"])
    assert infos_of_reset["path_length"].min() > 0.0 == begun["path_length"].max()
    assert infos["success"].dtype == np.bool_
    assert not np.array_equal(seen["pose"], kept["pose"])


def test_episodes_can_be_repeated() -> None:
    env = Env(**lean("navigation"))
    env.reset(seed=8)
    begins = [env.reset() for _ in range(4)]
    for observation, info in reversed(begins):
        again, same = env.reset(seed=info["seed"], options={"episode_number": info["episode_number"]})
        assert_same(again, observation)
        np.testing.assert_array_equal(info["true_pose"], same["true_pose"])
    _, asked = env.reset(options={"start": (0.0, 0.0, 0.5), "goal": (2.0, 1.0)})
    np.testing.assert_allclose(asked["true_pose"], (0.0, 0.0, 0.5))


@pytest.mark.parametrize(
    ("action", "says"),
    [
        ([np.nan, 0.0, 0.0], "actions must be finite, but actions[0, 0] is nan"),
        ([0.0, np.inf, 0.0], "actions must be finite, but actions[0, 1] is inf"),
        ([0.0, 0.0], "action must have shape (3,), got (2,)"),
        ([[0.0, 0.0, 0.0]], "action must have shape (3,), got (1, 3)"),
        (np.zeros(3, np.int64), "action must hold floating-point numbers, got dtype int64"),
        (["a", "b", "c"], "action must hold floating-point numbers, got dtype <U1"),
        (None, "action must hold floating-point numbers, got dtype object"),
    ],
)
def test_an_action_that_is_none_is_refused_and_changes_nothing(action: Any, says: str) -> None:
    env, untouched = Env(**lean("navigation")), Env(**lean("navigation"))
    for one in (env, untouched):
        one.reset(seed=2)
    with pytest.raises(ContractError) as error:
        env.step(action)
    assert str(error.value) == says
    good = np.array([1.0, 0.5, -0.5], np.float32)
    assert_same(env.step(good)[0], untouched.step(good)[0])


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"observations": ("lidr",)}, "unknown observation 'lidr'; did you mean 'lidar'?"),
        ({"observations": ()}, "observations: at least one is needed, such as 'goal'"),
        ({"observations": ("depth",)}, "observations: the camera of '3we_standard_v2' measures no depth"),
        ({"lidar_beams": 100}, "lidar_beams: every k-th of the 360 beams"),
        ({"scene": "ofice_v2"}, "unknown scene 'ofice_v2'; did you mean 'office_v2'?"),
        ({"gate": "ful"}, "unknown gate 'ful'; did you mean 'full'?"),
        ({"noise": "idal"}, "unknown noise 'idal'; did you mean 'ideal'?"),
        ({"localization": "thruth"}, "unknown localization 'thruth'; did you mean 'truth'?"),
        ({"episodes": "reactiv"}, "unknown episodes of navigation 'reactiv'; did you mean 'reactive'?"),
        ({"control_rate": 60}, "control_rate: 50 Hz over a whole number"),
        ({"control_rate": -1.0}, "control_rate must be positive, got -1"),
        ({"max_steps": 0}, "max_steps: at least 1, got 0"),
        ({"max_step": 7}, "unknown option 'max_step'; did you mean 'max_steps'?"),
        ({"render_mode": "rgb"}, "unknown render_mode 'rgb'; did you mean 'rgb_array'?"),
        ({"hardware": "3we_base_v2", "observations": ("lidar",)}, "observations: '3we_base_v2' has no lidar"),
    ],
)
def test_options_that_do_not_fit_are_refused_by_name(options: dict[str, Any], says: str) -> None:
    with pytest.raises(ConfigError) as error:
        Env(**{**SMALL, "task": "navigation", **options})
    assert says in str(error.value)


@pytest.mark.parametrize(
    ("randomization", "says"),
    [
        ("papr", "unknown randomization 'papr'; did you mean 'paper'?"),
        ({"reset": {"mas": 1}}, "randomization:1: reset.mas: unknown knob 'mas'; did you mean 'mass'?"),
        ({"reset": {"mass": [2, 1]}}, "randomization:1: reset.mass[1]: 1 is outside [2, 5]"),
        ({"reset": {"mass": {"unform": [1, 2]}}}, "unknown field 'unform'; did you mean 'uniform'?"),
        ({"reset": {"lidar_noise": {"log_uniform": [0, 2]}}}, "log_uniform needs a lower bound above 0"),
        ({"interval": {"every": [1, 2], "command_latency": [1, 2]}}, "stays as it is for an episode"),
        ({"interval": {"mass": 1}}, "missing field 'every'"),
        ({"rest": {}}, "unknown field 'rest'; did you mean 'reset'?"),
    ],
)
def test_randomisations_that_do_not_fit_are_refused(randomization: Any, says: str) -> None:
    with pytest.raises(ConfigError) as error:
        Env(**{**SMALL, "task": "navigation", "randomization": randomization})
    assert says in str(error.value)
    with pytest.raises(ContractError, match="finite numbers"):
        Env(**{**SMALL, "task": "navigation", "randomization": {"reset": {"mass": float("nan")}}})


def test_what_is_randomised_is_told_and_can_be_repeated() -> None:
    env = Env(**{**lean("navigation"), "randomization": "paper"})
    seen = [env.reset(seed=3)[1], *(env.reset()[1] for _ in range(20))]
    masses = [info["randomization"]["mass"] for info in seen]
    assert len(set(masses)) == 21
    assert all(0.9 <= mass <= 1.1 for mass in masses)
    assert len({info["randomization"]["camera_yaw"] for info in seen}) == 1  # drawn at startup
    _, again = env.reset(seed=3, options={"episode_number": 7})
    assert again["randomization"] == seen[7]["randomization"]
    _, plain = Env(**lean("navigation")).reset(seed=3)
    assert plain["randomization"]["mass"] == 1.0


def test_later_sensors_show_what_earlier_ones_showed_before() -> None:
    """The default profile's scans arrive after 0.02 s, its pictures after 0.08 s: ten times that is 2 steps and 8."""

    def drive(factor: int) -> list[dict[str, Any]]:
        env = Env(
            task="navigation",
            observations=("image", "lidar"),
            gate="limits",
            image_size=(24, 32),
            randomization={"reset": {"sensor_latency": factor}},
        )
        env.reset(seed=5)
        return [env.step(np.array([0.6, 0.0, 0.5], np.float32))[0] for _ in range(14)]

    early, late = drive(0), drive(10)
    for name, steps in {"lidar": 2, "image": 8}.items():
        for before, now in zip(early, late[steps:], strict=False):
            np.testing.assert_array_equal(before[name], now[name])
        assert (early[0][name] != early[1][name]).any()


def test_masks_and_seeds_that_do_not_fit_are_refused() -> None:
    env = VectorEnv(num_envs=2, **lean("navigation"))
    env.reset(seed=0)
    for mask in ([True, False], np.array([1, 0]), np.array([True]), np.array([False, False])):
        with pytest.raises(ContractError, match="reset_mask"):
            env.reset(options={"reset_mask": mask})
    with pytest.raises(ContractError, match="a list of 2"):
        env.reset(seed=[1, 2, 3])
    with pytest.raises(ContractError, match="seed must be a whole number"):
        env.reset(seed=-1)
    with pytest.raises(ConfigError, match="did you mean 'episode_number'"):
        env.reset(options={"epsode_number": 1})


def test_nan_in_a_batch_names_the_place() -> None:
    env = VectorEnv(num_envs=3, **lean("navigation"))
    env.reset(seed=0)
    actions = np.zeros((3, 3), np.float32)
    actions[2, 1] = np.nan
    with pytest.raises(ContractError, match=r"actions\[2, 1\] is nan"):
        env.step(actions)


def test_object_nav_in_sight() -> None:
    env = gymnasium.make("3we/ObjectNav-v1", episodes="in_sight", scene="apartment_v1", observations=["object_goal"])
    profile = threewe.RobotProfile.load("3we_standard_v2")
    scene = threewe.Scene.load("apartment_v1")
    task = threewe._core.ObjectNav(threewe.SceneTables(scene, profile), profile)
    kinds = set()
    for number in range(30):
        _, info = env.reset(seed=3, options={"episode_number": number})
        kinds.add(info["object_goal"])
        assert info["object_goal"] in task.in_sight(threewe.Pose2D(*info["true_pose"]))
    assert len(kinds) >= 5
    with pytest.raises(ConfigError, match="unknown episodes of object_nav 'reactive'"):
        gymnasium.make("3we/ObjectNav-v1", episodes="reactive")
    with pytest.raises(ConfigError, match="unknown episodes of vln 'in_sight'"):
        gymnasium.make("3we/VLN-v1", episodes="in_sight")
