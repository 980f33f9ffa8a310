"""Stable-Baselines3 on the native batch, against its own vectorisation of single environments."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
import threewe
from threewe import ContractError
from threewe.gym import TASKS, Env

pytest.importorskip("stable_baselines3", reason="not shown: stable-baselines3 is not installed")
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor
from threewe.gym.sb3 import SB3VecEnv

SMALL: dict[str, Any] = {"scene": [threewe.Scene.generate(1, size=(8.0, 6.0))], "max_steps": 15}
LEAN: dict[str, Any] = {**SMALL, "observations": ("lidar", "velocity", "goal"), "lidar_beams": 72}


@pytest.mark.parametrize("name", TASKS)
def test_check_env_finds_nothing(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(f"3we/{name}-v1", **SMALL), warn=True)


@pytest.mark.parametrize("task", TASKS.values())
def test_the_batch_does_what_single_environments_do(task: str) -> None:
    count = 3
    options: dict[str, Any] = {**SMALL, "task": task, "gate": "limits", "max_steps": 40}
    batch, single = SB3VecEnv(num_envs=count, **options), DummyVecEnv([lambda: Env(**options)] * count)
    assert batch.observation_space == single.observation_space
    assert batch.action_space == single.action_space
    for env in (batch, single):
        env.seed(7)
    assert_same(batch.reset(), single.reset())
    rng = np.random.default_rng(3)
    ends, cut = 0, 0
    for _ in range(130):
        actions = (rng.uniform(-1, 1, (count, 3)) * (0.3, 0.3, 1) + (0.7, 0, 0)).astype(np.float32)
        observations, rewards, dones, infos = batch.step(actions)
        expected = single.step(actions)
        assert_same(observations, expected[0])
        np.testing.assert_array_equal(rewards, expected[1], strict=True)
        np.testing.assert_array_equal(dones, expected[2], strict=True)
        for info, other, done in zip(infos, expected[3], dones, strict=True):
            assert bool(info) == done
            if done:
                ends += 1
                cut += info["TimeLimit.truncated"]
                assert_same(info["terminal_observation"], other["terminal_observation"])
                assert info["TimeLimit.truncated"] == other["TimeLimit.truncated"]
                assert info["is_success"] == other["success"]
                assert info["path_length"] == other["path_length"]
    assert ends > count
    assert cut > 0


def assert_same(ours: dict[str, Any], theirs: dict[str, Any]) -> None:
    assert ours.keys() == theirs.keys()
    for name, values in ours.items():
        np.testing.assert_array_equal(values, theirs[name], strict=True, err_msg=name)


def test_infos_of_an_end_stay_as_they_are() -> None:
    env = SB3VecEnv(task="navigation", num_envs=2, **LEAN)
    env.reset()
    for _ in range(15):
        *_, infos = env.step(np.zeros((2, 3), np.float32))
    kept = {name: values.copy() for name, values in infos[0]["terminal_observation"].items()}
    for _ in range(15):
        *_, later = env.step(np.ones((2, 3), np.float32))
    assert infos[0]["TimeLimit.truncated"]
    assert infos is not later
    assert_same(infos[0]["terminal_observation"], kept)


def test_ppo_runs() -> None:
    env = VecMonitor(SB3VecEnv(task="navigation", num_envs=8, **LEAN))
    model = PPO("MultiInputPolicy", env, n_steps=16, batch_size=64, n_epochs=1, seed=1, device="cpu")
    model.learn(256)
    assert len(model.ep_info_buffer) > 0
    action, _ = model.predict(env.reset())
    assert action.shape == (8, 3)


def test_seeds_and_options_are_those_of_the_next_reset() -> None:
    env = SB3VecEnv(task="navigation", num_envs=2, **LEAN, localization="truth", noise="ideal")
    env.seed(3)
    first = env.reset()
    second = env.reset()
    assert not np.array_equal(first["goal"], second["goal"])
    env.seed(3)
    assert_same(env.reset(), first)
    env.seed(3)
    env.set_options({"episode_number": 1})
    assert_same(env.reset(), second)
    env.set_options([{"episode_number": 1}, {"episode_number": 2}])
    with pytest.raises(ContractError, match="the same options"):
        env.reset()


def test_what_single_environments_alone_could_do_is_refused() -> None:
    env = SB3VecEnv(task="navigation", num_envs=2, **LEAN)
    assert env.get_attr("num_envs") == [2, 2]
    with pytest.raises(ContractError, match="one batch"):
        env.set_attr("num_envs", 3)
    with pytest.raises(ContractError, match="one batch"):
        env.env_method("reset")
