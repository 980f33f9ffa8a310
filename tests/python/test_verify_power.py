"""The harness of `./dev verify` against itself, in 10,000 simulated draws.

Planted drops are caught as often as stated; targets that are just met are not refused.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

from verify.harness import Row, all_of, mean_of, rate_of, ratio_of, share_of, time_of
from verify.harness.counts import Always, Rate, Share
from verify.harness.kinds import ratio_and_error
from verify.harness.means import Counted, Mean
from verify.harness.sequential import (
    ALARM,
    ALPHA,
    CAUGHT,
    FALSE_ALARMS,
    ROWS,
    RUNS,
    Seen,
    log_odds,
)

DRAWS = 10_000
CHANCE = 3.0 * math.sqrt(CAUGHT * (1.0 - CAUGHT) / DRAWS)  # that much a share of so many draws is off
Array = np.ndarray


def caught(odds: Array) -> float:
    """The share of draws, of which each has the log odds of some runs, in which one of them gives the alarm."""
    return float(alarms_of(odds.T).any(axis=0).mean())


def alarms_of(odds: Array) -> Array:
    """Which runs give the alarm, in each draw one after the other: what `log_odds` does, of many at once."""
    found, before = np.zeros(odds.shape, bool), np.zeros(odds.shape[1])
    for k, now in enumerate(odds):
        found[k] = before + now >= ALARM
        before = np.where(found[k], 0.0, np.maximum(before + now, 0.0))
    return found


def odds_of_means(values: Array) -> Array:
    """The log odds of runs whose cases, the last axis, are to have a mean of 0 at least."""
    cases = values.shape[-1]
    return odds_of_scores(-values.mean(axis=-1) / (values.std(axis=-1, ddof=1) / math.sqrt(cases)), cases)


def odds_of_counts(hits: Array, each: int, target: float) -> Array:
    """The same of runs whose cases, the last axis, count so many of `each`."""
    cases = hits.shape[-1]
    share = hits.mean(axis=-1) / each
    error = hits.std(axis=-1, ddof=1) / each / math.sqrt(cases)
    floor = math.sqrt(target * (1.0 - target) / (cases * each))
    return odds_of_scores((target - share) / np.maximum(error, floor), cases)


def odds_of_scores(t: Array, cases: int) -> Array:
    """By interpolation between exact ones."""
    return np.interp(t, *table_of(cases))


@functools.cache
def table_of(cases: int) -> tuple[Array, Array]:
    grid = np.sinh(np.linspace(-12.0, 12.0, 4_001))
    test = Mean(0.0, at_least=True)
    return grid, np.array([test.log_odds((-t, 1.0, cases), -1.0) for t in grid])


def test_many_at_once_are_as_one_after_the_other() -> None:
    draw = np.random.default_rng(8)
    share, cases = Share(0.9), 20
    drop = share.drop((cases, cases), RUNS)
    hits = draw.binomial(cases, 0.75, (50, 30))
    fast = alarms_of(share.log_odds((hits, cases), drop).T)
    for world in range(50):
        runs = [(float(h), float(cases)) for h in hits[world]]
        slow = [log_odds(share, drop, runs[:k], runs[k]) >= ALARM for k in range(30)]
        assert slow == list(fast[:, world])
    counted = Counted(0.9, at_least=True)
    for hits in draw.binomial(5, 0.7, (50, 12)):
        seen: Seen = (*ratio_and_error([(float(h), 5.0) for h in hits]), 12.0, 60.0)
        assert counted.log_odds(seen, 0.0) == pytest.approx(float(odds_of_counts(hits, 5, 0.9)), abs=1e-3)


# what is caught


@pytest.mark.parametrize(
    ("target", "cases"), [(0.99, 64), (0.99, 8), (0.97, 40), (0.95, 24), (0.9, 12), (0.55, 16), (0.995, 200), (0.5, 30)]
)
def test_a_planted_drop_of_a_share_is_caught(target: float, cases: int) -> None:
    test = Share(target)
    drop = test.drop((cases, cases), RUNS)
    hits = np.random.default_rng(1).binomial(cases, drop, (DRAWS, RUNS))
    found = caught(test.log_odds((hits, cases), drop))
    assert drop < target
    assert CAUGHT - CHANCE <= found <= 0.97, "the stated power is not much less than the true one"


@pytest.mark.parametrize("cases", [1, 4, 30, 200])
def test_a_planted_rate_of_violations_is_caught(cases: int) -> None:
    test = Always()
    drop = test.drop((cases, cases), RUNS)
    hits = np.random.default_rng(2).binomial(cases, 1.0 - drop, (DRAWS, RUNS))
    odds = np.array([test.log_odds((h, cases), drop) for h in range(cases + 1)])
    assert caught(odds[hits]) == pytest.approx(CAUGHT, abs=CHANCE)


@pytest.mark.parametrize("at_least", [True, False])
@pytest.mark.parametrize("cases", [3, 5, 8, 30])
def test_a_planted_drop_of_a_mean_is_caught(cases: int, at_least: bool) -> None:
    drop = Mean(0.9, at_least).drop((0.9, 0.1 / math.sqrt(cases), cases), RUNS)
    off = np.random.default_rng(3).normal(drop, 0.1, (DRAWS, RUNS, cases)) - 0.9
    assert caught(odds_of_means(off if at_least else -off)) >= CAUGHT - CHANCE


@pytest.mark.parametrize("alike", [0.0, 0.1])
@pytest.mark.parametrize(("target", "cases"), [(0.95, 20), (0.99, 40), (0.95, 8)])
def test_a_planted_drop_of_what_cases_count_is_caught(target: float, cases: int, alike: float) -> None:
    test, each = Counted(target, at_least=True), 5
    share = test.drop((target, 0.0, cases, cases * each), RUNS)
    for _ in range(5):  # the error that such cases truly have at the share that the drop is at
        error = math.sqrt(share * (1.0 - share) * (1.0 + (each - 1) * alike) / (cases * each))
        share = test.drop((target, error, cases, cases * each), RUNS)
    hits = clusters(np.random.default_rng(9), (DRAWS, RUNS, cases), each, share, alike)
    assert caught(odds_of_counts(hits, each, target)) >= CAUGHT - CHANCE


def clusters(draw: np.random.Generator, shape: tuple[int, ...], each: int, share: float, alike: float) -> Array:
    """Hits of cases of a few drives each, which are alike: shares of cases differ as a beta distribution does."""
    if alike == 0.0:
        return draw.binomial(each, share, shape)
    spread = 1.0 / alike - 1.0
    return draw.binomial(each, draw.beta(share * spread, (1.0 - share) * spread, shape))


@pytest.mark.parametrize(("target", "hours"), [(1.0, 0.5), (1.0, 5.0), (0.1, 10.0)])
def test_a_planted_rate_of_events_is_caught(target: float, hours: float) -> None:
    test = Rate(target)
    drop = test.drop((0, hours), RUNS)
    events = np.random.default_rng(4).poisson(drop * hours, (DRAWS, RUNS))
    assert CAUGHT - CHANCE <= caught(test.log_odds((events, hours), drop)) <= 0.99


def rows_with_draws() -> list[tuple[Row, object, object]]:
    """A row of each kind; cases of a run in which its target is just met; and such a run with much of a drop."""
    value = lambda case: case["value"]  # noqa: E731
    one = lambda case: 1.0  # noqa: E731, ARG005

    def of(draw: object) -> object:
        return lambda d: [{"value": float(v)} for v in draw(d)]

    return [
        (share_of("share", lambda c: c["value"] < 0.97, at_least=0.97), of(lambda d: d.random(40)), 1.15),
        (all_of("always", lambda c: c["value"] < 1.0), of(lambda d: d.random(40)), 1.15),
        (mean_of("mean", value, at_most=0.5), of(lambda d: d.random(20)), 2.0),
        (time_of("time", value, at_most=1.0), of(lambda d: np.exp(d.normal(0.0, 0.2, 5))), 3.0),
        (ratio_of("ratio", value, one, at_most=0.5), of(lambda d: d.random(20)), 2.0),
        (rate_of("rate", value, one, at_most=0.5), of(lambda d: d.poisson(0.5, 10)), 6.0),
    ]


@pytest.mark.parametrize(("row", "draw", "factor"), rows_with_draws(), ids=lambda row: getattr(row, "name", ""))
def test_rows_of_each_kind_catch_a_large_drop_in_five_runs(row: Row, draw: object, factor: float) -> None:
    random = np.random.default_rng(5)
    failed, refused = 0, 0
    for _ in range(100):
        earlier: list[Seen] = []
        for _ in range(RUNS):
            worse = [{"value": factor * case["value"]} for case in draw(random)]
            verdict = row.judge(worse, sample=True, earlier=earlier)
            earlier.append(verdict.seen)
            if verdict.status == "FAIL":
                failed += 1
                break
        refused += row.judge(draw(random), sample=True).status == "FAIL"
    assert failed >= 90
    assert refused <= 1


# what is refused


def test_a_whole_run_of_ci_refuses_targets_that_are_just_met_at_most_once_in_a_hundred() -> None:
    """As many rows as a run may have, over 20 runs with their record, 500 times: 10,000 whole runs."""
    draw = np.random.default_rng(6)
    shape = length, worlds = 20, 500
    assert length * worlds == DRAWS
    shares = [(target, cases) for target in (0.99, 0.97, 0.95, 0.9, 0.55) for cases in (8, 12, 24, 64, 200)]
    alarms = np.zeros(shape, bool)
    for number in range(ROWS):
        target, cases = shares[number // 4 % len(shares)]
        if number % 4 == 0:
            share = Share(target)
            odds = share.log_odds((draw.binomial(cases, target, shape), cases), share.drop((cases, cases), RUNS))
        elif number % 4 == 1:
            odds = odds_of_means(draw.normal(0.0, 1.0, (*shape, min(cases, 30))))
        elif number % 4 == 2:
            odds = odds_of_counts(clusters(draw, (*shape, min(cases, 30)), 5, target, 0.1), 5, target)
        else:
            hours = 0.05 * cases
            odds = Rate(1.0).log_odds((draw.poisson(hours, shape), hours), Rate(1.0).drop((0, hours), RUNS))
        alarms |= alarms_of(odds)
    assert alarms.mean() <= FALSE_ALARMS


@pytest.mark.parametrize("cases", [5, 12, 40])
def test_means_of_skewed_values_are_refused_as_seldom(cases: int) -> None:
    """Shares, lengths and times: the long tail lies on the side of the drop."""
    draws = np.random.default_rng(7).beta(20.0, 1.0, (ROWS, DRAWS // 4, cases)) - 20.0 / 21.0
    assert alarms_of(odds_of_means(draws)).any(axis=0).mean() <= FALSE_ALARMS + 0.005


@pytest.mark.parametrize("alike", [0.0, 0.3])
@pytest.mark.parametrize(("target", "cases"), [(0.95, 20), (0.99, 40), (0.9, 12)])
def test_targets_that_cases_which_are_alike_just_meet_are_refused_as_seldom(
    target: float, cases: int, alike: float
) -> None:
    hits = clusters(np.random.default_rng(10), (10 * DRAWS, cases), 5, target, alike)
    alarms = int((odds_of_counts(hits, 5, target) >= ALARM).sum())
    assert alarms <= 10 * DRAWS * ALPHA + 3.0 * math.sqrt(10 * DRAWS * ALPHA)
