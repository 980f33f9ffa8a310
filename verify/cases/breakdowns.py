"""Runs verify_faults: a robot whose sensors and wheels break on its way, and one whose do not."""

import json
import subprocess
from collections.abc import Callable, Iterator
from typing import Any

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Row, Verdict, told, verdict_on_share

AT_ONCE = 50  # of one place


def breakdowns(seed: int, kind: str) -> Case:
    """Fifty robots in one of the scenes; something breaks for 3 of their 10 seconds."""
    return {"drives": answers(kind, seed, AT_ONCE)}


def undisturbed(seed: int, seconds: int) -> Case:
    """A robot on its way from goal to goal, whose sensors are in order."""
    return {"drives": answers("clean", seed, seconds)}


def others_undisturbed(seed: int, seconds: int) -> Case:
    """The same of any robot, noise and randomisation, in bare corridors too."""
    return {"drives": answers("honest", seed, seconds)}


def answers(what: str, seed: int, count: int) -> list[dict[str, Any]]:
    """What the program says, line by line."""
    command = [PROGRAMS / "verify_faults", what, str(seed), str(count)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{command} ended with {done.returncode}: {done.stderr}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def drives(cases: list[Case]) -> Iterator[dict[str, Any]]:
    for case in cases:
        yield from case["drives"]


def share_of_drives(name: str, holds: Callable[[dict[str, Any]], bool], *, at_least: float) -> Row:
    """The share of drives, not of cases, in which something holds."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        if any("error" in case for case in cases):
            return Verdict("cases broke", f">= {at_least:.1%}", "FAIL")
        found = [holds(drive) for drive in drives(cases)]
        return verdict_on_share(sum(found), len(found), at_least, sample)

    return Row(name, judge)


def times_of(name: str, time: Callable[[dict[str, Any]], float | None]) -> Row:
    """How long something took in those drives in which it came about: 50, 95, 99 % and the longest."""

    def figure(cases: list[Case]) -> str:
        times = sorted(t for drive in drives(cases) if (t := time(drive)) is not None)
        if not times:
            return "never"
        shown = [times[min(len(times) - 1, int(share * len(times)))] for share in (0.5, 0.95, 0.99, 1.0)]
        return f"50, 95, 99, 100 %: {', '.join(f'{t:.2f}' for t in shown)} s"

    return told(name, figure)


def alarms_an_hour(at_most: float) -> Row:
    """How often a sensor is said to be in trouble while none is."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        target = f"<= {at_most:g}"
        if any("error" in case for case in cases):
            return Verdict("cases broke", target, "FAIL")
        alarms = sum(len(drive["alarms"]) for drive in drives(cases))
        hours = sum(drive["seconds"] for drive in drives(cases)) / 3600.0
        rate = alarms / hours
        # one alarm in a short sample contradicts nothing
        passed = alarms <= max(1.0, at_most * hours) if sample else rate <= at_most
        return Verdict(f"{alarms} in {hours:.1f} robot hours = {rate:.2f}", target, "pass" if passed else "FAIL")

    return Row("false alarms a robot hour", judge)


# what is asked of one drive


def limit(fault: dict[str, Any]) -> float:
    """[s] 250 ms, or two periods and 50 ms where that is longer; and the period in which it is noticed."""
    return max(0.25, 2.0 / float(fault["rate"]) + 0.05) + 0.02


def in_time(drive: dict[str, Any]) -> bool:
    """What broke was noticed within its limit, of moving where it takes that to notice.

    Where nothing is to be heard, a frozen echo sensor says what a sound one says.
    """

    def silent(fault: dict[str, Any]) -> bool:
        return fault["kind"] == "frozen" and str(fault["sensor"]).startswith("ultrasonic") and harmless(drive)

    return all(seconds(fault) <= limit(fault) or silent(fault) for fault in drive["faults"])


def seconds(fault: dict[str, Any]) -> float:
    noticed = fault["noticed"]
    if noticed is None:
        return float(fault["moved"]) if fault["kind"] == "frozen" and fault["moved"] <= limit(fault) else float("inf")
    return float(fault["moved"] if fault["kind"] == "frozen" else noticed)


def soon_or_harmless(drive: dict[str, Any]) -> bool:
    """Everything was noticed within 2 s, or nothing came of it."""
    return harmless(drive) or all(f["noticed"] is not None and f["noticed"] <= 2.02 for f in drive["faults"])


def one_soon_or_harmless(drive: dict[str, Any]) -> bool:
    """The same where two things break: the robot stands still for either."""
    first = noticed_after(drive)
    return harmless(drive) or (first is not None and first <= 2.02)


def harmless(drive: dict[str, Any]) -> bool:
    """No contact by the robot's own motion, and it knew where it was to 0.25 m."""
    return untouched(drive) and float(drive["worst_error"]) <= 0.25


def untouched(drive: dict[str, Any]) -> bool:
    """Without contact; a robot without a lidar bumps into what it does not hear, with sound sensors too."""
    return float(drive["contact"]) <= 0.05 or str(drive["hardware"]) == "3we_base_v2"


def named(drive: dict[str, Any]) -> bool:
    """Of what was noticed, the right sensor is named, unless there was another reason to notice something: trouble
    before, or a bump, after which gyro and wheels do contradict each other.
    """
    other_reason = drive["alarms_before"] > 0 or float(drive["contact"]) > 0.05
    return other_reason or all(fault["named"] or fault["noticed"] is None for fault in drive["faults"])


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
