"""The arithmetic behind the rows of `./dev verify`."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from verify.cases.localization import ROOT, Track, fit, imitation
from verify.cases.trajectories import absolute_error, chi_squared, honest_covariance
from verify.harness import (
    BY_CHANCE,
    Verdict,
    all_of,
    chance_of_so_few,
    mean_of_all,
    mean_share,
    ratio_of,
    share_of,
    told,
    wilson,
    write_into,
)


def test_wilson_is_exact_at_its_ends() -> None:
    for count in range(1, 300):
        assert wilson(count, count)[1] == 1.0
        assert wilson(0, count)[0] == 0.0


def test_wilson_as_published() -> None:
    # Newcombe 1998, table I: 81 of 263
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)


def test_a_claim_that_just_holds_fails_in_a_sample_as_seldom_as_said() -> None:
    draw = np.random.default_rng(8)
    for share, count in [(0.995, 50), (0.95, 20), (0.97, 200)]:
        hits = draw.binomial(count, share, 200_000)
        for few in range(count - 6, count + 1):
            assert np.mean(hits <= few) == pytest.approx(chance_of_so_few(few, count, share), abs=0.003)
        row = share_of("most", lambda case: case["right"], at_least=share)
        statuses = np.array(
            [row.judge([{"right": i < n} for i in range(count)], True).status == "FAIL" for n in range(count + 1)]
        )
        assert 0 < np.mean(statuses[hits]) < BY_CHANCE


def test_a_share_of_one_case_has_no_interval_and_is_judged() -> None:
    row = mean_share("apart", lambda case: case["apart"], at_most=0.05)
    assert row.judge([{"apart": 0.04}], True) == Verdict("4.00%", "<= 5%", "pass")
    assert row.judge([{"apart": 0.06}], True).status == "FAIL"
    several = [{"apart": 0.05 + off} for off in (-0.03, 0.0, 0.04)]
    assert (row.judge(several, True).status, row.judge(several, False).status) == ("pass", "FAIL")


def test_what_has_no_target_is_told_unless_a_case_broke() -> None:
    row = told("cases", lambda cases: str(len(cases)))
    assert row.judge([{}, {}], False) == Verdict("2", "", "told")
    assert row.judge([{}, {"error": "boom"}], False).status == "FAIL"


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


def test_a_ratio_of_means_has_the_interval_that_repeated_draws_have() -> None:
    draw = np.random.default_rng(5)
    row = ratio_of("ratio", lambda case: case["ours"], lambda case: case["theirs"], at_least=0.9)

    def cases() -> list[dict[str, float]]:
        theirs = draw.uniform(0.6, 1.0, 200)
        ours = theirs * draw.uniform(0.8, 1.0, 200)
        return [{"ours": a, "theirs": b} for a, b in zip(ours, theirs, strict=True)]

    verdicts = [row.judge(cases(), False) for _ in range(300)]
    ratios = np.array([float(verdict.figure.rpartition(" ")[2]) for verdict in verdicts])
    widths = [np.diff([float(end) for end in verdict.interval[1:-1].split(",")])[0] for verdict in verdicts]
    assert np.mean(widths) == pytest.approx(2 * 1.96 * np.std(ratios), rel=0.15)
    for verdict, ratio in zip(verdicts, ratios, strict=True):
        assert ratio == 0.9 or (verdict.status == "pass") == (ratio > 0.9)
    modest = ratio_of("ratio", lambda case: case["ours"], lambda case: case["theirs"], at_least=0.905)
    samples = [modest.judge(cases(), True).status for _ in range(50)]
    assert samples.count("pass") > 25, "a sample fails only when it contradicts the claim"
    assert row.judge([*cases(), {"error": "boom"}], False).status == "FAIL"


def test_a_mean_over_all_values_fails_in_a_sample_only_where_its_whole_interval_misses() -> None:
    row = mean_of_all("SPL", lambda case: case["spl"], at_least=0.93)
    one_detour = [{"spl": [0.97, 0.95, 0.98, 0.08]}, {"spl": [0.99, 0.96, 0.98, 0.97]}]
    assert row.judge(one_detour, True).status == "pass"
    assert row.judge(one_detour, False).status == "FAIL"
    assert row.judge([{"spl": [0.80, 0.82, 0.84, 0.83, 0.80]}], True).status == "FAIL"
    assert row.judge([{"error": "broke"}], True).status == "FAIL"


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
    maps, local, scatter = (re.search(rf"{part}: {{.*}}", text)[0] for part in ("map", "local", "scatter"))
    expected = [figure(maps, "turn"), figure(maps, "stretch"), figure(maps, "heading"), figure(local, "position")]
    expected += [figure(scatter, "position"), figure(scatter, "heading")]
    # lengths and deviations of what is slow make up for one another; what they come to is well known
    growth = np.sqrt(figure(maps, "length") / found["map_length"])
    assert found["deviations"][:3] * growth == pytest.approx(expected[:3], rel=0.35)
    assert found["deviations"][4:] == pytest.approx(expected[4:], rel=0.1)


def figure(part: str, name: str) -> float:
    return float(re.search(rf"{name}: ([\d.e-]+)", part)[1])


@pytest.mark.parametrize(
    ("degrees", "low", "high"), [(3, 0.2158, 9.3484), (12, 4.4038, 23.3367), (30, 16.7908, 46.9792)]
)
def test_quantiles_of_chi_squared_as_tabulated(degrees: int, low: float, high: float) -> None:
    tolerance = 0.05 if degrees < 30 else 0.02
    assert chi_squared(degrees, -1.959964) == pytest.approx(low, abs=tolerance)
    assert chi_squared(degrees, 1.959964) == pytest.approx(high, abs=tolerance)


@pytest.mark.parametrize(("nees", "status"), [(0.5, "FAIL"), (2.0, "pass"), (4.5, "pass"), (9.0, "FAIL")])
def test_a_covariance_may_be_neither_too_small_nor_too_large(nees: float, status: str) -> None:
    assert honest_covariance().judge([{"nees": nees}] * 10, False).status == status


@pytest.mark.parametrize(
    ("scene", "randomization", "rmse", "status"),
    [
        ("office_v2", "none", 0.049, "pass"),
        ("office_v2", "none", 0.051, "FAIL"),
        ("office_v2", "hard", 0.079, "pass"),
        ("corridor_v1", "none", 0.99, "pass"),
        ("corridor_v1", "none", 1.01, "FAIL"),
    ],
)
def test_how_far_off_a_drive_may_be(scene: str, randomization: str, rmse: float, status: str) -> None:
    case = {"rmse": rmse, "rmse_heading": 0.0, "worst": rmse, "driven": 200.0}
    assert absolute_error(scene, randomization).judge([case] * 3, False).status == status


def test_figures_are_written_between_their_marks_and_again(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# Title\n\n<!-- figures: begin -->\nold\n<!-- figures: end -->\n\nThe rest.\n")
    judged = [
        ("one", "reached", Verdict("9/10", ">= 95 %", "FAIL", "[60 %, 98 %]")),
        ("two", "speed", Verdict("3", "", "pass")),
    ]
    for _ in range(2):
        write_into(page, "here", judged)
        text = page.read_text()
        assert text.startswith("# Title\n\n<!-- figures: begin -->\nFrom here.\n")
        assert text.endswith("<!-- figures: end -->\n\nThe rest.\n")
        assert "| reached | 9/10 **missed** | >= 95 % | [60 %, 98 %] |" in text
        assert "old" not in text
        assert text.count("**two**") == 1
    page.write_text("no marks")
    with pytest.raises(ValueError, match="figures: begin"):
        write_into(page, "here", judged)
