"""Stable-Baselines3's PPO, A2C and SAC on the plain environment, and DQN behind a wrapper that chooses directions."""

import warnings

import gymnasium
import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3 import A2C, DQN, PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.env_checker import check_env

# what keeps updates few and small: whether it learns is not the question
SETTINGS = {
    PPO: {"n_steps": 500, "batch_size": 125, "n_epochs": 1},
    A2C: {"n_steps": 20},
    SAC: {"buffer_size": 2_000, "learning_starts": 1_900, "batch_size": 32},
    DQN: {"buffer_size": 2_000, "learning_starts": 1_500, "batch_size": 32},
}


class Directions(gymnasium.ActionWrapper):
    """Ahead, left, right, and standing still."""

    CHOICES = np.array([[1.0, 0.0, 0.0], [0.3, 0.0, 1.0], [0.3, 0.0, -1.0], [0.0, 0.0, 0.0]], np.float32)

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        self.action_space = spaces.Discrete(len(self.CHOICES))

    def action(self, action: int) -> np.ndarray:
        return self.CHOICES[action]


def train(name: str, steps: int) -> str:
    warnings.simplefilter("error")
    torch.set_num_threads(1)
    check_env(gymnasium.make(name))
    return ", ".join(train_one(algorithm, name, steps) for algorithm in SETTINGS)


def train_one(algorithm: type[BaseAlgorithm], name: str, steps: int) -> str:
    env = gymnasium.make(name)
    if algorithm is DQN:
        env = Directions(env)
    model = algorithm("MultiInputPolicy", env, seed=1, device="cpu", **SETTINGS[algorithm])
    model.learn(steps)
    assert model.num_timesteps >= steps
    episodes = model.ep_info_buffer
    assert len(episodes) > 0  # `Monitor`, which the algorithm wraps around it, has counted them
    reward = np.mean([episode["r"] for episode in episodes])
    assert np.isfinite(reward)
    assert all(torch.isfinite(weights).all() for weights in model.policy.state_dict().values())
    env.close()
    return f"{algorithm.__name__} {reward:.2f}"
