"""The HTML report holds all that it shows, and its player finds every pose."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from threewe._web import web_file
from threewe.benchmark.attempt import Settings
from threewe.benchmark.plots import interval_plot, share_plot, wall_outline
from threewe.benchmark.report import report
from threewe.benchmark.run import plan_run, results_of, run

ROOT = Path(__file__).resolve().parents[3]
NODE = shutil.which("node")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

SCRIPT = """
import { poseAt, viewOf, durationOf, EpisodePlayer } from "./episode_player.mjs";
const trajectory = [[0, 0, 3.0], [1, 2, -3.0], [1, 2, -3.0]];
const calls = [];
const context = new Proxy({}, { get: (_, name) => (...given) => calls.push([name, ...given]), set: () => true });
const canvas = { width: 224, height: 124, getContext: () => context };
const scene = { min: [0, 0], max: [2, 1], walls: [[[0, 0], [2, 0], [2, 0.1], [0, 0.1]]], furniture: [] };
const times = [];
const player = new EpisodePlayer(canvas, scene, { onTime: (seconds) => times.push(seconds) });
player.show({ trajectory, period: 0.2, goal: [1, 1], radius: 0.2 });
player.seek(99);
console.log(JSON.stringify({
  middle: poseAt(trajectory, 0.2, 0.1),
  before: poseAt(trajectory, 0.2, -1),
  after: poseAt(trajectory, 0.2, 9),
  none: poseAt([], 0.2, 0),
  corner: viewOf(scene, 224, 124).toPixels([0, 0]),
  duration: durationOf({ trajectory, period: 0.2 }),
  times,
  wall: calls.filter(([name]) => name === "lineTo").slice(0, 2),
}));
"""


@pytest.mark.skipif(NODE is None, reason="not shown: the player runs in Node, and there is none here")
def test_the_player_finds_every_pose(tmp_path: Path) -> None:
    (tmp_path / "episode_player.mjs").write_text(web_file("episode_player.js"))
    (tmp_path / "script.mjs").write_text(SCRIPT)
    done = subprocess.run([str(NODE), "script.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    x, y, theta = found["middle"]
    assert (x, y) == (0.5, 1.0)
    assert theta == pytest.approx(3.1416, abs=1e-3), "it turns the short way round"
    assert (found["before"], found["after"], found["none"]) == ([0, 0, 3.0], [1, 2, -3.0], None)
    assert found["corner"] == [12, 112], "y points up"
    assert found["duration"] == 0.4
    assert found["times"] == [0, 0.4]
    assert found["wall"] == [["lineTo", 12, 112], ["lineTo", 212, 112]]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    plan, episodes = plan_run(
        "pointnav", "navigator", split="val", scenes=["apartment_v1"], episodes=2, settings=Settings()
    )
    return results_of(plan, episodes, run(plan, episodes, tmp_path_factory.mktemp("run") / "journal.jsonl", workers=0))


def test_the_page_holds_all_that_it_shows(tmp_path: Path) -> None:
    plan, episodes = plan_run(
        "pointnav", "navigator", split="val", scenes=["apartment_v1"], episodes=2, settings=Settings()
    )
    outcomes = run(plan, episodes, tmp_path / "journal.jsonl", workers=0)
    outcomes[0]["failure"] = "</script><script>alert(1)</script>"
    page = report(results_of(plan, episodes, outcomes))
    [data] = re.findall(r'<script id="data" type="application/json">(.*?)</script>', page, re.S)
    [scene] = json.loads(data)["scenes"]
    assert scene["name"] == "apartment_v1"
    assert len(scene["walls"]) > 4
    assert [episode["trajectory"] for episode in scene["episodes"]] == [one["trajectory"] for one in outcomes]
    assert scene["episodes"][0]["goal"] == list(episodes[0].goal or ())
    assert page.count("</script>") == 2, "what an agent says is no code"
    assert "export class EpisodePlayer" in page
    assert not re.search(r'(src|href)="', page), "nothing is fetched"
    if NODE is not None:
        [code] = re.findall(r'<script type="module">(.*?)</script>', page, re.S)
        (tmp_path / "page.mjs").write_text(code)
        assert subprocess.run([NODE, "--check", "page.mjs"], cwd=tmp_path).returncode == 0


@pytest.mark.flaky(reruns=1)  # a loaded machine may give the page no time to play
@pytest.mark.skipif(CHROMIUM is None, reason="not shown: there is no Chromium here to show the page")
@pytest.mark.parametrize(
    ("address", "deed", "shown"),
    [
        ("", "", "0.0 / "),
        ("#apartment_v1/{index}/3.5", "", "3.5 / "),
        ("#no_such_scene/x/y", "", "0.0 / "),
        ("", "const t = document.getElementById('time'); t.value = 2; t.dispatchEvent(new Event('input'));", "2.0 / "),
        ("", "document.querySelectorAll('#episodes button')[1].click();", "0.0 / "),
        ("", "document.getElementById('play').click();", "Pause"),
    ],
)
def test_the_page_shows_and_plays_in_a_browser(
    address: str, deed: str, shown: str, results: dict[str, Any], tmp_path: Path
) -> None:
    index = results["episode_results"][1]["episode"]["index"]
    page = report(results).replace("</body>", f'<script type="module">{deed}</script></body>')
    (tmp_path / "report.html").write_text(page)
    command = [str(CHROMIUM), "--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'user'}",
               "--virtual-time-budget=200", "--enable-logging=stderr", "--dump-dom",
               f"file://{tmp_path}/report.html{address.format(index=index)}"]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert "Uncaught" not in done.stderr
    body = re.sub(r"<(script|style).*?</\1>", "", done.stdout, flags=re.S)
    assert shown in body
    chosen = re.findall(r'aria-pressed="(true|false)"', body)
    is_second = "{index}" in address or "episodes" in deed
    assert chosen == (["false", "true"] if is_second else ["true", "false"])


def test_plots_say_what_they_show() -> None:
    figure = {"value": 0.5, "low": 0.25, "high": 1.0}
    plot = interval_plot("a <rate>", [("all", figure), ("here & there", figure)])
    assert 'aria-label="a &lt;rate&gt;: all 0.50; here &amp; there 0.50"' in plot
    assert plot.count("<circle") == 2
    [x1, x2] = re.findall(r'<line x1="([\d.]+)" x2="([\d.]+)" y1="52"', plot)[0]
    [middle] = set(re.findall(r'<circle cx="([\d.]+)"', plot))
    assert float(middle) - float(x1) == pytest.approx((float(x2) - float(x1)) / 3, abs=0.1)
    curve = share_plot("area", [[0.5, 1.0], [0.0, 0.5]])
    assert "area: 0.75 in the end" in curve
    assert curve.count("<polyline") == 3


def test_walls_have_their_thickness() -> None:
    assert wall_outline((0.0, 0.0), (2.0, 0.0), 0.2) == [(0.0, 0.1), (2.0, 0.1), (2.0, -0.1), (0.0, -0.1)]
