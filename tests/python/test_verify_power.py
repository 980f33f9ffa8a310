"""The harness of `./dev verify` against itself, in 10,000 simulated draws.

Planted drops are caught as often as stated; targets that are just met are not refused.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from verify.harness import Row, all_of, mean_of, rate_of, ratio_of, share_of, time_of
from verify.harness.rows import mean_and_error, ratio_and_error
from verify.harness.sequential import (
    ALARM,
    ALPHA,
    CAUGHT,
    FALSE_ALARMS,
    ROWS,
    RUNS,
    Always,
    Counted,
    Mean,
    Rate,
    Seen,
    Share,
    Test,
    log_odds,
)

DRAWS = 10_000
CHANCE = 3.0 * math.sqrt(CAUGHT * (1.0 - CAUGHT) / DRAWS)  # that much a share of so many draws is off
Draw = np.random.Generator


def caught(test: Test, drop: float, runs: list[list[Seen]]) -> float:
    """The share of draws in which one of the runs gives the alarm, each knowing those before it."""
    return float(np.mean([any(alarm(test, drop, draw, k) for k in range(len(draw))) for draw in runs]))


def alarm(test: Test, drop: float, runs: list[Seen], k: int) -> bool:
    return log_odds(test, drop, runs[:k], runs[k]) >= ALARM


def runs_of(draws: Draw, see: object, count: int = DRAWS) -> list[list[Seen]]:
    return [[see(draws) for _ in range(RUNS)] for _ in range(count)]


@pytest.mark.parametrize(
    ("target", "cases"), [(0.99, 64), (0.99, 8), (0.97, 40), (0.95, 24), (0.9, 12), (0.55, 16), (0.995, 200), (0.5, 30)]
)
def test_a_planted_drop_of_a_share_is_caught(target: float, cases: int) -> None:
    test = Share(target)
    drop = test.drop((cases, cases), RUNS)
    assert drop < target
    found = caught(test, drop, runs_of(np.random.default_rng(1), lambda d: (d.binomial(cases, drop), cases)))
    assert found >= CAUGHT - CHANCE
    assert found <= 0.97, "the stated power is not much less than the true one"


@pytest.mark.parametrize("cases", [1, 4, 30, 200])
def test_a_planted_rate_of_violations_is_caught(cases: int) -> None:
    test = Always()
    drop = test.drop((0, cases), RUNS)
    found = caught(test, drop, runs_of(np.random.default_rng(2), lambda d: (d.binomial(cases, 1.0 - drop), cases)))
    assert found == pytest.approx(CAUGHT, abs=CHANCE)


@pytest.mark.parametrize("at_least", [True, False])
@pytest.mark.parametrize("cases", [3, 5, 8, 30])
def test_a_planted_drop_of_a_mean_is_caught(cases: int, at_least: bool) -> None:
    test = Mean(0.9, at_least)
    drop = test.drop((0.9, 0.1 / math.sqrt(cases), cases), RUNS)
    see = lambda d: mean_and_error(list(d.normal(drop, 0.1, cases)))  # noqa: E731
    found = caught(test, drop, runs_of(np.random.default_rng(3), see, 2_000 if cases == 30 else DRAWS))
    assert found >= CAUGHT - 3.0 * CHANCE * (cases == 30) - CHANCE


def cluster(draw: Draw, cases: int, each: int, share: float, alike: float) -> Seen:
    """Cases of a few drives each, which are alike: shares of cases differ as a beta distribution does."""
    if alike > 0.0:
        shares = draw.beta(share * (1.0 / alike - 1.0), (1.0 - share) * (1.0 / alike - 1.0), cases)
    else:
        shares = np.full(cases, share)
    pairs = [(float(hits), float(each)) for hits in draw.binomial(each, shares)]
    return *ratio_and_error(pairs), float(cases), float(cases * each)


@pytest.mark.parametrize("alike", [0.0, 0.1])
@pytest.mark.parametrize(("target", "cases"), [(0.95, 20), (0.99, 40), (0.95, 8)])
def test_a_planted_drop_of_what_cases_count_is_caught(target: float, cases: int, alike: float) -> None:
    test, each = Counted(target, at_least=True), 5
    draw = np.random.default_rng(9)
    share = test.drop((target, 0.0, cases, cases * each), RUNS)
    for _ in range(5):  # the error that such cases truly have at the share that the drop is at
        error = math.sqrt(share * (1.0 - share) * (1.0 + (each - 1) * alike) / (cases * each))
        share = test.drop((target, error, cases, cases * each), RUNS)
    runs = runs_of(draw, lambda d: cluster(d, cases, each, share, alike), 2_000)
    assert caught(test, share, runs) >= CAUGHT - 3.0 * CHANCE


@pytest.mark.parametrize("alike", [0.0, 0.3])
def test_targets_that_cases_which_are_alike_just_meet_are_refused_as_seldom(alike: float) -> None:
    draw, alarms = np.random.default_rng(10), 0
    for target, cases in [(0.95, 20), (0.99, 40), (0.9, 12)]:
        test = Counted(target, at_least=True)
        alarms += sum(log_odds(test, 0.0, [], cluster(draw, cases, 5, target, alike)) >= ALARM for _ in range(DRAWS))
    assert alarms <= 3.0 * DRAWS * ALPHA + 4.0


@pytest.mark.parametrize(("target", "hours"), [(1.0, 0.5), (1.0, 5.0), (0.1, 10.0)])
def test_a_planted_rate_of_events_is_caught(target: float, hours: float) -> None:
    test = Rate(target)
    drop = test.drop((0, hours), RUNS)
    found = caught(test, drop, runs_of(np.random.default_rng(4), lambda d: (d.poisson(drop * hours), hours)))
    assert CAUGHT - CHANCE <= found <= 0.99


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


def test_a_whole_run_of_ci_refuses_targets_that_are_just_met_at_most_once_in_a_hundred() -> None:
    """As many rows as a run may have, over 20 runs with their record, 500 times: 10,000 whole runs."""
    random = np.random.default_rng(6)
    worlds, length = 500, 20
    shares = [(target, cases) for target in (0.99, 0.97, 0.95, 0.9, 0.55) for cases in (8, 12, 24, 64, 200)]
    means = [3, 5, 8, 12, 30]
    rates = [0.5, 2.0, 10.0]
    alarms = np.zeros((length, worlds), bool)
    for number in range(ROWS):
        kind = number % 3
        if kind == 0:
            target, cases = shares[number // 3 % len(shares)]
            test = Share(target)
            drop = test.drop((cases, cases), RUNS)
            odds = test.log_odds((random.binomial(cases, target, (length, worlds)), cases), drop)
        elif kind == 1:
            cases = means[number // 3 % len(means)]
            odds = odds_of_means(random.normal(0.0, 1.0, (length, worlds, cases)))
        else:
            hours = rates[number // 3 % len(rates)]
            test = Rate(1.0)
            odds = test.log_odds((random.poisson(hours, (length, worlds)), hours), test.drop((0, hours), RUNS))
        alarms |= alarms_of(odds)
    assert alarms.mean() <= FALSE_ALARMS


def test_means_of_skewed_values_are_refused_as_seldom() -> None:
    """Shares, lengths and times: the long tail lies on the side of the drop."""
    random = np.random.default_rng(7)
    for cases in (5, 12, 40):
        draws = random.beta(20.0, 1.0, (ROWS, 2_000, cases)) - 20.0 / 21.0
        assert alarms_of(odds_of_means(draws)).any(axis=0).mean() <= FALSE_ALARMS + 0.005


def odds_of_means(values: np.ndarray) -> np.ndarray:
    """Of values whose target, at least 0, is just met; by interpolation between exact ones."""
    cases = values.shape[-1]
    test = Mean(0.0, at_least=True)
    grid = np.sinh(np.linspace(-12.0, 12.0, 4_001))
    exact = np.array([test.log_odds((-t, 1.0, cases), -1.0) for t in grid])
    t = -values.mean(axis=-1) / (values.std(axis=-1, ddof=1) / math.sqrt(cases))
    return np.interp(t, grid, exact)


def alarms_of(odds: np.ndarray) -> np.ndarray:
    """Which runs give the alarm, in each world one after the other: what `alarm` does, of many at once."""
    found, before = np.zeros(odds.shape, bool), np.zeros(odds.shape[1])
    for k, now in enumerate(odds):
        found[k] = before + now >= ALARM
        before = np.where(found[k], 0.0, np.maximum(before + now, 0.0))
    return found


def test_many_at_once_are_as_one_after_the_other() -> None:
    random = np.random.default_rng(8)
    test, cases = Share(0.9), 20
    drop = test.drop((cases, cases), RUNS)
    hits = random.binomial(cases, 0.75, (30, 50))
    fast = alarms_of(test.log_odds((hits, cases), drop))
    for world in range(50):
        runs = [(float(h), float(cases)) for h in hits[:, world]]
        assert [alarm(test, drop, runs, k) for k in range(30)] == list(fast[:, world])
