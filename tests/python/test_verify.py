"""The arithmetic behind the rows of `./dev verify`, and the harness around them."""

from __future__ import annotations

import importlib
import json
import math
import os
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threewe.benchmark.statistics import beta_share, student_quantile, student_tail, wilson

from verify import fuzz
from verify.__main__ import AREAS, area
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
from verify.harness.counts import Always
from verify.harness.distributions import binomial_at_most, normal_score, poisson_at_least
from verify.harness.journal import Revision, open_journal
from verify.harness.record import Record
from verify.harness.running import run_cases
from verify.harness.sequential import ROWS


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
    assert normal_score(t, freedom) == pytest.approx({0.025: 1.95996, 0.005: 2.57583}[tail], rel=1e-3)
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


def test_shares_in_full_runs_pass_on_their_figure() -> None:
    row = share_of("most", right, at_least=0.95)
    assert row.judge(hits(39, 40)) == Verdict(
        "39/40 = 97.5%", ">= 95.0%", "pass", "[87.1%, 99.6%]", "<= 64.1% in 1 such run", (39.0, 40.0)
    )
    assert row.judge(hits(37, 40)).status == "FAIL"


def test_no_row_without_power_passes() -> None:
    assert share_of("most", right, at_least=0.95).judge(hits(4, 4)).status == "info"
    assert all_of("all", right).judge(hits(1, 1)).status == "info"
    assert mean_of("mean", value, at_least=0.9).judge(values(1.0, 1.0, 1.0)).status == "info"
    wild = mean_of("mean", value, at_least=1.0).judge(values(0.1, 1.0, 90.0))
    assert (wild.status, wild.power[:4]) == ("info", "<= -")
    assert share_of("most", right, at_least=0.95).judge(hits(3, 4)).status == "FAIL"
    assert all_of("all", right).judge(hits(0, 1)).status == "FAIL"


def test_no_row_without_power_passes_on_the_page() -> None:
    def on_file(row: Row, power: str, status: str = "pass") -> str:
        experiment = Experiment("one", dies, rows=[row])
        target = row.test.wanted() if row.test else ""
        return claims.status_of({"row": row.name, "status": status, "target": target, "power": power}, experiment)

    share = share_of("most", right, at_least=0.95)
    powers = ["<= 48.2% in 1 such run", "<= 40.0% in 1 such run", "nothing", ""]
    assert [on_file(share, power) for power in powers] == ["pass", "info", "info", "info"]
    assert on_file(share, "nothing", "FAIL") == "FAIL"
    assert on_file(all_of("all", right), "violations in 53.6% of cases in 1 such run") == "info"
    assert on_file(mean_of("mean", value, at_least=0.9), "<= -41.1 in 1 such run") == "info"
    assert on_file(mean_of("mean", value, at_most=0.1), ">= 1.5e-01 in 1 such run") == "pass"
    assert on_file(time_of("time", value, at_most=20.0), ">= 30 in 1 such run") == "pass"
    assert on_file(time_of("time", value, at_most=20.0), ">= 60 in 1 such run") == "info"
    assert on_file(whole_of("whole", lambda _: ("", "", True)), "") == "info"


