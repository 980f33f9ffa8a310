"""What is learned is the same wherever it runs: in PyTorch, from safetensors, as ONNX."""

from __future__ import annotations

import heapq
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
    goal = uniform(-8.0, 8.0, 2)
    grid, ways = ppo.nothing_yet(goal)
    grid += (uniform(0.0, 1.0, ppo.CELLS**2) * 8.0 - 5.0).round() * (grid == 0.0)
    ways += uniform(0.0, 3.0, ppo.CELLS**2)
    return {"lidar": lidar, "goal": goal, "grid": grid, "ways": ways, "chance": uniform(0.0, 1.0, ppo.CHOICES)}


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
    lidar, goal, grid, ways, chance = scans(ppo, 20).values()
    memory = [torch.zeros_like(grid), torch.zeros_like(ways)]  # which are not turned: maps have the axes of the robot
    seen = ppo.features(lidar, goal, *memory)
    for beams in (1, 7, 36, 71):
        angle = torch.tensor(2.0 * torch.pi * beams / 72)
        by = torch.stack([angle.cos(), angle.sin()])[None]
        lidar_then, goal_then = lidar.roll(beams, dims=1), ppo.turned(goal[:, None], by).squeeze(1)
        seen_then = ppo.features(lidar_then, goal_then, *memory)
        same = (seen_then[:, :72] == seen[:, :72]).all(dim=1)
        assert same.float().mean() > 0.9  # but where the goal lies midway between two beams
        torch.testing.assert_close(seen_then[same], seen[same], atol=1e-4, rtol=1e-4)
        choice = ppo.chosen(policy.logits(seen), chance)
        torch.testing.assert_close(ppo.chosen(policy.logits(seen_then), chance)[same], choice[same])
        driven, driven_then = ppo.actions_of(choice, goal), ppo.actions_of(choice, goal_then)
        torch.testing.assert_close(driven_then[:, :2], ppo.turned(driven[:, None, :2], by).squeeze(1))


def test_what_it_sees_is_on_the_map(ppo: ModuleType) -> None:
    """A robot 3 m before its goal, amid things 1 m away in all directions."""
    goal = torch.tensor([[3.0, 0.0]])
    grid, _ = ppo.nothing_yet(goal)
    for _ in range(4):
        grid = ppo.mapped(torch.ones(1, 72), goal, grid)
    grid = grid.reshape(ppo.CELLS, ppo.CELLS)
    row, column = torch.meshgrid(*[(torch.arange(ppo.CELLS) - ppo.CELLS // 2) * ppo.CELL] * 2, indexing="ij")
    away = torch.hypot(column + 3.0, row)  # from the robot, which sees its goal ahead, at x = 0
    inside = grid[1:-1, 1:-1]
    assert grid[away < 0.1] == 4.0
    assert ((away[1:-1, 1:-1] - 1.175).abs()[inside < 0.0] < 0.1 + ppo.CELL).all()
    assert (inside < 0.0).sum() > 2.0 * torch.pi * 1.1 / ppo.CELL  # closed all around


def test_ways_become_the_shortest(ppo: ModuleType) -> None:
    """Swept often enough they are those of Dijkstra's algorithm."""
    draw, size = torch.Generator().manual_seed(4), ppo.CELLS
    grid, ways = ppo.nothing_yet(torch.zeros(1, 2))
    grid += (torch.rand(grid.shape, generator=draw) * 4.0 - 2.5).round().clamp_min(-1.0) * (grid == 0.0)
    for _ in range(4 * size):
        ways = ppo.swept(ways, grid)
    effort = (ppo.CELL + ppo.THING * (-grid).clamp_min(0) + ppo.STAY * grid.clamp_min(0)).double()[0].tolist()
    goal = size * size // 2
    shortest, queue = {}, [(0.0, goal)]
    while queue:
        length, here = heapq.heappop(queue)
        if here in shortest:
            continue
        shortest[here] = length
        for step in (-size - 1, -size, -size + 1, -1, 1, size - 1, size, size + 1):
            row, column = divmod(here + step, size)
            if 0 < row < size - 1 and 0 < column < size - 1 and here + step not in shortest:
                factor = 1.0 if abs(step) in (1, size) else 2.0**0.5
                heapq.heappush(queue, (length + factor * effort[here + step], here + step))
    expected = torch.tensor([shortest[cell] for cell in sorted(shortest)])
    torch.testing.assert_close(ways[0, sorted(shortest)], expected, atol=1e-3, rtol=1e-5)


def test_it_knows_how_far_it_can_drive(ppo: ModuleType) -> None:
    """Of walls that are as far apart as it needs, it sees that there is room between them, and none through them."""
    angles = torch.arange(72) * (2.0 * torch.pi / 72)  # from the goal's direction
    for half_width, ahead in ((0.21, 12.0 - 0.2), (0.19, 0.0)):
        walls = half_width / angles.sin().abs().clamp_min(1e-9)
        room = ppo.room(walls.clamp_max(12.0)[None])[0]
        assert room[0] == pytest.approx(ahead)
        assert room[ppo.HEADINGS // 4] == pytest.approx(0.0, abs=0.02)  # to its left


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
    rollout = ppo.Rollout(*[nothing] * 4, rewards, values, terminated, ended, nothing)
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
