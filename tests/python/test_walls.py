"""Robots that start where it is too tight to turn: a small sample of `./dev verify navigation`."""

from __future__ import annotations

import pytest

from verify.cases.driving import arrived
from verify.cases.walls import away_from_a_wall, comes_to_its_goal, out_of_a_slot, touches_gently


@pytest.mark.parametrize("hardware", ["turtlebot_like", "3we_standard_v2", "3we_depth_v2", "3we_base_v2"])
def test_a_robot_beside_a_wall_gets_away(hardware: str) -> None:
    cases = [away_from_a_wall(seed, hardware) for seed in range(70, 80)]
    assert [case["reason"] for case in cases] == ["reached"] * len(cases)
    assert all(arrived(case) for case in cases)
    assert all(touches_gently(case) for case in cases)


@pytest.mark.parametrize("hardware", ["turtlebot_like", "3we_standard_v2"])
def test_a_robot_at_the_end_of_a_slot_gets_out(hardware: str) -> None:
    cases = [out_of_a_slot(seed, hardware) for seed in range(20, 26)]
    assert all(comes_to_its_goal(case) for case in cases)
    assert all(touches_gently(case) for case in cases)