def test_no_sample_passes_with_nothing_or_with_half() -> None:
    for enough in (0.99, 0.97, 0.95):
        row = share_of("most", right, at_least=enough)
        for count in range(1, 80):
            assert row.judge(hits(0, count), sample=True).status in ("FAIL", "info")
            half = row.judge(hits(count // 2, count), sample=True)
            assert half.status == "FAIL" or (half.status == "info" and count < 24)
    assert share_of("most", right, at_least=0.99).judge(hits(0, 8), sample=True).status == "FAIL"
    assert share_of("most", right, at_least=0.99).judge(hits(0, 2), sample=True).status != "pass"


def test_a_row_that_could_not_notice_half_is_info_and_may_fail_all_the_same() -> None:
    row = share_of("most", right, at_least=0.55)
    assert row.judge(hits(4, 4), sample=True).status == "info"
    assert row.judge(hits(4, 4), sample=True).power.endswith(": too little to judge by")
    assert row.judge(hits(30, 30), sample=True).status == "pass"
    assert row.judge(hits(0, 30), sample=True).status == "FAIL"
    assert all_of("all", right).judge(hits(0, 1), sample=True).status == "FAIL"


def test_a_small_drop_is_caught_by_the_record_alone() -> None:
    row = share_of("most", right, at_least=0.97)
    now = row.judge(hits(35, 40), sample=True)
    assert (now.status, now.power) == ("info", "<= 86.7% in 5 such runs: undecided")
    statuses = [row.judge(hits(35, 40), sample=True, earlier=[now.seen] * k).status for k in range(5)]
    assert "FAIL" in statuses
    assert statuses[: statuses.index("FAIL")].count("info") == statuses.index("FAIL") >= 1
    assert row.judge(hits(35, 40), sample=True, earlier=[(40.0, 40.0)] * 4).status == "info"
    assert row.judge(hits(39, 40), sample=True, earlier=[(40.0, 40.0)] * 4).status == "pass"
    assert row.judge(hits(39, 40), sample=True, earlier=[now.seen]).status == "info"


def test_one_violation_fails_a_claim_about_all() -> None:
    row = all_of("all", right)
    assert row.judge(hits(9, 10), sample=True).status == "FAIL"
    assert row.judge(hits(10, 10), sample=True).status == "pass"
    assert row.judge(hits(10, 10), sample=True, earlier=[(9.0, 10.0)]).status == "pass", "that run had its own FAIL"


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
@pytest.mark.parametrize("sample", [True, False])
def test_broken_cases_are_a_fail_and_never_a_crash(row: Row, sample: bool) -> None:
    for cases in ([{"error": "boom"}], [{"value": 1.0, "right": True}, {"error": "boom"}], [{}], [{"value": "x"}]):
        verdict = row.judge(cases, sample=sample)
        assert verdict.status == "FAIL", (row.name, cases, verdict)


def test_means_of_a_full_run_have_the_interval_that_repeated_draws_have() -> None:
    draw = np.random.default_rng(5)
    row = ratio_of("ratio", lambda case: case["ours"], lambda case: case["theirs"], at_least=0.9)

    def cases() -> list[dict[str, float]]:
        theirs = draw.uniform(0.6, 1.0, 200)
        ours = theirs * draw.uniform(0.8, 1.0, 200)
        return [{"ours": a, "theirs": b} for a, b in zip(ours, theirs, strict=True)]

    verdicts = [row.judge(cases()) for _ in range(300)]
    ratios = np.array([verdict.seen[0] for verdict in verdicts])
    widths = [np.diff([float(end) for end in verdict.interval[1:-1].split(",")])[0] for verdict in verdicts]
    assert np.mean(widths) == pytest.approx(2 * 1.96 * np.std(ratios), rel=0.15)
    for verdict, ratio in zip(verdicts, ratios, strict=True):
        assert (verdict.status == "pass") == (ratio >= 0.9)


def test_cases_that_are_all_alike_have_no_power() -> None:
    assert mean_of("mean", value, at_least=0.9).judge(values(1.0, 1.0, 1.0), sample=True).status == "info"
    assert mean_of("mean", value, at_least=0.9).judge(values(0.8, 0.8, 0.8), sample=True).status == "FAIL"
    assert mean_of("mean", value, at_least=0.9).judge(values(0.1), sample=True).status == "info", "one case alone"
    alike = [{"right": 50.0, "of": 50.0}] * 6
    row = counted_of("counted", lambda case: case["right"], lambda case: case["of"], at_least=0.98)
    assert row.judge(alike, sample=True).power == "<= 91.0% in 5 such runs"


def test_timings_of_a_few_cases_may_say_next_to_nothing() -> None:
    row = time_of("time", value, at_most=20.0)
    assert row.judge(values(2.0, 90.0)).status == "info"
    assert row.judge(values(2.0, 90.0), sample=True).status == "info"
    assert row.judge(values(20.0, 90.0)).status == "FAIL"


def test_a_known_miss_stays_in_and_may_get_no_worse() -> None:
    row = known_miss(all_of("all", right), 0.95, "one in twenty")
    assert row.judge(hits(20, 20), sample=True).status == "known miss"
    assert row.judge(hits(19, 20), sample=True).status == "known miss"
    assert row.judge(hits(9, 20), sample=True).status == "FAIL"
    assert row.judge(hits(19, 20)).status == "known miss"
    assert row.judge(hits(20, 20)).status == "pass"


def test_whole_figures_are_judged_in_full_runs_only() -> None:
    row = whole_of("most", lambda cases: (str(len(cases)), ">= 2", len(cases) >= 2))
    assert [row.judge(values(1.0)).status, row.judge(values(1.0, 2.0)).status] == ["FAIL", "info"]
    assert row.judge(values(1.0), sample=True).status == "info"


def test_rows_of_parts_and_of_some_of_them() -> None:
    cases = [{"scene": s, "drives": [{"scene": s, "right": i != 1} for i in range(3)]} for s in ("here", "there")]
    row = within(all_of("all", right), lambda case: case["drives"])
    assert row.judge(cases).figure == "4/6"
    assert where(row, lambda drive: drive["scene"] == "here").judge(cases).figure == "2/3"
    assert where(row, lambda drive: drive["scene"] == "nowhere").judge(cases).status == "info"
    one, other = each("scene", ["here", "there"], lambda _: row)
    assert (one.name, one.full_only, other.judge(cases).figure) == ("all, here", True, "2/3")


# areas


def test_a_run_of_ci_has_no_more_rows_than_its_false_alarms_are_shared_among() -> None:
    experiments = [one for area in AREAS for one in importlib.import_module(f"verify.{area}").EXPERIMENTS if one.sample]
    rows = [row for one in experiments for row in one.rows if row.test and not row.full_only]
    assert sum(row.known_miss is not None or not isinstance(row.test, Always) for row in rows) <= ROWS


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
    journal = open_journal(tmp_path / "journal.jsonl")
    cases = run_cases(experiment, 1, len(ways), journal).all
    assert ["error" in case for case in cases] == [how != "well" for how in ways]
    assert (cases[0]["how"], cases[0]["value"]) == ("well", 1.0), "its arguments stay beside what it came to"
    again = open_journal(tmp_path / "journal.jsonl")
    assert len(again) == 2, "those that broke are run again"


def test_a_sample_is_put_on_record_once_and_full_runs_into_the_claims(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("verify.harness.area.Record", lambda: Record(tmp_path / "record.jsonl"))
    monkeypatch.setattr("verify.harness.area.ROOT", tmp_path)
    monkeypatch.setattr("verify.harness.claims.RESULTS", tmp_path)
    monkeypatch.setattr("verify.harness.claims.ROOT", tmp_path)
    monkeypatch.setattr(Revision, "here", staticmethod(lambda: Revision("abc", 7)))
    row = all_of("all", lambda case: case["value"] == 1.0)
    experiment = Experiment("one", dies, {"how": "well"}, cases=3, sample=2, rows=[row])
    for _ in range(2):
        outcome = verify("toy", [experiment], Options(sample=True, record=True))
        assert dict(outcome.statuses) == {"pass": 1}
    [line] = (tmp_path / "record.jsonl").read_text().splitlines()
    assert json.loads(line)["rows"] == {"one: all": [2.0, 2.0]}
    assert Record(tmp_path / "record.jsonl").earlier("toy", "one: all", "abc", 7) == []
    assert Record(tmp_path / "record.jsonl").earlier("toy", "one: all", "later", 8) == [(2.0, 2.0)]
    verify("toy", [experiment], Options(write=True))
    another = Experiment("two", dies, {"how": "well"}, cases=2, sample=2, rows=[row])
    verify("toy", [experiment, another], Options(write=True, only="two"))
    runs = json.loads((tmp_path / "toy.json").read_text())
    assert {name: (run["commit"], run["seed"], run["cases"]) for name, run in runs.items()} == {
        "one": ("abc", 7, 3),
        "two": ("abc", 7, 2),
    }, "experiments are written by themselves, so that a long area may be run in pieces"
    never = Experiment("never", dies, {"how": "well"}, cases=2, sample=2, rows=[row])
    areas = {"toy": claims.Area("A toy.", [experiment, another, never]), "other": claims.Area("Never run.", [never])}
    page = claims.page(areas, tmp_path)
    assert "| [toy](#toy) | 0 | 0 | 0 | 2 | 0 | 2 of 3 experiments |" in page
    assert "| other | 0 | 0 | 0 | 0 | 0 | 0 of 1 experiments |" in page
    assert "**one**: 3 cases, commit abc, seed 7, on " in page
    assert "**never**: no full run on file" in page
    assert "| info | all | 3/3 | all | [43.9%, 100.0%] | violations in 53.6% of cases in 1 such run |" in page
    assert "would have caught" not in capsys.readouterr().out


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
            sample=2,
            rows=[all_of("all", right)],
            learn=lambda cases, *_: learned.append(len(cases)),
        )
        verify("toy", [experiment], Options(write_model=True))
    assert learned == [2]


def test_out_of_time_no_experiment_begins_and_each_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    row = all_of("well", right)
    outcome = verify(
        "deaths", [Experiment("late", dies, cases=2, sample=1, rows=[row])], Options(sample=True, deadline=0.0)
    )
    assert dict(outcome.statuses) == {"not shown": 1}
    assert "late: out of time" in capsys.readouterr().out


def test_fuzzing_that_ends_early_is_no_success(monkeypatch: pytest.MonkeyPatch) -> None:
    printed = "relations            60 inputs       2 s  ok\n"
    done = subprocess.CompletedProcess([], 0, printed, "")
    monkeypatch.setattr(fuzz.subprocess, "run", lambda *_, **__: done)
    assert fuzz.read_inputs(1, "relations", 60)["ok"]
    assert not fuzz.read_inputs(1, "relations", 61)["ok"]
    done.stdout = ""
    assert not fuzz.read_inputs(1, "relations", 1)["ok"]


def test_misses_stand_out_on_the_page() -> None:
    row = {"row": "r", "figure": "1 of 2", "target": "all", "interval": "", "power": "", "why": "it is so"}
    assert claims.line({**row, "status": "FAIL"}).startswith("| **FAIL** | r | 1 of 2 |")
    assert claims.line({**row, "status": "known miss"}).startswith("| **known miss** | r | 1 of 2 (it is so) |")


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
