"""Intervals of means."""

from __future__ import annotations

import random

import numpy as np
import pytest
from threewe.benchmark.statistics import bootstrap, mean


def test_bootstrap_intervals_cover_and_are_the_same_again() -> None:
    draw = random.Random(1)
    covered = 0
    for _ in range(100):
        values = [draw.gauss(3.0, 1.0) for _ in range(40)]
        low, high = bootstrap(values)
        covered += low <= 3.0 <= high
        assert bootstrap(values) == (low, high)
        assert low <= mean(values) <= high
    assert covered > 87


def test_bootstrap_of_equal_values_is_that_value() -> None:
    assert bootstrap([0.1] * 7) == (0.1, 0.1)
    assert bootstrap([2.0]) == (2.0, 2.0)


def test_bootstrap_is_near_the_normal_interval() -> None:
    values = np.random.default_rng(1).normal(0.0, 1.0, 400)
    low, high = bootstrap(values.tolist())
    half = 1.96 * values.std() / 20.0
    assert (low, high) == pytest.approx((values.mean() - half, values.mean() + half), abs=0.02)
