"""What robots are measured by."""

from __future__ import annotations

import pytest
from threewe import HardwareError, RobotProfile, Scene, SceneTables
from threewe.benchmark import nearest_frontier, optimistic_replanning, spl

PROFILE = RobotProfile.load("3we_standard_v2")


def test_spl_as_published() -> None:
    assert spl(success=True, shortest=4.0, driven=5.0) == pytest.approx(0.8)
    assert spl(success=True, shortest=4.0, driven=3.0) == 1.0
    assert spl(success=True, shortest=0.0, driven=0.2) == 1.0
    assert spl(success=False, shortest=0.0, driven=0.0) == 0.0
    assert spl(success=False, shortest=4.0, driven=4.0) == 0.0


def test_the_optimist_is_hard_to_beat_and_not_beyond_the_truth() -> None:
    tables = SceneTables(Scene.load("apartment_v1"), PROFILE)
    for seed in range(3):
        episode = tables.sample_episode(seed)
        best = optimistic_replanning(tables, PROFILE, episode.start, episode.goal)
        assert best.reached, seed
        assert 0.98 * episode.geodesic < best.length < 4.0 * episode.geodesic, seed
        assert best.duration == pytest.approx(best.length / PROFILE.operating_limits.linear)
        assert repr(best).startswith("ReferenceDrive(reached, ")


def test_the_nearest_frontier_shows_a_whole_building() -> None:
    tables = SceneTables(Scene.generate(3, size=(8.0, 6.0)), PROFILE)
    seen = nearest_frontier(tables, PROFILE, tables.sample_free_pose(1))
    assert seen.coverage > 0.95
    assert seen.duration == pytest.approx(seen.length / PROFILE.operating_limits.linear)
    assert "% covered" in repr(seen)


def test_references_need_a_lidar() -> None:
    profile = RobotProfile.load("3we_base_v2")
    tables = SceneTables(Scene.load("apartment_v1"), profile)
    with pytest.raises(HardwareError, match="'3we_base_v2' has no sensor 'lidar'"):
        optimistic_replanning(tables, profile, tables.sample_free_pose(0), (1.0, 0.0))
