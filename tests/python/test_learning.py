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


def scans(ppo: ModuleType, count: int) -> dict[str, torch.Tensor]:
    """What a policy takes: of what could be, more of everything than there ever is."""
    draw = torch.Generator().manual_seed(count)

    def uniform(low: float, high: float, *shape: int) -> torch.Tensor:
        return low + (high - low) * torch.rand(count, *shape, generator=draw)

    lidar = uniform(0.0, 12.0, 72) * (uniform(0.0, 1.0, 72) > 0.02)  # a few are invalid
    goal, trail = uniform(-8.0, 8.0, 2), uniform(-8.0, 8.0, len(ppo.SPANS), 2)
    visits = uniform(0.0, 5.0, ppo.CELLS**2).floor()
    return {"lidar": lidar, "goal": goal, "trail": trail, "visits": visits, "chance": uniform(0.0, 1.0, ppo.CHOICES)}


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
    inputs = scans(ppo, 50).values()
    for first, second in zip(policy(*inputs), again(*inputs), strict=True):
        assert torch.equal(first, second)


@pytest.mark.parametrize("robots", [1, 2, 33])
def test_onnx_says_what_torch_says(ppo: ModuleType, tmp_path: Path, robots: int) -> None:
    pytest.importorskip("onnx")
    onnxruntime = pytest.importorskip("onnxruntime")
    policy = some_policy(ppo)
    ppo.export_onnx(policy, tmp_path / "policy.onnx")
    session = onnxruntime.InferenceSession(tmp_path / "policy.onnx", providers=["CPUExecutionProvider"])
    inputs = scans(ppo, robots)
    outputs = session.run(None, {name: values.numpy() for name, values in inputs.items()})
    with torch.no_grad():
        expected = policy(*inputs.values())
    assert outputs[0].shape == (robots, 3)
    for found, wanted in zip(outputs, expected, strict=True):
        np.testing.assert_allclose(found, wanted.numpy(), atol=1e-5)


def test_what_a_policy_sees_does_not_depend_on_where_it_looks(ppo: ModuleType) -> None:
    """Turned on the spot by a whole number of beams, it sees the same and drives the same way."""
    policy = some_policy(ppo)
    lidar, goal, trail, _, chance = scans(ppo, 20).values()
    visits = torch.zeros(20, ppo.CELLS**2)  # which are not turned: its map has the axes of the robot
    seen = ppo.features(lidar, goal, trail, visits)
    for beams in (1, 7, 36, 71):
        angle = torch.tensor(2.0 * torch.pi * beams / 72)
        by = torch.stack([angle.cos(), angle.sin()])[None]
        lidar_then, goal_then = lidar.roll(beams, dims=1), ppo.turned(goal[:, None], by).squeeze(1)
        seen_then = ppo.features(lidar_then, goal_then, ppo.turned(trail, by), visits)
        same = (seen_then[:, :72] == seen[:, :72]).all(dim=1)
        assert same.float().mean() > 0.9  # but where the goal lies midway between two beams
        torch.testing.assert_close(seen_then[same], seen[same], atol=1e-4, rtol=1e-4)
        choice = ppo.chosen(policy.actor(seen), chance)
        torch.testing.assert_close(ppo.chosen(policy.actor(seen_then), chance)[same], choice[same])
        driven, driven_then = ppo.actions_of(choice, goal), ppo.actions_of(choice, goal_then)
        torch.testing.assert_close(driven_then[:, :2], ppo.turned(driven[:, None, :2], by).squeeze(1))


def test_it_remembers_where_it_has_been(ppo: ModuleType) -> None:
    """A robot that stood 0.6 m from here, on the goal's left, sees it there and nowhere else."""
    goal_then, goal = torch.tensor([[3.0, 0.0]]), torch.tensor([[3.0, 0.6]])  # it has moved to its right
    _, visits = ppo.nothing_yet(goal_then)
    for _ in range(4):
        visits = ppo.visited(visits, goal_then)
    assert visits.sum() == 4
    lidar, trail = torch.ones(1, 72), goal[:, None].repeat(1, len(ppo.SPANS), 1)
    around = ppo.features(lidar, goal, trail, visits)[0, -ppo.HEADINGS * len(ppo.LOOKS) :]
    near, far = around.reshape(len(ppo.LOOKS), ppo.HEADINGS)
    assert far.sum() == 0.0
    left = round((0.25 - np.arctan2(0.6, 3.0) / (2.0 * np.pi)) * ppo.HEADINGS)  # 0 is where the goal lies
    assert near[left] > 0.0
    assert near.nonzero().squeeze(1).sub(left).abs().max() <= 3  # a cell is wider than the way between two headings


def test_choices_come_as_often_as_they_should(ppo: ModuleType) -> None:
    count = 200_000
    logits = torch.tensor([0.2, 0.5, 0.3]).log().repeat(count, 1)
    chance = torch.rand(count, 3, generator=torch.Generator().manual_seed(5))
    shares = torch.bincount(ppo.chosen(logits, chance), minlength=3) / count
    torch.testing.assert_close(shares, torch.tensor([0.2, 0.5, 0.3]), atol=5e-3, rtol=0.0)
    assert (ppo.chosen(logits, torch.full((count, 3), 0.5)) == 1).all()  # the best one


def test_advantages_are_what_their_definition_says(ppo: ModuleType) -> None:
    steps, robots = 12, 5
    settings = ppo.Settings(rollout=steps, num_envs=robots)
    generator = torch.Generator().manual_seed(1)
    rewards, values = (torch.randn(n, robots, generator=generator) for n in (steps, steps + 1))
    terminated = torch.rand(steps, robots, generator=generator) < 0.1
    ended = terminated | (torch.rand(steps, robots, generator=generator) < 0.1)
    nothing = torch.zeros(0)
    rollout = ppo.Rollout(nothing, nothing, nothing, nothing, rewards, values, terminated, ended, nothing)
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
