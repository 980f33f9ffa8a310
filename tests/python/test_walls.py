"""Robots that start beside a wall, too near to turn: a small sample of `./dev verify navigation`."""

from __future__ import annotations

import pytest

from verify.cases.driving import arrived
from verify.cases.walls import away_from_a_wall, touches_gently


@pytest.mark.parametrize("hardware", ["turtlebot_like", "3we_standard_v2", "3we_depth_v2", "3we_base_v2"])
def test_a_robot_beside_a_wall_gets_away(hardware: str) -> None:
    cases = [away_from_a_wall(seed, hardware) for seed in range(70, 80)]
    assert [case["reason"] for case in cases] == ["reached"] * len(cases)
    assert all(arrived(case) for case in cases)
    assert all(touches_gently(case) for case in cases)
