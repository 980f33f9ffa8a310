"""Our SLAM in drives through places that the robot has never seen, and a model of its errors.

The model, models::correct_localization, has a map that is turned and stretched about the start, a neighbourhood that
lies off it, and scatter. Which figures describe the measured errors best is found here.
"""

import itertools
import subprocess
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verify.cases.trees import PROGRAMS, ROOT
from verify.harness import Case, Row, info, share_within, whole_of, within

PROGRAM = PROGRAMS / "verify_slam"
MODEL = "slam_v2"
SCENES = ["office_v2", "corridor_v1", "apartment_v1", "warehouse_v1", "cluttered_v1", "outdoor_v1", "dynamic_v1"]
Array = NDArray[np.float64]


def drives(seed: int, scene: str) -> Case:
    """One drive to learn from, and another to check what was learned."""
    return {"drives": [drive(scene, seed + held, held == 1) for held in (0, 1)]}


def drive(scene: str, seed: int, held_out: bool) -> dict[str, Any]:
    """To three sampled goals, noise on. `track` has a line for each correction, as verify_slam tells it."""
    output = subprocess.run([PROGRAM, "drive", scene, str(seed)], capture_output=True, text=True, check=True).stdout
    lines = output.splitlines()
    track = [[float(word) for word in line.split()] for line in lines if not line.startswith("#")]
    times, delays, lost = np.array(track).T[:3]
    return {
        "scene": scene,
        "seed": seed,
        "held_out": held_out,
        "ends": [line[2:] for line in lines if line.startswith("#")],
        "lost": int(lost.sum()),
        "period": float(np.diff(times).max()),
        "delay": float(delays.max()),
        "track": track,
    }


# what the rows say


def drives_of(case: Case) -> list[Case]:
    return list(case["drives"])


def of_drives(row: Row) -> Row:
    """The row, about drives instead of cases."""
    return within(row, drives_of)


def close_all_the_way(drive: Case) -> bool:
    """Never more than 0.10 m off."""
    return bool(position_errors([Track(drive)]).max() <= 0.10)


def close(position: float, heading: float) -> Row:
    """The share of drives of whose corrections 95 % are at most so far off [m, rad]."""

    def holds(drive: Case) -> bool:
        track = Track(drive)
        off = np.quantile(position_errors([track]), 0.95)
        turned = np.quantile(np.abs(track.error[:, 2]), 0.95)
        return bool(off <= position and turned <= heading)

    name = f"drives of which 95 % of corrections are within {1e3 * position:.0f} mm and {1e3 * heading:.0f} mrad"
    return share_within(name, drives_of, holds, at_least=0.95)


def errors_of_all() -> Row:
    """Of all corrections."""

    def figure(drives: list[Case]) -> str:
        tracks = [Track(drive) for drive in drives]
        off = position_errors(tracks)
        turned = np.abs(np.concatenate([track.error[:, 2] for track in tracks]))
        return (
            f"rmse {1e3 * rms(off):.1f} mm, {1e3 * rms(turned):.1f} mrad; 95 % {1e3 * np.quantile(off, 0.95):.1f} mm, "
            f"{1e3 * np.quantile(turned, 0.95):.1f} mrad; worst {1e3 * off.max():.0f} mm, {1e3 * turned.max():.1f} mrad"
        )

    return of_drives(info("errors of corrections", figure))


