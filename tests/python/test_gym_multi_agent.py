"""Teams of robots: by the letter of PettingZoo, and the batch of teams against single ones, to the bit."""

from __future__ import annotations

import subprocess
import sys
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
import threewe
from gymnasium.vector import AutoresetMode
from threewe import ConfigError, ContractError
from threewe.gym import VectorEnv
from threewe.gym.batch import TEAM_TASKS

pytest.importorskip("pettingzoo", reason="not shown: pettingzoo is not installed")
from pettingzoo.test import parallel_api_test, parallel_seed_test
from threewe.gym import MultiAgentEnv

SMALL: dict[str, Any] = {"scene": [threewe.Scene.generate(1, size=(8.0, 6.0))], "max_steps": 15}
LEAN: dict[str, Any] = {**SMALL, "observations": ("lidar", "pose")}
AHEAD = np.array([1.0, 0.0, 0.0], np.float32)
STAY = np.zeros(3, np.float32)


@pytest.mark.parametrize("task", TEAM_TASKS)
@pytest.mark.parametrize("robots", [2, 4])
def test_pettingzoo_finds_nothing(task: str, robots: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(MultiAgentEnv(task=task, num_robots=robots, **SMALL), num_cycles=40)
        parallel_seed_test(lambda: MultiAgentEnv(task=task, num_robots=robots, **SMALL))


@pytest.mark.parametrize("task", TEAM_TASKS)
@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_a_batch_of_teams_does_what_single_teams_do(task: str, mode: AutoresetMode) -> None:
    count, robots = 3, 2
    options = {**LEAN, "task": task, "num_robots": robots, "gate": "limits", "max_steps": 40}
    batch = VectorEnv(num_envs=count, autoreset_mode=mode, **options)
    teams = [MultiAgentEnv(**options) for _ in range(count)]
    observations, _ = batch.reset(seed=5)
    for i, team in enumerate(teams):
        assert_team(observations, i, team.reset(seed=5 + i)[0])

    rng = np.random.default_rng(3)
    ended_apart = 0
    for _ in range(130):
        actions = (rng.uniform(-1, 1, (count, robots, 3)) * (0.3, 0.3, 1) + (0.7, 0, 0)).astype(np.float32)
        observations, rewards, terminated, truncated, infos = batch.step(actions)
        assert rewards.shape == terminated.shape == truncated.shape == infos["success"].shape == (count, robots)
        for i, team in enumerate(teams):
            if not team.agents:  # its episode is over
                assert mode == AutoresetMode.NEXT_STEP
                assert not infos["active"][i].any()
                assert_team(observations, i, team.reset()[0])
                continue
            assert infos["active"][i].tolist() == [agent in team.agents for agent in team.possible_agents]
            seen, *outcome, info = team.step({agent: actions[i, int(agent[-1])] for agent in team.agents})
            for agent, values in info.items():
                robot = int(agent[-1])
                mine = [values_of[i, robot] for values_of in (rewards, terminated, truncated)]
                assert mine == [of_all[agent] for of_all in outcome]
                after = infos
                if not team.agents and mode == AutoresetMode.SAME_STEP:
                    after = infos["final_info"]
                for name in ("success", "path_length", "collision_speed"):
                    assert after[name][i, robot] == values[name]
            if team.agents or mode != AutoresetMode.SAME_STEP:
                assert_team(observations, i, seen)
                ended_apart += 0 < len(team.agents) < robots
                continue
            assert infos["_final_obs"][i]
            for agent, values in seen.items():
                for name, value in values.items():
                    np.testing.assert_array_equal(infos["final_obs"][i][name][int(agent[-1])], value)
            assert_team(observations, i, team.reset()[0])
        if mode == AutoresetMode.DISABLED:
            over = np.array([not team.agents for team in teams])
            if over.any():
                observations, _ = batch.reset(options={"reset_mask": over})
                for i in np.flatnonzero(over):
                    assert_team(observations, i, teams[i].reset()[0])
    assert (ended_apart > 0) == (task == "navigation")  # where one robot's end leaves the others at work


def assert_team(observations: dict[str, Any], env: int, seen: dict[str, Any]) -> None:
    for agent, values in seen.items():
        for name, value in values.items():
            np.testing.assert_array_equal(observations[name][env, int(agent[-1])], value, strict=True)


def test_make_vec_takes_teams() -> None:
    env = gymnasium.make_vec("3we/Exploration-v1", num_envs=4, num_robots=3, **LEAN)
    assert env.single_action_space.shape == (3, 3)
    assert env.observation_space["lidar"].shape == (4, 3, 360)  # type: ignore[index]
    observations, _ = env.reset(seed=0)
    assert observations in env.observation_space
    *_, truncated, infos = env.step(np.zeros((4, 3, 3), np.float32))
    assert truncated.shape == (4, 3)
    assert infos["active"].all()


def test_a_team_shares_its_map_and_its_reward() -> None:
    env = MultiAgentEnv(task="exploration", num_robots=2, localization="truth", noise="ideal", **SMALL)
    observations, _ = env.reset(seed=2)
    for _ in range(5):
        observations, rewards, *_ = env.step({"robot_0": AHEAD, "robot_1": STAY})
        assert rewards["robot_0"] == rewards["robot_1"]
    corner, other = (np.floor(observations[agent]["pose"][:2] / 0.25 + 0.5).astype(int) for agent in env.agents)
    shift = other - corner
    own, others = (observations[agent]["coverage_map"] for agent in env.agents)
    moved = np.roll(own, (-shift[1], -shift[0]), axis=(0, 1))
    assert np.mean(moved == others) > 0.99  # one map, two windows


def test_robots_see_and_block_one_another() -> None:
    options: dict[str, Any] = {**LEAN, "task": "navigation", "noise": "ideal", "gate": "limits", "max_steps": 200}
    env, alone = MultiAgentEnv(num_robots=2, **options), threewe.gym.Env(**options)
    for seed in range(20):  # until nothing stands between them
        seen, infos = env.reset(seed=seed)
        pose, other = (infos[agent]["true_pose"] for agent in env.agents)
        empty, _ = alone.reset(seed=seed, options={"start": tuple(pose)})
        if (seen["robot_0"]["lidar"] < empty["lidar"] - 0.1).sum() > 2:
            break
    away = np.hypot(*(other - pose)[:2])
    nearer = seen["robot_0"]["lidar"][seen["robot_0"]["lidar"] < empty["lidar"] - 0.1]
    assert away - 0.3 < nearer.min() < away  # [m]

    # robot_0 turns towards the other, and drives until they touch
    turn = np.inf
    while len(env.agents) == 2:
        ahead = 1.0 if abs(turn) < 0.05 else 0.0
        action = np.array([ahead, 0, np.clip(3 * turn, -1, 1) if np.isfinite(turn) else 0], np.float32)
        *_, infos = env.step({"robot_0": action, "robot_1": STAY})
        pose = infos["robot_0"]["true_pose"]
        turn = np.angle(np.exp(1j * (np.arctan2(*(other - pose)[1::-1]) - pose[2])))
    assert infos["robot_0"]["collision_speed"] > 0.05
    assert 0.2 < np.hypot(*(other - pose)[:2]) < 0.33  # [m]: two bodies, side by side


def test_who_is_done_leaves_and_keeps_its_metrics() -> None:
    env = MultiAgentEnv(task="navigation", num_robots=2, gate="limits", noise="ideal", **{**LEAN, "max_steps": 300})
    env.reset(seed=1)
    while len(env.agents) == 2:  # until a wall is in the way
        *_, infos = env.step({"robot_0": AHEAD, "robot_1": STAY})
    assert env.agents == ["robot_1"]
    assert infos["robot_0"]["collision_speed"] > 0.05
    assert not infos["robot_0"]["success"]
    assert infos["robot_1"]["collision_speed"] == 0.0
    with pytest.raises(ContractError, match="unknown agent 'robot_0'"):
        env.step({"robot_0": AHEAD, "robot_1": STAY})
    driven = infos["robot_0"]["path_length"]
    for _ in range(20):
        env.step({"robot_1": AHEAD})
    assert env._core.metrics[0, env._core.metric_names.index("path_length")] == driven


def test_what_does_not_fit_is_refused_by_name() -> None:
    for robots in (1, 5, "two"):
        with pytest.raises(ConfigError, match="num_robots must be 2, 3 or 4"):
            MultiAgentEnv(num_robots=robots, **LEAN)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="num_robots: 1 to 8, got 0"):
        VectorEnv(task="exploration", num_robots=0, **LEAN)
    env = MultiAgentEnv(num_robots=2, **LEAN)
    env.reset(seed=0)
    with pytest.raises(ContractError, match="robot_1 has none"):
        env.step({"robot_0": AHEAD})
    with pytest.raises(ContractError, match=r"must have shape \(3,\)"):
        env.step({"robot_0": AHEAD, "robot_1": np.zeros(2, np.float32)})
    with pytest.raises(ContractError, match=r"actions\[1, 0\] is nan"):
        env.step({"robot_0": AHEAD, "robot_1": np.full(3, np.nan, np.float32)})
    with pytest.raises(ConfigError, match="did you mean 'episode_number'"):
        env.reset(options={"epsode_number": 1})


def test_without_pettingzoo_the_extra_is_named() -> None:
    program = """
import sys
sys.modules["pettingzoo"] = None
import threewe.gym
try:
    threewe.gym.MultiAgentEnv
except threewe.ConfigError as error:
    print(error)
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert 'pip install "threewe[marl]"' in said
