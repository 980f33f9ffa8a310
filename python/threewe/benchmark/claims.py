"""Claims of a bundle: an episode each, with the log that it rests on, which has to be such as a robot leaves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from threewe._core import OccupancyGrid, RobotProfile
from threewe._model_talk import Record
from threewe.benchmark.agents import MODEL
from threewe.benchmark.attempt import SLOWEST
from threewe.benchmark.bundle import KINDS, Bundle, BundleError
from threewe.benchmark.episodes import Episode, digest, find_episodes, load_episodes
from threewe.benchmark.run import Plan, select
from threewe.benchmark.tasks import TICK
from threewe.errors import ConfigError

LONGEST_TEXT = 400  # characters of a name or of what an agent failed of
LARGEST_GRID = 4096  # cells along a side
ROUNDING = 1e-9  # of limits: commands are rounded
ENDS = ("stop", "time", "failure")
STILL = np.float32(0.05)  # actions below it ...
STOP_TICKS = 25  # ... for so long are STOP, as the environments have it
FIRST_SAMPLES = 50  # ticks at most until each sensor has delivered and an agent is asked for the first time


@dataclass(frozen=True)
class Claim:
    """One episode of a bundle."""

    number: int
    episode: Episode
    row: dict[str, Any]
    commands: NDArray[np.float64]
    actions: NDArray[np.float32] | None  # of an agent that acts
    grid: OccupancyGrid | None
    talk: bytes | None  # with a model

    @property
    def name(self) -> str:
        """For messages."""
        return f"episode {self.number} ({self.episode.scene}/{self.episode.index})"


def claims_of(bundle: Bundle, plan: Plan, episode_file: Path | None) -> list[Claim]:
    """The episodes of a bundle, which are those of the frozen set, in its order."""
    if episode_file is None and not plan.episode_set.isidentifier():
        raise BundleError(f"episode_set: {plan.episode_set!r} is no name of one")
    try:
        file = episode_file or find_episodes(plan.episode_set)
        frozen = load_episodes(file)
    except ConfigError as error:
        raise BundleError(f"episode_set: {error}") from None
    if (frozen["name"], frozen["task"]) != (plan.episode_set, plan.task) or digest(file) != plan.episode_hash:
        raise BundleError(f"episode_set: not the {plan.episode_set} that is known here: task or hash differs")
    wanted = select(frozen, plan)
    rows = bundle.results.get("episode_results")
    if not isinstance(rows, list) or len(rows) != len(wanted) or not wanted:
        raise BundleError(f"episode_results: expected {len(wanted)} episodes, as scenes and episodes say")
    claims = [
        _claim(bundle, plan.agent.name, number, *pair) for number, pair in enumerate(zip(wanted, rows, strict=True))
    ]
    left_over = set(bundle.files) - {
        f"{kind}/{claim.number:05}.{end}" for claim in claims for kind, end in KINDS.items()
    }
    if left_over:
        raise BundleError(f"{min(left_over)}: of no episode")
    return claims


def _claim(bundle: Bundle, named_agent: str, number: int, episode: Episode, row: Any) -> Claim:
    place = f"episode {number} ({episode.scene}/{episode.index})"
    if not isinstance(row, dict) or not isinstance(row.get("episode"), dict):
        raise BundleError(f"{place}: not as a run writes it")
    named = {key: row["episode"].get(key) for key in ("scene", "index", "seed")}
    if named != {"scene": episode.scene, "index": episode.index, "seed": episode.seed}:
        raise BundleError(f"{place}: the bundle has {named} in its place, which the frozen set has not")
    if row.get("end") not in ENDS:
        raise BundleError(f"{place}: end: expected one of {', '.join(ENDS)}")
    failure = row.get("failure")
    if not isinstance(failure, str) or len(failure) > LONGEST_TEXT or (failure != "") != (row["end"] == "failure"):
        raise BundleError(f"{place}: failure: expected why the agent failed, where it did")
    content = bundle.part("commands", number)
    if content is None or len(content) % 24 != 0:
        raise BundleError(f"{place}: expected commands, three numbers of 8 bytes a tick")
    commands = np.frombuffer(content, "<f8").reshape(-1, 3)
    if row.get("ticks") != len(commands):
        raise BundleError(f"{place}: ticks: {row.get('ticks')} are claimed, commands are there for {len(commands)}")
    actions = bundle.part("actions", number)
    if actions is not None and len(actions) % 12 != 0:
        raise BundleError(f"{place}: expected actions, three numbers of 4 bytes a step")
    talk = bundle.part("talk", number)
    if talk is not None:
        if not named_agent.startswith(f"{MODEL}@"):
            raise BundleError(f"{place}: talk: of an agent that asks no model")
        try:
            Record.read(talk, "talk")
        except ConfigError as error:
            raise BundleError(f"{place}: {error}") from None
    asked = None if actions is None else np.frombuffer(actions, "<f4").reshape(-1, 3)
    return Claim(number, episode, row, commands, asked, _grid(bundle, place, number, row), talk)


def _grid(bundle: Bundle, place: str, number: int, row: dict[str, Any]) -> OccupancyGrid | None:
    content, described = bundle.part("grid", number), row.get("grid")
    if content is None and described is None:
        return None
    try:
        rows, columns = described["shape"]  # type: ignore[index]
        x, y = described["origin"]  # type: ignore[index]
        resolution = float(described["resolution"])  # type: ignore[index]
        if not (0 < rows <= LARGEST_GRID and 0 < columns <= LARGEST_GRID) or not 0.01 <= resolution <= 1.0:
            raise ValueError("its size")
        if content is None or len(content) != rows * columns or not (abs(x) < 1e4 and abs(y) < 1e4):
            raise ValueError("its cells")
        cells = np.frombuffer(content, np.int8).reshape(rows, columns)
        if cells.min() < -1 or cells.max() > 100:
            raise ValueError("values beyond -1 to 100")
        return OccupancyGrid(np.ascontiguousarray(cells), resolution, (float(x), float(y)))
    except (TypeError, ValueError, KeyError) as error:
        raise BundleError(f"{place}: grid: not a map: {error}") from None


def require_drivable(claim: Claim, profile: RobotProfile, time_limit: float) -> None:
    """The commands are such as leave the gate of this robot: in number, limits and rates."""
    commands, limits = claim.commands, profile.operating_limits
    seconds = len(commands) * TICK
    if seconds > time_limit + 1.0 / SLOWEST:
        raise BundleError(f"{claim.name}: {seconds:.2f} s are more than the task's {time_limit:.2f} s")
    if claim.row["end"] != "failure" and (claim.row["end"] == "time") != (seconds >= time_limit):
        raise BundleError(f"{claim.name}: {claim.row['end']} after {seconds:.2f} s of the task's {time_limit:.2f} s")
    if not np.isfinite(commands).all():
        raise BundleError(f"{claim.name}: a command is not finite")
    before = np.vstack([np.zeros((1, 3)), commands[:-1]])
    speed, speed_before = (np.hypot(one[:, 0], one[:, 1]) for one in (commands, before))
    change = np.hypot(*(commands - before)[:, :2].T)
    stops = ~commands.any(axis=1)  # the emergency stop goes beyond all rates
    hardest = max(limits.linear_acceleration, limits.linear_braking)
    checks = {
        f"speed beyond {limits.linear} m/s": speed > limits.linear + ROUNDING,
        f"turn rate beyond {limits.angular} rad/s": abs(commands[:, 2]) > limits.angular + ROUNDING,
        "speeds up faster than the profile allows": speed - speed_before > limits.linear_acceleration * TICK + ROUNDING,
        "changes faster than the profile allows": ~stops & (change > hardest * TICK + ROUNDING),
        "turns faster than the profile allows": ~stops
        & (abs(commands - before)[:, 2] > limits.angular_acceleration * TICK + ROUNDING),
    }
    for what, wrong in checks.items():
        if wrong.any():
            tick = int(np.argmax(wrong))
            raise BundleError(f"{claim.name}: the command at {tick * TICK:.2f} s {what}")


def require_actions(claim: Claim, plan: Plan) -> None:
    """An agent that acts has an action for each step, and says STOP where its episode ends.

    That is all: what the gate makes of an action depends on what the robot sensed, which no replay below it has.
    """
    actions, ticks = claim.actions, len(claim.commands)
    acts = plan.agent.kind == "act" and ticks > 0  # of a process that was lost there is nothing
    if (actions is not None) != acts:
        raise BundleError(f"{claim.name}: actions: {'missing' if acts else 'of none that acts'}")
    if actions is None:
        return
    if not np.isfinite(actions).all():
        raise BundleError(f"{claim.name}: actions: one is not finite")
    periods = [period for period in range(1, round(1.0 / (SLOWEST * TICK)) + 1) if _fits(claim, len(actions), period)]
    if not periods:
        raise BundleError(f"{claim.name}: actions: {len(actions)} are not those of {ticks * TICK:.2f} s")
    if plan.task != "exploration" and not any(_ends(claim.row["end"], actions, period) for period in periods):
        raise BundleError(f"{claim.name}: actions: they do not say STOP as the claim does, {claim.row['end']!r}")


def _fits(claim: Claim, steps: int, period: int) -> bool:
    """Whether so many steps of so many ticks make up the drive; one in which the agent failed may be cut off."""
    cut_off = period if claim.row["end"] == "failure" else 0
    return 0 <= len(claim.commands) - steps * period <= FIRST_SAMPLES + cut_off


def _ends(end: str, actions: NDArray[np.float32], period: int) -> bool:
    """Whether STOP is said by the last action and by none before; with no time left it may be, and need not."""
    needed, still, first = math.ceil(STOP_TICKS / period), 0, None
    for step, is_still in enumerate(np.all(abs(actions) < STILL, axis=1)):
        still = still + 1 if is_still else 0
        if still == needed:
            first = step
            break
    last = len(actions) - 1
    return first in {"stop": (last,), "time": (None, last), "failure": (None,)}[end]