def agrees(model: str, *, spread: float, correlation: float) -> Iterator[Row]:
    """The model against drives that it was not made from: quantiles of errors within a share, their correlation over
    time within a difference.
    """

    known: dict[tuple[str, int], Track] = {}

    def imitated(track: Track) -> Track:
        key = (track.scene, track.seed)
        if key not in known:
            known[key] = imitation(model, track)
        return known[key]

    def compare(
        name: str, unit: str, figures: Callable[[list[Track]], Array], distance: Callable[[Array, Array], Array]
    ) -> Row:
        tolerance = spread if unit else correlation

        def judge(drives: list[Case]) -> tuple[str, str, bool]:
            measured = [Track(drive) for drive in drives if drive["held_out"]]
            modelled = [imitated(track) for track in measured]
            ours, theirs = figures(modelled), figures(measured)
            figure = f"{listed(ours, unit)}; measured {listed(theirs, unit)}{' ' + unit if unit else ''}"
            target = f"within {tolerance:.0%}" if unit else f"within {tolerance:g}"
            return figure, target, bool(np.all(distance(ours, theirs) <= tolerance))

        return of_drives(whole_of(f"{model} on other drives: {name}", judge))

    def ratio(ours: Array, theirs: Array) -> Array:
        return np.maximum(ours / theirs, theirs / ours) - 1.0

    def difference(ours: Array, theirs: Array) -> Array:
        return np.abs(ours - theirs)

    shares = [0.5, 0.8, 0.95]
    yield compare("position, 50, 80, 95 %", "mm", lambda t: 1e3 * np.quantile(position_errors(t), shares), ratio)
    for axis, name in enumerate(("along", "across", "heading")):
        unit = "mrad" if name == "heading" else "mm"
        yield compare(f"{name}, 50, 80, 95 %", unit, lambda t, k=axis: 1e3 * quantiles(t, k, shares), ratio)
        yield compare(f"{name}, correlation over 0.1, 1, 5, 10 s", "", lambda t, k=axis: correlations(t, k), difference)


def listed(figures: Array, unit: str) -> str:
    return ", ".join(f"{figure:.1f}" if unit else f"{figure:.3f}" for figure in figures)


# what was measured


class Track:
    """One drive: at each correction what is true and what is believed."""

    def __init__(self, drive: Case) -> None:
        """From a case's drive."""
        self.scene: str = drive["scene"]
        self.seed: int = drive["seed"]
        self.held_out: bool = drive["held_out"]
        self.lines = np.array(drive["track"], dtype=np.float64)
        self.seconds = float(self.lines[-1, 0] - self.lines[0, 0])
        self.place = self.lines[:, 3:5]  # [m] in `map`
        off = self.lines[:, 6:9] - self.lines[:, 3:6]
        off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
        self.off = off  # [m, m, rad] in `map`
        cos, sin = np.cos(self.lines[:, 5]), np.sin(self.lines[:, 5])
        # along, across and heading: as the robot has it
        self.error = np.c_[cos * off[:, 0] + sin * off[:, 1], cos * off[:, 1] - sin * off[:, 0], off[:, 2]]
        steps = np.linalg.norm(np.diff(self.place, axis=0, prepend=[[0.0, 0.0]]), axis=1)
        self.driven = np.cumsum(steps)  # [m]


def tracks_of(cases: list[Case]) -> list[Track]:
    return [Track(drive) for case in cases for drive in case["drives"]]


def imitation(model: str, track: Track) -> Track:
    """The same drive of a robot with the model's localisation."""
    lines = "\n".join(
        " ".join(f"{number:.6f}" if i != 2 else "0" for i, number in enumerate(line)) for line in track.lines
    )
    command = [PROGRAM, "model", model, str(track.seed)]
    output = subprocess.run(command, input=lines, capture_output=True, text=True, check=True).stdout
    believed = [[float(word) for word in line.split()] for line in output.splitlines()]
    return Track({"scene": track.scene, "seed": track.seed, "held_out": track.held_out, "track": believed})


def position_errors(tracks: list[Track]) -> Array:
    return np.linalg.norm(np.concatenate([track.off[:, :2] for track in tracks]), axis=1)


def quantiles(tracks: list[Track], axis: int, shares: list[float]) -> Array:
    return np.quantile(np.abs(np.concatenate([track.error[:, axis] for track in tracks])), shares)


def correlations(tracks: list[Track], axis: int) -> Array:
    """Of an error with itself after 1, 10, 50 and 100 corrections; about zero, where errors begin."""
    everything = np.concatenate([track.error[:, axis] for track in tracks])
    found = []
    for lag in (1, 10, 50, 100):
        products = [track.error[:-lag, axis] * track.error[lag:, axis] for track in tracks if len(track.error) > lag]
        found.append(np.concatenate(products).mean() / np.square(everything).mean())
    return np.array(found)


