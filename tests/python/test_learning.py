"""What is learned is the same wherever it runs: in PyTorch, from safetensors, as ONNX."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from verify.learning import example

torch = pytest.importorskip("torch")
pytest.importorskip("safetensors")


@pytest.fixture(scope="module")
def ppo() -> ModuleType:
    return example()


def scans(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    draw = np.random.default_rng(count)
    lidar = draw.uniform(0.0, 12.0, (count, 72)) * (draw.uniform(size=(count, 72)) > 0.02)  # a few are invalid
    return tuple(  # type: ignore[return-value]
        values.astype(np.float32)
        for values in (lidar, draw.uniform(-8.0, 8.0, (count, 2)), draw.uniform(-8.0, 8.0, (count, 3, 2)))
    )


def some_policy(ppo: ModuleType) -> torch.nn.Module:
    torch.manual_seed(3)
    policy = ppo.Policy()
    for weights in policy.parameters():  # as if it had learned something
        weights.data += 0.2 * torch.randn_like(weights)
    return policy


def test_weights_are_kept(ppo: ModuleType, tmp_path: Path) -> None:
    policy = some_policy(ppo)
    ppo.save_weights(policy, tmp_path / "policy.safetensors")
    again = ppo.load_weights(tmp_path / "policy.safetensors")
    inputs = [torch.from_numpy(values) for values in scans(50)]
    for first, second in zip(policy(*inputs), again(*inputs), strict=True):
        assert torch.equal(first, second)


@pytest.mark.parametrize("robots", [1, 2, 33])
def test_onnx_says_what_torch_says(ppo: ModuleType, tmp_path: Path, robots: int) -> None:
    pytest.importorskip("onnx")
    onnxruntime = pytest.importorskip("onnxruntime")
    policy = some_policy(ppo)
    ppo.export_onnx(policy, tmp_path / "policy.onnx")
    session = onnxruntime.InferenceSession(tmp_path / "policy.onnx", providers=["CPUExecutionProvider"])
    inputs = scans(robots)
    actions, trail = session.run(None, dict(zip(("lidar", "goal", "trail"), inputs, strict=True)))
    with torch.no_grad():
        expected, followed = policy(*[torch.from_numpy(values) for values in inputs])
    assert actions.shape == (robots, 3)
    np.testing.assert_allclose(actions, expected.numpy(), atol=1e-5)
    np.testing.assert_allclose(trail, followed.numpy(), atol=1e-5)


def test_what_a_policy_sees_does_not_depend_on_where_it_looks(ppo: ModuleType) -> None:
    """Turned on the spot by a whole number of beams, it sees the same and drives the same way."""
    policy = some_policy(ppo)
    lidar, goal, trail = (torch.from_numpy(values) for values in scans(20))
    seen = ppo.features(lidar, goal, trail)
    for beams in (1, 7, 36, 71):
        angle = torch.tensor(2.0 * torch.pi * beams / 72)
        by = torch.stack([angle.cos(), angle.sin()])
        lidar_then, goal_then = lidar.roll(beams, dims=1), ppo.turned(goal, by)
        seen_then = ppo.features(lidar_then, goal_then, ppo.turned(trail, by))
        same = (seen_then[:, :72] == seen[:, :72]).all(dim=1)
        assert same.float().mean() > 0.9  # but where the goal lies midway between two beams
        torch.testing.assert_close(seen_then[same], seen[same], atol=1e-4, rtol=1e-4)
        chosen, chosen_then = policy.mean(seen, goal), policy.mean(seen_then, goal_then)
        torch.testing.assert_close(chosen_then[same], ppo.turned(chosen, by)[same], atol=1e-3, rtol=1e-3)


def test_advantages_are_what_their_definition_says(ppo: ModuleType) -> None:
    steps, robots = 12, 5
    settings = ppo.Settings(rollout=steps, num_envs=robots)
    generator = torch.Generator().manual_seed(1)
    rewards, values = (torch.randn(n, robots, generator=generator) for n in (steps, steps + 1))
    terminated = torch.rand(steps, robots, generator=generator) < 0.1
    ended = terminated | (torch.rand(steps, robots, generator=generator) < 0.1)
    nothing = torch.zeros(0)
    rollout = ppo.Rollout(nothing, nothing, nothing, nothing, nothing, rewards, values, terminated, ended, nothing)
    found = ppo.advantages(rollout, settings)
    for robot in range(robots):
        for begin in range(steps):
            expected, weight = 0.0, 1.0
            for t in range(begin, steps):
                ahead = 0.0 if terminated[t, robot] else values[t + 1, robot].item()
                reward = settings.reward_scale * (rewards[t, robot].item() - settings.haste)
                expected += weight * (reward + settings.discount * ahead - values[t, robot].item())
                weight *= settings.discount * settings.trace
                if ended[t, robot]:
                    break
            assert found[begin, robot].item() == pytest.approx(expected, abs=1e-5)
