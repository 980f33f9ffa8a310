"""Whatever numbers a program passes, it gets an answer or an error: nothing dies, hangs or raises something else."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import threewe
import threewe.gym
from extreme_calls import GROUPS
from threewe import ContractError, OccupancyGrid, Robot

PROGRAM = Path(__file__).parent / "extreme_calls.py"
SEED = 20261123


@pytest.mark.parametrize("group", GROUPS)
def test_extreme_arguments(group: str) -> None:
    command = [sys.executable, PROGRAM, group, str(SEED), "300"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.parametrize("index", [-1, 2, 2**31, 2**63, 2**64, 10**400, 0.5, "0", None])
@pytest.mark.parametrize("method", ["episode", "instruction", "randomization"])
def test_an_environment_that_a_batch_has_not(method: str, index: object) -> None:
    batch = threewe.gym.VectorEnv(task="vln", num_envs=2, scene="corridor_v1")
    batch.reset(seed=0)
    for env in (0, 1, np.int64(1)):
        assert getattr(batch, method)(env) is not None
    with pytest.raises(ContractError, match="env"):
        getattr(batch, method)(index)


async def test_a_robot_beyond_the_grid_of_its_map_finds_no_path() -> None:
    far = OccupancyGrid(np.zeros((40, 40), np.int8), 0.05, (410.0, 0.0))
    async with Robot(scene="corridor_v1", noise="ideal", localization="truth", map=far, initial_pose=(0, 0)) as robot:
        result = await robot.move_to(1.0, 0.0, timeout=2.0)
        assert result.reason in (threewe.Reason.no_path, threewe.Reason.timeout, threewe.Reason.blocked)


async def test_a_snapshot_is_restored_in_a_world_like_its_own_alone() -> None:
    grid = OccupancyGrid(np.zeros((200, 600), np.int8), 0.05, (-10.0, -5.0))
    own = {"scene": "corridor_v1", "noise": "ideal", "map": grid, "initial_pose": (0.0, 0.0)}
    async with Robot(**own) as robot:  # type: ignore[arg-type]
        assert robot.simulation is not None
        snapshot = robot.simulation.save()
        robot.simulation.restore(snapshot)
    others: list[tuple[dict[str, object], str]] = [
        ({"localization": "truth"}, "localization 'slam', this one has 'truth'"),
        ({"map": None}, "another map"),
        ({"map": OccupancyGrid(np.ones((200, 600), np.int8), 0.05, (-10.0, -5.0))}, "another map"),
        ({"initial_pose": (1.0, 0.0)}, "another initial_pose"),
        ({"image_size": (24, 32)}, "pictures of 640 x 480 px of robot 0, this one has 32 x 24"),
    ]
    for options, message in others:
        async with Robot(**{**own, **options}) as other:  # type: ignore[arg-type]
            assert other.simulation is not None
            before = other.simulation.true_pose()
            with pytest.raises(ContractError, match=f"restore: saved from a world with {message}"):
                other.simulation.restore(snapshot)
            assert other.simulation.true_pose() == before
