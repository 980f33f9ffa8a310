"""A few drives in places that are drawn; `./dev verify navigation` has hundreds."""

from __future__ import annotations

import pytest

from verify.cases.generated import ends_standing, far_drives, no_clock, no_false_arrival, worst_contact


@pytest.mark.parametrize("hardware", ["3we_standard_v2", "turtlebot_like"])
@pytest.mark.parametrize("place", ["building", "hall", "corridor"])
def test_no_arrival_is_false_and_no_drive_ends_by_a_clock(place: str, hardware: str) -> None:
    for seed in (31, 32):
        case = far_drives(seed, place, hardware, drives=1)
        assert no_false_arrival(case), case
        assert no_clock(case), case
        assert ends_standing(case), case
        assert worst_contact(case) <= 0.05, case
