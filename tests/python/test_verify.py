"""The arithmetic behind the rows of `./dev verify`, and the harness around them."""

from __future__ import annotations

import importlib
import itertools
import json
import math
import os
import re
import subprocess
from datetime import date
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml
from threewe.benchmark.statistics import beta_share, student_quantile, student_tail, wilson

from verify import fuzz
from verify.__main__ import AREAS, area, drawn
from verify.cases.localization import ROOT, Track, fit, imitation
from verify.cases.trajectories import trajectory_rows
from verify.harness import (
    Experiment,
    Row,
    Verdict,
    all_of,
    claims,
    counted_of,
    each,
    info,
    known_miss,
    mean_of,
    rate_of,
    ratio_of,
    share_of,
    share_within,
    time_of,
    where,
    whole_of,
    within,
    worst_of,
)
from verify.harness.area import Options, verify
from verify.harness.distributions import binomial_at_most, poisson_at_least
from verify.harness.journal import CaseJournal, Revision
from verify.harness.running import run_cases


def right(case: dict[str, Any]) -> bool:
    return bool(case["right"])


def value(case: dict[str, Any]) -> float:
    return float(case["value"])


def hits(right_ones: int, count: int) -> list[dict[str, Any]]:
    return [{"right": i < right_ones} for i in range(count)]


def values(*numbers: float) -> list[dict[str, Any]]:
    return [{"value": number} for number in numbers]


# distributions


def test_wilson_is_exact_at_its_ends() -> None:
    for count in range(1, 300):
        assert wilson(count, count)[1] == 1.0
        assert wilson(0, count)[0] == 0.0


def test_wilson_as_published() -> None:
    # Newcombe 1998, table I: 81 of 263
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)


@pytest.mark.parametrize(("t", "freedom", "tail"), [(12.706, 1, 0.025), (2.776, 4, 0.025), (3.169, 10, 0.005)])
def test_students_t_as_tabulated(t: float, freedom: int, tail: float) -> None:
    assert student_tail(t, freedom) == pytest.approx(tail, rel=1e-3)
    assert student_quantile({0.025: 1.95996, 0.005: 2.57583}[tail], freedom) == pytest.approx(t, rel=1e-3)


