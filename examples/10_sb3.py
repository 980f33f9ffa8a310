"""The same lesson as 09_ppo.py with Stable-Baselines3, on the same batch of environments.

    python 10_sb3.py --seed 1

It needs `pip install "threewe[train]"`. `TowardsGoal` is all that is our own: it shows the world turned until the goal
lies ahead, and turns the velocity that is chosen back.
"""

import argparse
import time

import numpy as np
from gymnasium import spaces
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnvWrapper, VecMonitor
from threewe.benchmark import load_episodes
from threewe.gym.episodes import evaluate
from threewe.gym.sb3 import SB3VecEnv

BEAMS = 72
OPTIONS = {"observations": ("lidar", "goal"), "lidar_beams": BEAMS, "control_rate": 5.0, "num_threads": 2}


class TowardsGoal(VecEnvWrapper):
    """Shows (n, 73): exp(-range) counter-clockwise from the goal's direction, and exp(-distance) to the goal."""

    def __init__(self, venv: SB3VecEnv) -> None:
        super().__init__(venv, spaces.Box(0.0, 1.0, (BEAMS + 1,), np.float32))

    def reset(self) -> np.ndarray:
        return self._turned(self.venv.reset())

    def step_async(self, actions: np.ndarray) -> None:
        self.venv.step_async(turned_back(actions, self.goal))

    def step_wait(self) -> tuple:
        observations, rewards, ended, infos = self.venv.step_wait()
        for info in infos:
            if "terminal_observation" in info:
                last = {name: values[None] for name, values in info["terminal_observation"].items()}
                info["terminal_observation"] = turned(last)[0]
        return self._turned(observations), rewards, ended, infos

    def _turned(self, observations: dict[str, np.ndarray]) -> np.ndarray:
        self.goal = observations["goal"]
        return turned(observations)


def turned(observations: dict[str, np.ndarray]) -> np.ndarray:
    lidar, goal = observations["lidar"], observations["goal"]
    near = np.where(lidar > 0.0, np.exp(-lidar), 0.0)  # 0 m is no measurement
    bearing = np.arctan2(goal[:, 1], goal[:, 0])
    first = np.round((bearing + np.pi) * (BEAMS / (2.0 * np.pi))).astype(int)  # beam 0 looks back
    order = (first[:, None] + np.arange(BEAMS)) % BEAMS
    distance = np.linalg.norm(goal, axis=1, keepdims=True)
    return np.hstack([np.take_along_axis(near, order, axis=1), np.exp(-distance)]).astype(np.float32)


def turned_back(actions: np.ndarray, goal: np.ndarray) -> np.ndarray:
    cos, sin = (goal / np.maximum(np.linalg.norm(goal, axis=1, keepdims=True), 1e-3)).T
    towards, across = actions[:, 0], actions[:, 1]
    return np.stack([cos * towards - sin * across, sin * towards + cos * across, actions[:, 2]], axis=1)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--steps", type=int, default=600_000)
    arguments.add_argument("--quick", action="store_true", help="too short to learn much")
    given = arguments.parse_args()
    num_envs, num_scenes, steps, each = (16, 2, 2_000, 2) if given.quick else (256, 12, given.steps, 100)

    began = time.perf_counter()
    batch = SB3VecEnv(
        task="navigation",
        num_envs=num_envs,
        scene="procedural",
        num_scenes=num_scenes,
        scene_seed=1000 * given.seed,
        episodes="reactive",
        max_steps=200,
        **OPTIONS,
    )
    envs = VecMonitor(TowardsGoal(batch))
    model = PPO(
        "MlpPolicy",
        envs,
        learning_rate=lambda left: 1.5e-3 * left,
        n_steps=32,
        batch_size=8 * num_envs,
        n_epochs=4,
        gamma=0.98,
        policy_kwargs={"log_std_init": -0.7},
        seed=given.seed,
        device="cpu",
    )
    model.learn(steps)
    print(f"{model.num_timesteps:,} steps in {time.perf_counter() - began:.0f} s")

    def act(observations: dict[str, np.ndarray]) -> np.ndarray:
        actions, _ = model.predict(turned(observations), deterministic=True)
        return turned_back(actions, observations["goal"])

    listed = load_episodes("reactive_v1")["episodes"]
    for scene in dict.fromkeys(episode.scene for episode in listed):
        chosen = [episode for episode in listed if episode.scene == scene][:each]
        outcomes = evaluate(act, chosen, max_steps=40 if given.quick else 500, **OPTIONS)
        print(f"{scene:14} {np.mean([outcome.success for outcome in outcomes]):.0%} of {len(chosen)}")


if __name__ == "__main__":
    main()
