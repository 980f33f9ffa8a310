"""A few drives in places that are drawn; `./dev verify navigation` has hundreds."""

from __future__ import annotations

from pathlib import Path

import pytest

from verify.cases.driving import truly_there
from verify.cases.generated import WALKERS, drive_far, ends_standing, in_generated, no_clock, peopled


@pytest.mark.parametrize("hardware", ["3we_standard_v2", "turtlebot_like"])
@pytest.mark.parametrize("place", ["building", "hall", "corridor"])
def test_no_arrival_is_false_and_no_drive_ends_by_a_clock(place: str, hardware: str) -> None:
    for seed in (31, 32):
        case = in_generated(seed, drive_far, place, hardware=hardware)
        assert truly_there(case), case
        assert no_clock(case), case
        assert ends_standing(case), case
        assert case["contact_speed"] <= 0.05, case


def test_people_walk_in_generated_buildings() -> None:
    assert 1 <= len(in_generated(5, names_of_people, "peopled")["people"]) <= WALKERS
    assert peopled(6) == peopled(6)


def names_of_people(seed: int, scene: str) -> dict[str, list[str]]:
    del seed
    return {"people": [line.split()[2] for line in Path(scene).read_text().splitlines() if "walker_" in line]}