def test_tails_of_counts_are_their_sums() -> None:
    for count, share in [(10, 0.3), (64, 0.99), (200, 0.5)]:
        chances = [math.comb(count, k) * share**k * (1.0 - share) ** (count - k) for k in range(count + 1)]
        for k in (0, 1, count // 2, count - 2, count):
            assert binomial_at_most(k, count, share) == pytest.approx(sum(chances[: k + 1]), rel=1e-9)
    for k, mean in [(0, 2.0), (3, 1.0), (12, 7.5)]:
        few = sum(math.exp(-mean) * mean**i / math.factorial(i) for i in range(k))
        assert poisson_at_least(k, mean) == pytest.approx(1.0 - few, rel=1e-9)
    assert beta_share(2.0, 3.0, 0.4) == pytest.approx(0.5248)


# rows


def test_shares_pass_on_their_figure() -> None:
    row = share_of("most", right, at_least=0.95)
    assert row.judge(hits(39, 40)) == Verdict("39/40 = 97.5%", ">= 95.0%", "pass", "[87.1%, 99.6%]", "<= 87.2%")
    assert row.judge(hits(37, 40)).status == "FAIL"


def test_no_row_without_power_passes() -> None:
    verdicts = [
        share_of("most", right, at_least=0.95).judge(hits(3, 3)),
        all_of("all", right).judge(hits(1, 1)),
        mean_of("mean", value, at_least=0.9).judge(values(1.0, 1.0, 1.0)),
        mean_of("mean", value, at_least=0.9).judge(values(1.0)),
        mean_of("mean", value, at_least=1.0).judge(values(0.1, 1.0, 90.0)),
        time_of("time", value, at_most=20.0).judge(values(2.0, 90.0)),
    ]
    assert [(verdict.status, verdict.power) for verdict in verdicts] == [("info", "nothing")] * 6
    assert share_of("most", right, at_least=0.95).judge(hits(2, 3)).status == "FAIL"
    assert all_of("all", right).judge(hits(0, 1)).status == "FAIL"
    assert time_of("time", value, at_most=20.0).judge(values(20.0, 90.0)).status == "FAIL"


def test_what_cases_count_has_the_power_of_its_count_at_most() -> None:
    alike = [{"right": 50.0, "of": 50.0}] * 6
    row = counted_of("counted", lambda case: case["right"], lambda case: case["of"], at_least=0.98)
    assert row.judge(alike).power == "<= 96.4%"
    every = counted_of("counted", lambda case: case["right"], lambda case: case["of"], at_least=1.0)
    assert every.judge(alike) == Verdict("300/300", "all", "pass", "[98.7%, 100.0%]", "violations in 0.8% of cases")


def test_a_part_of_the_cases_fails_where_it_misses_by_more_than_chance() -> None:
    row = share_of("most", right, at_least=0.95)
    assert [row.judge(hits(n, 20), complete=False).status for n in (20, 18, 16)] == ["pass", "info", "FAIL"]
    assert all_of("all", right).judge(hits(19, 20), complete=False).status == "FAIL"
    assert mean_of("mean", value, at_most=1.0).judge(values(1.0, float("nan")), complete=False).status == "FAIL"


ROWS_OF_ALL_KINDS = [
    share_of("share", right, at_least=0.9),
    all_of("all", right),
    worst_of("worst", value, at_most=1.0),
    mean_of("mean", value, at_least=0.0),
    time_of("time", value, at_most=1.0),
    ratio_of("ratio", value, value, at_least=0.5),
    counted_of("counted", value, value, at_most=0.5),
    rate_of("rate", value, value, at_most=1.0),
    share_within("within", lambda case: [case], right, at_least=0.9),
    whole_of("whole", lambda cases: (f"{cases[0]['value']:g}", "", True)),
    info("info", lambda cases: f"{cases[0]['value']:g}"),
    within(info("parts", str), lambda case: case["parts"]),
    where(all_of("some", right), right),
    *each("scene", ["here"], lambda _: all_of("each", right)),
]


@pytest.mark.parametrize("row", ROWS_OF_ALL_KINDS, ids=lambda row: row.name)
@pytest.mark.parametrize("complete", [True, False])
def test_broken_cases_are_a_fail_and_never_a_crash(row: Row, complete: bool) -> None:
    for cases in ([{"error": "boom"}], [{"value": 1.0, "right": True}, {"error": "boom"}], [{}], [{"value": "x"}]):
        verdict = row.judge(cases, complete=complete)
        assert verdict.status == "FAIL", (row.name, cases, verdict)


def test_means_of_a_full_run_have_the_interval_that_repeated_draws_have() -> None:
    draw = np.random.default_rng(5)
    row = ratio_of("ratio", lambda case: case["ours"], lambda case: case["theirs"], at_least=0.9)

    def cases() -> list[dict[str, float]]:
        theirs = draw.uniform(0.6, 1.0, 200)
        ours = theirs * draw.uniform(0.8, 1.0, 200)
        return [{"ours": a, "theirs": b} for a, b in zip(ours, theirs, strict=True)]

    assert row.seen is not None
    assert row.test is not None
    runs = [cases() for _ in range(300)]
    seen = [row.seen(each) for each in runs]
    widths = [np.diff(row.test.limits(each))[0] for each in seen]
    ratios = [each[0] for each in seen]
    assert np.mean(widths) == pytest.approx(2 * 1.96 * np.std(ratios), rel=0.15)
    assert [row.judge(each).status == "pass" for each in runs] == [ratio >= 0.9 for ratio in ratios]


def test_a_known_miss_fails_where_it_is_worse_by_more_than_chance() -> None:
    row = known_miss(all_of("all", right), 0.95, "one in twenty")
    assert [row.judge(hits(n, 20)).status for n in (20, 19, 18, 17)] == ["pass", "known miss", "known miss", "FAIL"]
    slow = known_miss(time_of("time", value, at_most=20.0), 30.0, "it is slow")
    assert slow.judge(values(41.0, 42.0, 43.0)).status == "FAIL"
    assert slow.judge(values(25.0, 32.0, 33.0)).status == "known miss"
    assert slow.judge(values(25.0, 32.0, float("nan"))).status == "FAIL"


def test_whole_figures_are_judged_where_all_cases_have_been_run() -> None:
    row = whole_of("most", lambda cases: (str(len(cases)), ">= 2", len(cases) >= 2))
    assert [row.judge(values(1.0)).status, row.judge(values(1.0, 2.0)).status] == ["FAIL", "info"]
    assert row.judge(values(1.0), complete=False).status == "info"


def test_rows_of_parts_and_of_some_of_them() -> None:
    cases = [{"scene": s, "drives": [{"scene": s, "right": i != 1} for i in range(3)]} for s in ("here", "there")]
    row = within(all_of("all", right), lambda case: case["drives"])
    assert row.judge(cases).figure == "4/6"
    assert where(row, lambda drive: drive["scene"] == "here").judge(cases).figure == "2/3"
    assert where(row, lambda drive: drive["scene"] == "nowhere").judge(cases).status == "info"
    one, other = each("scene", ["here", "there"], lambda _: row)
    assert (one.name, other.judge(cases).figure) == ("all, here", "2/3")


# areas


@pytest.mark.parametrize("area", AREAS)
def test_experiments_and_rows_have_names_of_their_own(area: str) -> None:
    experiments = importlib.import_module(f"verify.{area}").EXPERIMENTS
    for names in ([one.name for one in experiments], *([row.name for row in one.rows] for one in experiments)):
        assert len(names) == len(set(names)), names


def dies(seed: int, how: str, value: int = 5) -> Any:
    if how == "raises":
        raise RuntimeError("boom")
    if how == "exits":
        os._exit(3)
    return {"well": {"seed": seed, "value": 1.0}, "no case": value, "not to be sent": {"value": lambda: 0}}[how]


def test_cases_that_raise_die_or_come_to_nothing_are_broken(tmp_path: Path) -> None:
    ways = ["well", "raises", "exits", "no case", "not to be sent", "well"]
    experiment = Experiment("deaths", dies, {"value": 5}, variants=[{"how": how} for how in ways], limit=60.0)
    journal = CaseJournal(tmp_path / "journal.jsonl")
    cases = run_cases(experiment, 1, len(ways), journal).all
    assert ["error" in case for case in cases] == [how != "well" for how in ways]
    assert (cases[0]["how"], cases[0]["value"]) == ("well", 1.0), "its arguments stay beside what it came to"
    again = CaseJournal(tmp_path / "journal.jsonl")
    assert len(again) == 2, "those that broke are run again"


@pytest.fixture
def results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where runs of this test leave their journals and results; the meanings of their misses are there too."""
    monkeypatch.setattr("verify.harness.area.ROOT", tmp_path)
    monkeypatch.setattr("verify.harness.claims.RESULTS", tmp_path)
    monkeypatch.setattr(Revision, "here", staticmethod(lambda: Revision("abc", 7)))
    (tmp_path / "meanings.yaml").write_text(
        '- topic: Drive\n  misses:\n  - {rows: ["toy: one: some"], means: Give it a map.}\n'
    )
    return tmp_path


WELL = all_of("all", lambda case: case["value"] == 1.0)
NEVER = Experiment("never", dies, {"how": "well"}, cases=2, rows=[WELL])


def page_of(results: Path, *experiments: Experiment) -> str:
    return claims.page({"toy": claims.Area("A toy.", list(experiments))}, results, results / "meanings.yaml")


def test_full_runs_are_written_into_the_claims(results: Path) -> None:
    one, two = (Experiment(name, dies, {"how": "well"}, cases=4, rows=[WELL]) for name in ("one", "two"))
    assert dict(verify([("toy", one)], Options(write=True))) == {"pass": 1}
    verify([("toy", two)], Options(write=True, seed=8))
    runs = json.loads((results / "toy.json").read_text())
    assert {name: (run["commit"], run["seed"], run["cases"]) for name, run in runs.items()} == {
        "one": ("abc", 7, 4),
        "two": ("abc", 8, 4),
    }, "experiments are written by themselves, so that a long area may be run in pieces"
    page = page_of(results, one, two, NEVER)
    assert "| [toy](#toy) | 2 | 0 | 0 | 0 | 0 | 1 | 0 | 2 of 3 experiments |" in page
    assert "**one**: 4 cases, commit abc, seed 7, on " in page
    assert "**never**: no full run on file" in page
    assert "| pass | all | 4/4 | all | [51.0%, 100.0%] | violations in 43.8% of cases |" in page


def test_claims_that_changed_since_their_run_are_shown_as_outdated(results: Path) -> None:
    before = Experiment("one", dies, {"how": "well"}, cases=4, rows=[share_of("some", right_value, at_least=0.9), WELL])
    verify([("toy", before)], Options(write=True))
    page = page_of(results, Experiment("one", dies, rows=[share_of("some", right_value, at_least=0.95)]), NEVER)
    assert "| **not run** | some |  | >= 95.0% |  |  |" in page
    assert "| **outdated** | some | 4/4 = 100.0% | >= 90.0% | [51.0%, 100.0%] | <= 56.2% |" in page
    assert "| **outdated** | all | 4/4 | all |" in page
    assert "| **outdated** | all | 4/4 | all |" in page_of(results, NEVER), "nor has the code the experiment any more"


def right_value(case: dict[str, Any]) -> bool:
    return bool(case["value"] == 1.0)


def test_the_page_says_what_misses_mean_and_which_of_them_have_excuses(results: Path) -> None:
    row = share_of("some", lambda case: case["value"] == 2.0, at_least=0.5)
    other = share_of("others", lambda case: case["value"] == 3.0, at_least=0.5)
    verify([("toy", Experiment("one", dies, {"how": "well"}, cases=4, rows=[row, other]))], Options(write=True))
    page = page_of(results, Experiment("one", dies, rows=[known_miss(row, 0.4, "it is so"), other]))
    assert "### Drive\n\n- Give it a map. (known miss, [toy](#toy))\n" in page
    assert "### Not explained yet\n\n- toy: one: others (FAIL)\n" in page
    assert "| **known miss** | some | 0/4 = 0.0% (it is so) |" in page
    worse = page_of(results, Experiment("one", dies, rows=[known_miss(row, 0.495, "it is so")]))
    assert "- Give it a map. (**FAIL**, [toy](#toy))\n" in worse, "its bar is not in the interval, [0.0%, 49.0%]"


def test_nothing_is_learned_from_an_experiment_with_a_broken_case(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("verify.harness.area.ROOT", tmp_path)
    learned: list[int] = []
    for ways in (["well", "well"], ["well", "raises"]):
        experiment = Experiment(
            "_".join(ways),
            dies,
            variants=[{"how": how} for how in ways],
            cases=2,
            rows=[all_of("all", right)],
            learn=lambda cases, *_: learned.append(len(cases)),
        )
        verify([("toy", experiment)], Options(write_model=True))
    assert learned == [2]


def test_out_of_time_no_case_begins_and_what_has_finished_is_judged(
    results: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    calls = itertools.count()
    monkeypatch.setattr("verify.harness.journal.time", SimpleNamespace(monotonic=lambda: next(calls)))
    one = Experiment("one", dies, {"how": "well"}, cases=8, rows=[WELL], alone=True)
    assert dict(verify([("toy", one), ("toy", NEVER)], Options(write=True, deadline=5))) == {"pass": 1, "not shown": 1}
    printed = capsys.readouterr().out
    assert "toy, one: 5 of 8 cases, " in printed
    assert "out of time: 1 experiments were not begun" in printed
    assert not (results / "toy.json").exists(), "an unfinished run is not published"
    assert len(CaseJournal(results / "build/verify/toy-abc-7.jsonl")) == 5
    assert dict(verify([("toy", one)], Options(write=True))) == {"pass": 1}
    assert "toy, one: 8 cases, " in capsys.readouterr().out
    assert (results / "toy.json").exists()


def test_drawn_runs_have_every_experiment_that_a_night_is_enough_for_in_another_order_each_day() -> None:
    every = [(name, one) for name in AREAS for one in area(name).experiments]
    seeds = [Revision("abc", 7).seed_of(date(2026, 11, day)) for day in (26, 27)]
    today, tomorrow = ([f"{name}: {one.name}" for name, one in drawn(every, seed)] for seed in seeds)
    assert today != tomorrow
    assert sorted(today) == sorted(tomorrow) == sorted(f"{name}: {one.name}" for name, one in every if one.by_night)
    assert 0 < len(today) < len(every)
    assert today == [f"{name}: {one.name}" for name, one in drawn(every, seeds[0])]


def test_fuzzing_that_ends_early_is_no_success(monkeypatch: pytest.MonkeyPatch) -> None:
    printed = "relations            60 inputs       2 s  ok\n"
    done = subprocess.CompletedProcess([], 0, printed, "")
    monkeypatch.setattr(fuzz.subprocess, "run", lambda *_, **__: done)
    assert fuzz.read_inputs(1, "relations", 60)["ok"]
    assert not fuzz.read_inputs(1, "relations", 61)["ok"]
    done.stdout = ""
    assert not fuzz.read_inputs(1, "relations", 1)["ok"]


# what is on file


def shown() -> dict[str, dict[str, list[claims.Shown]]]:
    return {name: claims.rows_of(area(name), claims.runs_of(name)) for name in AREAS}


def test_excuses_are_of_misses_on_file_and_their_bars_are_in_the_intervals() -> None:
    rows = shown()
    for name in AREAS:
        for experiment in area(name).experiments:
            on_page = {row["row"]: row["status"] for row in rows[name][experiment.name]}
            excused = [row for row in experiment.rows if row.known_miss]
            wrong = [row.name for row in excused if on_page[row.name] != "known miss"]
            assert not wrong, f"{name}, {experiment.name}: met on file, or bar outside of its interval"
            assert all(row.known_miss.bar > 0.0 for row in excused), "one that nothing can be worse than"


def test_every_miss_on_file_has_one_meaning_and_no_meaning_is_left_over() -> None:
    missed = claims.misses(shown())
    topics = yaml.safe_load(claims.MEANINGS.read_text())
    meanings = [beginning for topic in topics for one in topic["misses"] for beginning in one["rows"]]
    for key in missed:
        assert sum(map(key.startswith, meanings)) == 1, key
    assert not [one for one in meanings if not any(key.startswith(one) for key in missed)]


def test_the_page_of_claims_is_that_of_the_results_on_file() -> None:
    assert claims.PAGE.read_text() == claims.page({name: area(name) for name in AREAS}), "python -m verify claims"


# the model of localization errors


def test_the_fit_finds_the_model_that_made_the_errors() -> None:
    draw = np.random.default_rng(3)
    tracks = []
    for seed in range(100):
        # to goals in a hall, at 0.4 m/s
        corners = np.cumsum(draw.uniform(-6.0, 6.0, (6, 2)), axis=0) * 0.7
        legs = np.diff(np.vstack([[0.0, 0.0], corners]), axis=0)
        steps = [np.tile(leg / (n := round(np.linalg.norm(leg) / 0.04) + 1), (n, 1)) for leg in legs]
        place = np.cumsum(np.vstack(steps), axis=0)
        lines = np.zeros((len(place), 9))
        lines[:, 0] = 0.1 * np.arange(len(place))
        lines[:, 3:5] = lines[:, 6:8] = place
        known = Track({"scene": "hall", "seed": seed, "held_out": False, "track": lines})
        tracks.append(imitation("slam_v2", known))
    found = fit(tracks)
    text = (ROOT / "assets/localization/slam_v2.yaml").read_text()
    maps, local, scatter = (re.search(rf"{part}: {{.*}}", text)[0] for part in ("map", "local", "noise"))
    expected = [figure(maps, "turn"), figure(maps, "stretch"), figure(maps, "heading"), figure(local, "position")]
    expected += [figure(scatter, "position"), figure(scatter, "heading")]
    # lengths and deviations of what is slow make up for one another; what they come to is well known
    growth = np.sqrt(figure(maps, "length") / found["map_length"])
    assert found["deviations"][:3] * growth == pytest.approx(expected[:3], rel=0.35)
    assert found["deviations"][4:] == pytest.approx(expected[4:], rel=0.1)


def figure(part: str, name: str) -> float:
    return float(re.search(rf"{name}: ([\d.e-]+)", part)[1])


@pytest.mark.parametrize(
    ("scene", "randomization", "rmse", "status"),
    [
        ("office_v2", "none", 0.049, "info"),
        ("office_v2", "none", 0.051, "FAIL"),
        ("office_v2", "hard", 0.079, "info"),
        ("corridor_v1", "none", 0.99, "info"),
        ("corridor_v1", "none", 1.01, "FAIL"),
    ],
)
def test_how_far_off_a_drive_may_be(scene: str, randomization: str, rmse: float, status: str) -> None:
    case = {"scene": scene, "randomization": randomization, "rmse": rmse, "driven": 200.0}
    assert trajectory_rows()[0].judge([case] * 3).status == status, "three that are alike show no error, and no power"
