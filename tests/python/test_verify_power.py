"""The powers that `./dev verify` states, in simulated runs: a drop of that size is missed nine times in ten."""

from __future__ import annotations

import math

import numpy as np
import pytest

from verify.harness.counts import Always, Rate, Share
from verify.harness.means import Counted, Mean
from verify.harness.rows import CAUGHT, Seen, Test

DRAWS = 10_000
CHANCE = 3.0 * math.sqrt(CAUGHT * (1.0 - CAUGHT) / DRAWS)  # that much a share of so many draws is off
Array = np.ndarray


def caught(test: Test, runs: list[Seen]) -> float:
    """The share of runs that miss their target."""
    return sum(not test.holds(seen) for seen in runs) / len(runs)


@pytest.mark.parametrize(
    ("target", "cases"), [(0.99, 64), (0.97, 40), (0.95, 24), (0.9, 12), (0.55, 16), (0.995, 200), (0.5, 30)]
)
def test_a_planted_drop_of_a_share_is_caught(target: float, cases: int) -> None:
    test = Share(target)
    drop = test.drop((cases, cases))
    hits = np.random.default_rng(1).binomial(cases, drop, DRAWS)
    assert drop < target
    assert caught(test, [(int(one), cases) for one in hits]) == pytest.approx(CAUGHT, abs=CHANCE)


@pytest.mark.parametrize("cases", [1, 4, 30, 200])
def test_a_planted_rate_of_violations_is_caught(cases: int) -> None:
    drop = Always().drop((cases, cases))
    assert drop**cases == pytest.approx(1.0 - CAUGHT)
    hits = np.random.default_rng(2).binomial(cases, drop, DRAWS)
    assert caught(Always(), [(int(one), cases) for one in hits]) == pytest.approx(CAUGHT, abs=CHANCE)


@pytest.mark.parametrize("at_least", [True, False])
@pytest.mark.parametrize("cases", [3, 5, 8, 30])
def test_a_planted_drop_of_a_mean_is_caught(cases: int, at_least: bool) -> None:
    """The drop that one run states, planted in another one."""
    test = Mean(0.9, at_least)
    draw = np.random.default_rng(3).normal(0.9, 0.1, (DRAWS, cases))
    errors = draw.std(axis=1, ddof=1) / math.sqrt(cases)
    off = np.random.default_rng(4).normal(0.0, 0.1, (DRAWS, cases)).mean(axis=1)
    drops = 0.9 + errors * (test.drop((0.9, 1.0, cases)) - 0.9)
    assert caught(test, [(mean, 0.1, cases) for mean in drops + off]) == pytest.approx(CAUGHT, abs=CHANCE)


@pytest.mark.parametrize("alike", [0.0, 0.1])
@pytest.mark.parametrize(("target", "cases"), [(0.95, 20), (0.99, 40), (0.95, 8)])
def test_a_planted_drop_of_what_cases_count_is_caught(target: float, cases: int, alike: float) -> None:
    test, each = Counted(target), 5
    share = test.drop((target, 0.0, cases, cases * each))
    for _ in range(5):  # the error that such cases truly have at the share that the drop is at
        error = math.sqrt(share * (1.0 - share) * (1.0 + (each - 1) * alike) / (cases * each))
        share = test.drop((target, error, cases, cases * each))
    runs = clusters(np.random.default_rng(5), (DRAWS, cases), each, share, alike)
    seen = [(hits.mean() / each, 0.0, cases, cases * each) for hits in runs]
    assert caught(test, seen) == pytest.approx(CAUGHT, abs=0.05), "shares are steps, and not normal"


def clusters(draw: np.random.Generator, shape: tuple[int, ...], each: int, share: float, alike: float) -> Array:
    """Hits of cases of a few drives each, which are alike: shares of cases differ as a beta distribution does."""
    if alike == 0.0:
        return draw.binomial(each, share, shape)
    spread = 1.0 / alike - 1.0
    return draw.binomial(each, draw.beta(share * spread, (1.0 - share) * spread, shape))


@pytest.mark.parametrize(("target", "hours"), [(1.0, 0.5), (1.0, 5.0), (0.1, 10.0)])
def test_a_planted_rate_of_events_is_caught(target: float, hours: float) -> None:
    test = Rate(target)
    drop = test.drop((0, hours))
    events = np.random.default_rng(6).poisson(drop * hours, DRAWS)
    assert caught(test, [(int(one), hours) for one in events]) == pytest.approx(CAUGHT, abs=CHANCE)