def rms(values: Array) -> float:
    return float(np.sqrt(np.square(values).mean()))


# the model


def write_model(cases: list[Case], commit: str, seed: int) -> None:
    """Fits the model to the drives that are not held out, and writes its file."""
    if any("error" in case for case in cases):
        raise RuntimeError("some cases broke: a model is made from all of them or not at all")
    everything = tracks_of(cases)
    tracks = [track for track in everything if not track.held_out]
    fitted = fit(tracks)
    turn, stretch, heading, local, scatter, scatter_heading = fitted["deviations"]
    period = np.median(np.concatenate([np.diff(track.lines[:, 0]) for track in tracks]))
    delay = np.median(np.concatenate([track.lines[:, 1] for track in tracks]))
    file = ROOT / f"assets/localization/{MODEL}.yaml"
    file.parent.mkdir(exist_ok=True)
    file.write_text(
        f"""\
# How far our own SLAM is off: written by ./dev verify slam --write-model, not by hand. SI units: m, rad, s.
description: Our own SLAM, in places that the robot has never seen
period: {period:.3g}  # between corrections
delay: {delay:.2g}  # from the end of a scan to its correction; what comes of it is part of the errors
# standard deviations; what is slow has fallen to 1/e after `length` driven
map: {{turn: {turn:.3g}, stretch: {stretch:.3g}, heading: {heading:.3g}, length: {fitted["map_length"]:.3g}}}
local: {{position: {local:.3g}, length: {fitted["local_length"]:.3g}}}
noise: {{position: {scatter:.3g}, heading: {scatter_heading:.3g}}}
measured:
  commit: "{commit}"
  seed: {seed}
  hardware: 3we_standard_v2
  noise: realistic
  scenes: [{", ".join(SCENES)}]
  episodes: {len(tracks)}  # and as many others to check with
  hours: {sum(track.seconds for track in tracks) / 3600.0:.2f}
  kilometres: {sum(track.driven[-1] for track in tracks) / 1000.0:.2f}
"""
    )
    print(f"wrote {file}", flush=True)


# What is slower than the longest drives (60 m) cannot be told from a random walk, which would go on growing where
# nothing was measured; hence the bound.
MAP_LENGTHS = (15.0, 20.0, 30.0, 40.0, 60.0)  # [m]
LOCAL_LENGTHS = (0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0)  # [m]
LEVEL_COUNTS = 3.0  # how much more errors themselves count than their changes


def fit(tracks: list[Track]) -> dict[str, Any]:
    """The figures whose mean squares are nearest to the measured ones: of errors at each distance from the start, and
    of how much they change over each time. With given lengths all of them are sums of six variances.
    """
    groups = list(groups_of(tracks))
    best: dict[str, Any] = {"deviance": np.inf}
    for map_length, local_length in itertools.product(MAP_LENGTHS, LOCAL_LENGTHS):
        equations = [equation for group in groups for equation in group.equations(map_length, local_length)]
        variances, deviance = explain(*(np.array(part) for part in zip(*equations, strict=True)))
        if deviance < best["deviance"]:
            best = {
                "deviance": deviance,
                "map_length": map_length,
                "local_length": local_length,
                "deviations": np.sqrt(variances),
            }
    return best


