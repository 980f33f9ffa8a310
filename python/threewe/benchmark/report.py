"""HTML report of results: figures with intervals, trajectories over the maps, a player. One file, nothing fetched.

Its style and script are files in the folder web.
"""

from __future__ import annotations

import html
import json
import math
import re
from pathlib import Path
from typing import Any

from threewe._core import RobotProfile
from threewe._web import web_file
from threewe.benchmark.attempt import POSE_EVERY
from threewe.benchmark.buildings import load_scene
from threewe.benchmark.episodes import Episode, find_episodes, load_episodes
from threewe.benchmark.plots import from_above, interval_plot, share_plot
from threewe.benchmark.tasks import NAMES, TASKS, TICK, TITLES
from threewe.errors import ConfigError

METRICS = {**TITLES, "path_length": "path [m]", "collision_speed": "fastest contact [m/s]", "crossed": "area crossed"}
STRATUM = re.compile(r"(\d+-\d+) (\w+)")
MANY = 12  # scenes: beyond, plots show all of them together


def write_report(results: dict[str, Any], path: Path) -> None:
    """Writes the report. Raises ConfigError where a scene of the results is not known here."""
    path.write_text(report(results))


def report(results: dict[str, Any]) -> str:
    """The page. Raises ConfigError for results without trajectories."""
    if any("trajectory" not in row for row in results["episode_results"]):
        raise ConfigError("results without trajectories cannot be shown on a page: run without --compact")
    title = f"{NAMES[results['task']]}: {results['agent']['name']}"
    data = json.dumps(_data(results)).replace("</", "<\\/")
    script = "\n".join(web_file(name) for name in ("episode_player.js", "report.js")).replace("</script", "<\\/script")
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title><style>{web_file("report.css")}</style></head><body>
<h1>{NAMES[results["task"]]} <small>{html.escape(results["agent"]["name"])}</small></h1>
{_badges(results)}
{_cards(results)}
<h2>Figures with their 95 % intervals</h2>
<div class="plots">{_plots(results)}</div>
<h2>By scene</h2>
{_table(results)}
<h2>Episodes</h2>
{PLAYER}
<script id="data" type="application/json">{data}</script>
<script type="module">
{script}
</script>
</body></html>
"""


PLAYER = """<div class="player">
<div><div class="stage"><canvas id="canvas" role="img" aria-label="the drive from above"></canvas>
<div class="controls"><button id="play">Play</button>
<input id="time" type="range" min="0" step="0.02" value="0" aria-label="time">
<output id="clock"></output><select id="speed" aria-label="speed"><option value="1">1 x</option>
<option value="4" selected>4 x</option><option value="16">16 x</option></select></div></div>
<ul class="legend"><li><i style="color:#1f5fd0"></i>driven</li><li><i style="color:#8fb4f2"></i>still to come</li>
<li><i style="color:#17804a"></i>other episodes that succeed</li>
<li><i style="color:#c4313c;border-top-style:dashed"></i>that fail</li>
<li><i class="dot" style="color:#17804a"></i>goal</li></ul></div>
<div class="side"><select id="scene" aria-label="scene"></select><ol id="episodes"></ol>
<p id="failure"></p><dl id="metrics"></dl></div></div>"""


def _badges(results: dict[str, Any]) -> str:
    settings, library = results["settings"], results["library"]
    facts = {
        "episodes": results["episode_set"],
        "backend": settings["backend"],
        "robot": settings["hardware"],
        "noise": settings["noise"],
        "gate": results["gate"],
        "localization": results["localization"],
        "randomization": settings["randomization"],
        "results": "official" if results["official"] else "not official",
        "agent": "privileged" if results["agent"]["privileged"] else "without the truth",
        "track": results["track"],
        "repeats": results["repeats"],
        "threewe": f"{library['version']} {library['commit']}".rstrip(),
    }
    lines = "".join(f"<li>{name} <b>{html.escape(str(value))}</b></li>" for name, value in facts.items())
    return f'<ul class="badges">{lines}</ul>'


def _cards(results: dict[str, Any]) -> str:
    """The first figures, large."""
    figures = results["summary"]["all"]
    names = [name for name in TITLES if name in figures and name != "agent_failures"][:6]
    count = figures[names[0]]["count"]
    scenes = len(results["summary"]) - 1
    failed = figures["agent_failures"]["value"]
    of = f"in {scenes} scene{'s' * (scenes != 1)}{f', the agent failed in {failed:g}' if failed else ''}"
    cards = "".join(f"<div><dt>{TITLES[name]}</dt><dd>{_cell(name, figures[name])}</dd></div>" for name in names)
    return f'<dl class="cards">{cards}<div><dt>episodes</dt><dd>{count}<span>{of}</span></dd></div></dl>'


def _table(results: dict[str, Any]) -> str:
    names = [name for name in TITLES if name in results["summary"]["all"]]
    head = "".join(f"<th>{html.escape(TITLES[name])}</th>" for name in names)
    rows = []
    for scene, figures in _in_order(results):
        cells = "".join(f"<td>{_cell(name, figures[name])}</td>" for name in names)
        rows.append(f"<tr><td>{html.escape(scene)}</td><td>{figures[names[0]]['count']}</td>{cells}</tr>")
    head = f"<thead><tr><th>scene</th><th>n</th>{head}</tr></thead>"
    return f'<div class="scroll"><table>{head}<tbody>{"".join(rows)}</tbody></table></div>'


def _in_order(results: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """All episodes, then each scene as the player has them: JSON keeps no order."""
    return [(name, results["summary"][name]) for name in ("all", *_scenes(results))]


def _scenes(results: dict[str, Any]) -> list[str]:
    return list(dict.fromkeys(row["episode"]["scene"] for row in results["episode_results"]))


def _cell(name: str, figure: dict[str, Any]) -> str:
    if name == "agent_failures":
        return f"{figure['value']:g}"
    digits = 1 if name == "duration" else 2
    value, low, high = (f"{figure[key]:.{digits}f}" for key in ("value", "low", "high"))
    return f'{value}<span class="interval">{low} to {high}</span>'


def _plots(results: dict[str, Any]) -> str:
    """The first metrics of each scene with their intervals, and coverage over time."""
    task = TASKS[results["task"]]
    rows = _in_order(results)
    rows = rows if len(rows) <= MANY else rows[:1]
    names = [*task.rates[:1], *task.means[: 2 if task.name == "exploration" else 1]]
    plots = [interval_plot(TITLES[name], [(scene, figures[name]) for scene, figures in rows]) for name in names]
    if task.name == "exploration":
        curves = [row["metrics"]["coverage_over_time"] for row in results["episode_results"]]
        if all(curves):
            plots.append(share_plot("area crossed over the time that there is", curves))
    return "".join(plots)


def _data(results: dict[str, Any]) -> dict[str, Any]:
    """What the player shows: scenes from above, and the episodes in each."""
    radius = max(math.hypot(*corner) for corner in RobotProfile.load(results["settings"]["hardware"]).footprint)
    frozen = _frozen(results)
    scenes = []
    for name in _scenes(results):
        rows = [row for row in results["episode_results"] if row["episode"]["scene"] == name]
        episodes = [_episode(results["task"], row, frozen.get((name, row["episode"]["index"])), radius) for row in rows]
        scenes.append({"name": name, **from_above(load_scene(name)), "episodes": episodes})
    return {"scenes": scenes}


def _episode(task: str, row: dict[str, Any], episode: Episode | None, radius: float) -> dict[str, Any]:
    named, metrics = row["episode"], row["metrics"]
    about = named.get("category") or named.get("instruction") or STRATUM.sub(r"\1 m \2", named.get("stratum", ""))
    headline = TASKS[task].headline
    brief = f"{TITLES[headline]} {metrics.get(headline, 0.0):.2f}, {metrics.get('duration', 0.0):.0f} s"
    shown = {name: value for name, value in metrics.items() if isinstance(value, float)}
    order = [*(name for name in METRICS if name in shown), *(name for name in shown if name not in METRICS)]
    return {
        "index": named["index"],
        "about": f"{about}{', ' * bool(about and row['end'] != 'stop')}{ENDS[row['end']]}",
        "brief": brief,
        "failure": row["failure"],
        "metrics": [[METRICS.get(name, name), f"{shown[name]:.3g}"] for name in order],
        "success": metrics["success"] > 0.5 if "success" in metrics else None,
        "trajectory": row["trajectory"],
        "period": POSE_EVERY * TICK,
        "goal": list(episode.goal) if episode and episode.goal else None,
        "radius": radius,
    }


ENDS = {"stop": "", "time": "out of time", "failure": "the agent failed"}


def _frozen(results: dict[str, Any]) -> dict[tuple[str, int], Episode]:
    """The episodes, for their goals; none where their set is not at hand."""
    try:
        listed = load_episodes(find_episodes(results["episode_set"]))["episodes"]
    except ConfigError:
        return {}
    return {(episode.scene, episode.index): episode for episode in listed}
