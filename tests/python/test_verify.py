"""The arithmetic behind the rows of `./dev verify`."""

from __future__ import annotations

import pytest

from verify.harness import all_of, share_of, wilson


def test_wilson_is_exact_at_its_ends() -> None:
    for count in range(1, 300):
        assert wilson(count, count)[1] == 1.0
        assert wilson(0, count)[0] == 0.0


def test_wilson_as_published() -> None:
    # Newcombe 1998, table I: 81 of 263
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)


@pytest.mark.parametrize("count", range(1, 60))
def test_a_sample_without_a_miss_passes(count: int) -> None:
    cases = [{"right": True}] * count
    assert all_of("all", lambda case: case["right"]).judge(cases, True).status == "pass"


def test_a_miss_fails_a_claim_about_all_even_in_a_sample() -> None:
    cases = [{"right": True}] * 9 + [{"right": False}]
    assert all_of("all", lambda case: case["right"]).judge(cases, True).status == "FAIL"
    assert share_of("most", lambda case: case["right"], at_least=0.95).judge(cases, True).status == "pass"
    assert share_of("most", lambda case: case["right"], at_least=0.95).judge(cases, False).status == "FAIL"


def test_a_broken_case_counts_as_a_miss() -> None:
    cases = [{"right": True}, {"error": "boom"}]
    assert all_of("all", lambda case: case["right"]).judge(cases, True).status == "FAIL"
