"""Runs verify_faults: a robot whose sensors and wheels break on its way, and one whose do not."""

import json
import os
import subprocess
from collections.abc import Iterator
from tempfile import TemporaryDirectory
from typing import Any

from verify.cases.generated import in_generated
from verify.cases.trees import PROGRAMS
from verify.harness import Case

BASE = "3we_base_v2"  # without a lidar
SOON = 2.02  # [s] and the period in which it is noticed


def breakdowns(seed: int, kind: str, drives: int, place: str = "") -> Case:
    """Robots in a generated place, or in one of the named scenes; something breaks for 3 of their 10 seconds."""
    if place:
        return in_generated(seed, breakdowns_in, place, kind=kind, drives=drives)
    return {"drives": answers(kind, seed, drives)}


def breakdowns_in(seed: int, scene: str, kind: str, drives: int) -> Case:
    return {"drives": answers(kind, seed, drives, scene)}


def undisturbed(seed: int, seconds: int) -> Case:
    """A robot on its way from goal to goal, whose sensors are in order."""
    return {"drives": answers("clean", seed, seconds)}


def others_undisturbed(seed: int, seconds: int) -> Case:
    """The same of any robot, noise and randomisation, in bare corridors too."""
    return {"drives": answers("honest", seed, seconds)}


def answers(what: str, seed: int, count: int, *scene: str) -> list[dict[str, Any]]:
    """What the program prints, line by line."""
    command = [PROGRAMS / "verify_faults", what, str(seed), str(count), *scene]
    with TemporaryDirectory() as folder:  # of its own: cases run side by side
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "TMPDIR": folder})
    if done.returncode != 0:
        raise RuntimeError(f"{command} ended with {done.returncode}: {done.stderr}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def drives_of(case: Case) -> Iterator[dict[str, Any]]:
    """Each drive, with what its case is about."""
    for drive in case["drives"]:
        yield {**{key: value for key, value in case.items() if key != "drives"}, **drive}


# which drives a row is about


def has_lidar(drive: dict[str, Any]) -> bool:
    return str(drive["hardware"]) != BASE


def has_none(drive: dict[str, Any]) -> bool:
    """Without a lidar it bumps into what returns no echo, also while nothing is broken."""
    return not has_lidar(drive)


def echo_froze(drive: dict[str, Any]) -> bool:
    """Where nothing returns an echo, a frozen sonar says what a sound one says."""
    return any(f["kind"] == "frozen" and str(f["sensor"]).startswith("ultrasonic") for f in drive["faults"])


def noticed_first(drive: dict[str, Any]) -> bool:
    """Without an alarm before, or a bump, after which gyro and wheels do contradict each other."""
    return drive["alarms_before"] == 0 and float(drive["contact"]) <= 0.05


# what is asked of one drive


def limit(fault: dict[str, Any]) -> float:
    """[s] 250 ms, or two periods and 50 ms where that is longer; and the period in which it is noticed."""
    return max(0.25, 2.0 / float(fault["rate"]) + 0.05) + 0.02


def in_time(drive: dict[str, Any]) -> bool:
    """What broke was noticed within its limit, of moving where it takes that to notice."""
    return all(seconds(fault) <= limit(fault) for fault in drive["faults"])


def in_time_or_harmless(drive: dict[str, Any]) -> bool:
    return in_time(drive) or harmless(drive)


def seconds(fault: dict[str, Any]) -> float:
    noticed = fault["noticed"]
    if noticed is None:
        return float(fault["moved"]) if fault["kind"] == "frozen" and fault["moved"] <= limit(fault) else float("inf")
    return float(fault["moved"] if fault["kind"] == "frozen" else noticed)


def soon(drive: dict[str, Any]) -> bool:
    """Everything was noticed within 2 s."""
    return all(f["noticed"] is not None and f["noticed"] <= SOON for f in drive["faults"])


def soon_or_harmless(drive: dict[str, Any]) -> bool:
    return soon(drive) or harmless(drive)


def soon_or_never_far_off(drive: dict[str, Any]) -> bool:
    return soon(drive) or never_far_off(drive)


def never_far_off(drive: dict[str, Any]) -> bool:
    """It knew where it was to 0.25 m all the way."""
    return float(drive["worst_error"]) <= 0.25


def one_soon_or_harmless(drive: dict[str, Any]) -> bool:
    """The same where two things break: the robot stands still for either."""
    first = noticed_after(drive)
    return harmless(drive) or (first is not None and first <= SOON)


def harmless(drive: dict[str, Any]) -> bool:
    """No contact by the robot's own motion, and it knew where it was to 0.25 m."""
    return untouched(drive) and never_far_off(drive)


def untouched(drive: dict[str, Any]) -> bool:
    """Without contact faster than 0.05 m/s."""
    return float(drive["contact"]) <= 0.05


def named(drive: dict[str, Any]) -> bool:
    """Of what was noticed, the right sensor is named."""
    return all(fault["named"] or fault["noticed"] is None for fault in drive["faults"])


def stood(drive: dict[str, Any]) -> bool:
    """The robot stood still within half a second wherever it may not do without the sensor."""
    return all(
        not fault["needed"] or fault["noticed"] is None or (fault["stopped"] is not None and fault["stopped"] <= 0.5)
        for fault in drive["faults"]
    )


def went_on(drive: dict[str, Any]) -> bool:
    """All sensors are sound again after what broke has been mended, and the robot moves."""
    return drive["recovered"] is not None and bool(drive["went_on"]) and not drive["fault"]


def knows_its_place(drive: dict[str, Any]) -> bool:
    """At the end the robot knows where it is: its map is not ruined."""
    return float(drive["error"]) <= 0.25


def noticed_after(drive: dict[str, Any]) -> float | None:
    """[s] of what was noticed first."""
    times = [float(fault["noticed"]) for fault in drive["faults"] if fault["noticed"] is not None]
    return min(times, default=None)
