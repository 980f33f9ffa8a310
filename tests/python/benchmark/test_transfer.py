"""Transfer: matched episodes on two backends, and the ratio of success with its interval."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threewe import ConfigError
from threewe.benchmark.attempt import Settings
from threewe.benchmark.transfer import TransferPlan, plan_transfer, ratio_interval, run_transfer, transfer_summary


def planned(**how: Any) -> TransferPlan:
    given = {"task": "pointnav", "split": "val", "scenes": ["apartment_v1"], "episodes": 2, "seeds": 2, "matched": 1}
    return plan_transfer("navigator", "mock", "mujoco", **(given | how), settings=Settings())


def test_the_targets_episodes_are_the_sources(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    plan = planned()
    assert len({(episode.index, episode.seed) for episode in plan.on_source}) == 4
    assert plan.on_target == plan.on_source[:1]
    found = run_transfer(plan, tmp_path / "transfer.json", workers=0)
    assert found["summary"]["source"]["count"] == 4
    assert found["summary"]["target"]["count"] == 1
    assert found["summary"]["ratio"]["value"] == 1.0
    assert found["summary"]["matched"] == {"source": 1.0, "target": 1.0}
    assert (found["source_backend"], found["target_backend"]) == ("mock", "mujoco")


def test_scenes_take_turns() -> None:
    plan = planned(scenes=["office_v2", "corridor_v1"], episodes=4)
    assert [episode.scene for episode in plan.on_source[:4]] == ["office_v2", "corridor_v1"] * 2


def test_what_cannot_be_matched_is_refused() -> None:
    with pytest.raises(ConfigError, match="3 cannot be matched with 2"):
        planned(matched=3)
    with pytest.raises(ConfigError, match="61 were asked for, there are 60"):
        planned(episodes=61)


def test_a_ratio_of_nothing_is_none() -> None:
    rows = [{"scene": "a", "index": 0, "seed": 0, "success": 0.0}]
    assert transfer_summary(rows, rows)["ratio"] is None


def test_the_ratios_interval_covers() -> None:
    draw = np.random.default_rng(1)
    covered = 0
    for _ in range(2000):
        first, second = int(draw.binomial(40, 0.8)), int(draw.binomial(150, 0.9))
        low, high = ratio_interval((first, 40), (second, 150))
        covered += low <= 0.8 / 0.9 <= high
    assert 0.93 < covered / 2000 < 0.98
    assert ratio_interval((10, 10), (150, 150)) == pytest.approx((0.722, 1.026), abs=1e-3)
    assert ratio_interval((0, 10), (150, 150))[0] == 0.0
