"""HTML report of results: figures with intervals, trajectories over the maps, a player. One file, nothing fetched."""

from __future__ import annotations

import html
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from threewe._core import Pose2D, RobotProfile, Scene
from threewe.benchmark.attempt import POSE_EVERY
from threewe.benchmark.buildings import load_scene
from threewe.benchmark.episodes import Episode, find_episodes, load_episodes
from threewe.benchmark.tasks import TASKS, TICK
from threewe.errors import ConfigError

Polygon = list[tuple[float, float]]
TITLES = {
    "success": "success rate",
    "success_without_contact": "success rate without contact",
    "spl": "SPL",
    "soft_spl": "SoftSPL",
    "contacts": "contacts",
    "duration": "time [s]",
    "distance_to_success": "distance to success [m]",
    "coverage": "coverage",
    "cell_ratio": "cell ratio",
    "map_accuracy": "map accuracy",
    "agent_failures": "episodes in which the agent failed",
}
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem; color: #22272e; }
table { border-collapse: collapse; } td, th { padding: .2rem .7rem; text-align: right; }
tr > :first-child { text-align: left; }
tbody tr:nth-child(odd) { background: #f4f5f7; } .interval { color: #667; font-size: 12px; display: block; }
canvas { border: 1px solid #ccd; width: 100%; }
.player { display: flex; gap: 1rem; align-items: center; margin: .5rem 0; }
input[type=range] { flex: 1; } select { max-width: 32rem; } svg text { font: 12px system-ui, sans-serif; }
"""


def write_report(results: dict[str, Any], path: Path) -> None:
    """Writes the report. Raises ConfigError where a scene of the results is not known here."""
    path.write_text(report(results))


def report(results: dict[str, Any]) -> str:
    """The page."""
    title = f"{results['task']}: {results['agent']['name']}"
    data = json.dumps(_data(results)).replace("</", "<\\/")
    player = player_module().replace("</script", "<\\/script")
    return f"""<!doctype html>
<html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title><style>{STYLE}</style>
<h1>{html.escape(title)}</h1>
<p>{html.escape(_described(results))}</p>
{_table(results)}
{_plots(results)}
<h2>Episodes</h2>
<div class="player"><select id="scene"></select><select id="episode"></select></div>
<canvas id="canvas" width="1400" height="800"></canvas>
<div class="player"><button id="play">play</button><input id="time" type="range" min="0" step="0.02" value="0">
<output id="clock"></output></div>
<p id="said"></p>
<script id="data" type="application/json">{data}</script>
<script type="module">
{player}
{PAGE}
</script>
</html>
"""


PAGE = """
const data = JSON.parse(document.getElementById("data").textContent);
const element = (name) => document.getElementById(name);
let player = null;
function choose(select, names) {
  select.replaceChildren(...names.map((name, i) => new Option(name, i)));
}
function showEpisode() {
  const scene = data.scenes[element("scene").value];
  const episode = scene.episodes[element("episode").value];
  element("time").max = durationOf(episode);
  element("said").textContent = episode.said;
  player.show(episode, scene.episodes);
}
function showScene() {
  const scene = data.scenes[element("scene").value];
  player = new EpisodePlayer(element("canvas"), scene, {
    onTime: (seconds, playing) => {
      element("time").value = seconds;
      element("clock").textContent = `${seconds.toFixed(1)} s`;
      element("play").textContent = playing ? "pause" : "play";
    },
  });
  choose(element("episode"), scene.episodes.map((episode) => episode.name));
  showEpisode();
}
element("scene").addEventListener("change", showScene);
element("episode").addEventListener("change", showEpisode);
element("play").addEventListener("click", () => (player.playing ? player.pause() : player.play()));
element("time").addEventListener("input", (event) => { player.pause(); player.seek(Number(event.target.value)); });
choose(element("scene"), data.scenes.map((scene) => scene.name));
showScene();
"""


def player_module() -> str:
    """The source of the player: of the package, or of the source tree."""
    here = Path(__file__).resolve()
    for folder in (here.parents[1] / "web", here.parents[3] / "web"):
        if (folder / "episode_player.js").exists():
            return (folder / "episode_player.js").read_text()
    raise ConfigError("web/episode_player.js is missing from this installation of threewe")


def _described(results: dict[str, Any]) -> str:
    settings, library = results["settings"], results["library"]
    parts = [
        f"episodes {results['episode_set']}",
        f"backend {settings['backend']}",
        f"robot {settings['hardware']}",
        f"noise {settings['noise']}",
        f"gate {results['gate']}",
        f"localization {results['localization']}",
        f"randomization {settings['randomization']}",
        "official" if results["official"] else "not official",
        "agent privileged" if results["agent"]["privileged"] else "agent without the truth",
        f"track {results['track']}",
        f"repeats {results['repeats']}",
        f"threewe {library['version']} {library['commit']}".rstrip(),
    ]
    return ", ".join(parts)


def _table(results: dict[str, Any]) -> str:
    names = [name for name in TITLES if name in results["summary"]["all"]]
    head = "".join(f"<th>{html.escape(TITLES[name])}</th>" for name in names)
    rows = []
    for scene, figures in results["summary"].items():
        cells = "".join(f"<td>{_cell(name, figures[name])}</td>" for name in names)
        rows.append(f"<tr><td>{html.escape(scene)}</td><td>{figures[names[0]]['count']}</td>{cells}</tr>")
    body = "".join(rows)
    return f"<table><thead><tr><th>scene</th><th>n</th>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(name: str, figure: dict[str, Any]) -> str:
    if name == "agent_failures":
        return f"{figure['value']:g}"
    digits = 1 if name == "duration" else 3
    value, low, high = (f"{figure[key]:.{digits}f}" for key in ("value", "low", "high"))
    return f'{value}<span class="interval">{low} to {high}</span>'


def _plots(results: dict[str, Any]) -> str:
    """The first metrics of each scene, with their intervals."""
    task = TASKS[results["task"]]
    names = [*task.rates[:1], *task.means[: 2 if task.name == "exploration" else 1]]
    return "".join(_plot(name, results["summary"]) for name in names)


def _plot(name: str, summary: dict[str, dict[str, Any]]) -> str:
    width, left, row = 560, 150, 22
    lines = []
    for i, (scene, figures) in enumerate(summary.items()):
        figure, y = figures[name], 30 + row * i
        low, value, high = (left + (width - left - 20) * figure[key] for key in ("low", "value", "high"))
        lines.append(
            f'<text x="{left - 8}" y="{y + 4}" text-anchor="end">{html.escape(scene)}</text>'
            f'<line x1="{low:.1f}" x2="{high:.1f}" y1="{y}" y2="{y}" stroke="#3474db" stroke-width="2"/>'
            f'<circle cx="{value:.1f}" cy="{y}" r="4" fill="#3474db"/>'
        )
    height = 40 + row * len(summary)
    ticks = "".join(
        f'<line x1="{x:.0f}" x2="{x:.0f}" y1="18" y2="{height - 20}" stroke="#dde"/>'
        f'<text x="{x:.0f}" y="{height - 6}" text-anchor="middle">{share:g}</text>'
        for share in (0, 0.25, 0.5, 0.75, 1)
        for x in (left + (width - left - 20) * share,)
    )
    title = f'<text x="{left}" y="12" font-weight="bold">{html.escape(TITLES[name])}</text>'
    return f'<svg width="{width}" height="{height}" role="img">{title}{ticks}{"".join(lines)}</svg>'


def _data(results: dict[str, Any]) -> dict[str, Any]:
    """What the player shows: scenes from above, and the episodes in each."""
    radius = max(math.hypot(*corner) for corner in RobotProfile.load(results["settings"]["hardware"]).footprint)
    frozen = _frozen(results)
    scenes = []
    for name in dict.fromkeys(row["episode"]["scene"] for row in results["episode_results"]):
        rows = [row for row in results["episode_results"] if row["episode"]["scene"] == name]
        episodes = [_episode(row, frozen.get((name, row["episode"]["index"])), radius) for row in rows]
        scenes.append({"name": name, **from_above(load_scene(name)), "episodes": episodes})
    return {"scenes": scenes}


def _episode(row: dict[str, Any], episode: Episode | None, radius: float) -> dict[str, Any]:
    named, metrics = row["episode"], row["metrics"]
    about = named.get("category") or named.get("stratum") or ""
    numbers = ", ".join(
        f"{TITLES.get(name, name)} {value:.3g}" for name, value in metrics.items() if isinstance(value, float)
    )
    return {
        "name": f"{named['index']} {about} {row['end']}".strip(),
        "said": f"{row['failure']} {numbers}".strip(),
        "success": metrics.get("success", 1.0) > 0.5,
        "trajectory": row["trajectory"],
        "period": POSE_EVERY * TICK,
        "goal": list(episode.goal) if episode and episode.goal else None,
        "radius": radius,
    }


def _frozen(results: dict[str, Any]) -> dict[tuple[str, int], Episode]:
    """The episodes, for their goals; none where their set is not at hand."""
    try:
        listed = load_episodes(find_episodes(results["episode_set"]))["episodes"]
    except ConfigError:
        return {}
    return {(episode.scene, episode.index): episode for episode in listed}


def from_above(scene: Scene) -> dict[str, Any]:
    """Walls and furniture as polygons [m], in centimetres."""
    walls = [wall_outline(wall.a, wall.b, wall.thickness) for wall in scene.walls]
    furniture = [
        [_placed(thing.pose, corner) for corner in prism.outline()]
        for thing in scene.objects
        for prism in thing.prisms
        if prism.z_min < 2.0
    ]
    return {"min": list(scene.min), "max": list(scene.max), "walls": rounded(walls), "furniture": rounded(furniture)}


def wall_outline(a: tuple[float, float], b: tuple[float, float], thickness: float) -> Polygon:
    """The corners of a straight wall."""
    length = math.dist(a, b) or 1.0
    x, y = -(b[1] - a[1]) / length * thickness / 2, (b[0] - a[0]) / length * thickness / 2
    return [(a[0] + x, a[1] + y), (b[0] + x, b[1] + y), (b[0] - x, b[1] - y), (a[0] - x, a[1] - y)]


def rounded(polygons: Sequence[Polygon]) -> list[list[list[float]]]:
    """To centimetres."""
    return [[[round(x, 2), round(y, 2)] for x, y in polygon] for polygon in polygons]


def _placed(pose: Pose2D, corner: tuple[float, float]) -> tuple[float, float]:
    point = pose * Pose2D(corner[0], corner[1], 0.0)
    return point.x, point.y
