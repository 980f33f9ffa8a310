"""Tensors that share memory with C++."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import threewe
from threewe import ContractError
from threewe.gym import VectorEnv

pytest.importorskip("torch", reason="not shown: torch is not installed")
import torch
from threewe.gym.torch import TorchVectorEnv

OPTIONS: dict[str, Any] = {
    "task": "navigation",
    "num_envs": 3,
    "scene": [threewe.Scene.generate(1, size=(8.0, 6.0))],
    "observations": ("image", "lidar", "pose", "goal"),
    "max_steps": 5,
}


def test_tensors_are_the_memory_of_the_batch_and_hold_what_a_batch_gives() -> None:
    env, batch = TorchVectorEnv(**OPTIONS), VectorEnv(**OPTIONS)
    observations, _ = env.reset(seed=1)
    expected, _ = batch.reset(seed=1)
    for _ in range(8):
        for name, values in env._core.observations.items():
            assert observations[name].data_ptr() == values.ctypes.data
            np.testing.assert_array_equal(observations[name].numpy(), expected[name], strict=True)
        actions = torch.rand((3, 3)) * 2 - 1
        observations, *outcome, infos = env.step(actions)
        expected, *others, other_infos = batch.step(actions.numpy())
        for mine, other, values in zip(
            outcome, others, (env._core.rewards, env._core.terminated, env._core.truncated), strict=True
        ):
            assert mine.data_ptr() == values.ctypes.data
            np.testing.assert_array_equal(mine.numpy(), other, strict=True)
        np.testing.assert_array_equal(infos["success"], other_infos["success"])


def test_actions_are_read_where_they_are() -> None:
    """What the core is given is the tensor's own memory."""
    actions = torch.rand((3, 3))
    given = threewe.gym.batch.as_actions(actions.numpy(), (3, 3))
    assert given.ctypes.data == actions.data_ptr()


def test_teams_and_gradients() -> None:
    env = TorchVectorEnv(**OPTIONS, num_robots=2)
    observations, _ = env.reset(seed=1)
    assert observations["lidar"].shape == (3, 2, 360)
    _, rewards, *_ = env.step(torch.zeros((3, 2, 3), requires_grad=True))
    assert rewards.shape == (3, 2)
    with pytest.raises(ContractError, match="floating-point"):
        env.step(torch.zeros((3, 2, 3), dtype=torch.int64))


def test_without_torch_the_extra_is_named() -> None:
    program = """
import sys
sys.modules["torch"] = None
import threewe
try:
    import threewe.gym.torch
except threewe.ConfigError as error:
    print(error)
"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert 'pip install "threewe[train]"' in said