class Group:
    """Corrections some time apart, the first of each pair at about the same distance from the start."""

    def __init__(self, lag: int, pairs: Array) -> None:
        """Columns: driven at both, distance from the start at both, product of both places, mean squares."""
        self.lag = lag
        self.before, self.after, self.r1, self.r2, self.r12 = pairs.T[:5]
        self.squares = pairs[:, 5:].mean(axis=0)

    def equations(self, map_length: float, local_length: float) -> Iterator[tuple[list[float], float, float]]:
        """What the variances of turn, stretch, heading, local position and scatter add to each mean square; the mean
        square as measured; how much it counts.
        """

        def covariance(length: float, d1: Array, d2: Array) -> Array:
            return np.exp(-np.abs(d1 - d2) / length) - np.exp(-(d1 + d2) / length)

        d1, d2 = self.before, self.after
        here, near = covariance(map_length, d1, d1), covariance(local_length, d1, d1)
        if self.lag == 0:
            lever, angle, local = (here * self.r1**2).mean(), here.mean(), near.mean()
            yield [lever, 0.0, 0.0, local, 1.0, 0.0], self.squares[0], LEVEL_COUNTS  # to the side, seen from the start
            yield [0.0, lever, 0.0, local, 1.0, 0.0], self.squares[1], LEVEL_COUNTS  # away from it
            yield [angle, 0.0, angle, 0.0, 0.0, 1.0], self.squares[2], LEVEL_COUNTS  # heading
            return
        there, both = covariance(map_length, d2, d2), covariance(map_length, d1, d2)
        lever = (here * self.r1**2 + there * self.r2**2 - 2.0 * both * self.r12).mean()
        angle = (here + there - 2.0 * both).mean()
        change = near + covariance(local_length, d2, d2) - 2.0 * covariance(local_length, d1, d2)
        yield [lever, lever, 0.0, 2.0 * change.mean(), 4.0, 0.0], self.squares[3], 1.0  # how far it moved
        yield [angle, 0.0, angle, 0.0, 0.0, 2.0], self.squares[4], 1.0  # how far it turned


def groups_of(tracks: list[Track]) -> Iterator[Group]:
    """Each time apart and each distance from the start, where there is enough of it."""
    edges = [0.0, 1.0, 3.0, 6.0, 10.0, np.inf]
    for lag in (0, 1, 10, 100):
        parts = []
        for track in tracks:
            i = np.arange(0, len(track.place) - lag, 10)
            j = i + lag
            r = np.linalg.norm(track.place, axis=1)
            away = track.place / np.maximum(r, 1e-9)[:, None]
            sideways = away[i, 0] * track.off[i, 1] - away[i, 1] * track.off[i, 0]
            radial = (away[i] * track.off[i, :2]).sum(axis=1)
            changed = track.off[j] - track.off[i]
            product = (track.place[i] * track.place[j]).sum(axis=1)
            moved = np.square(changed[:, :2]).sum(axis=1)
            squares = [sideways**2, radial**2, track.off[i, 2] ** 2, moved, changed[:, 2] ** 2]
            parts.append(np.column_stack([track.driven[i], track.driven[j], r[i], r[j], product, *squares]))
        pairs = np.concatenate(parts)
        for low, high in itertools.pairwise(edges):
            within = (pairs[:, 2] >= low) & (pairs[:, 2] < high)
            if within.sum() >= 50:
                yield Group(lag, pairs[within])


def explain(factors: Array, measured: Array, counts: Array) -> tuple[Array, float]:
    """Variances, none negative, whose sums are as likely as can be if each mean square scatters in proportion to its
    size (the quasi-likelihood of a gamma distribution); and how far from perfect that is.
    """
    expected = measured
    for _ in range(12):
        weights = np.sqrt(counts) / expected
        variances = least_squares(factors * weights[:, None], measured * weights)
        expected = factors @ variances
    deviance = counts * (np.log(expected / measured) + measured / expected - 1.0)
    return variances, float(deviance.sum() / counts.sum())


def least_squares(factors: Array, wanted: Array) -> Array:
    """The best of all solutions without negative parts: every choice of parts that are zero is tried."""
    normal, right = factors.T @ factors, factors.T @ wanted
    count = len(right)
    best, least = np.full(count, 1e-12), np.inf
    for chosen in itertools.product((False, True), repeat=count):
        part = np.array(chosen)
        if not part.any() or np.linalg.matrix_rank(normal[np.ix_(part, part)]) < part.sum():
            continue
        solution = np.full(count, 1e-12)  # not zero: an expectation of zero could not be compared
        solution[part] = np.linalg.solve(normal[np.ix_(part, part)], right[part])
        residual = float(solution @ normal @ solution - 2.0 * right @ solution)
        if (solution > 0.0).all() and residual < least:
            best, least = solution, residual
    return best
