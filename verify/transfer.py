"""From the embedded simulator to MuJoCo: motion once calibrated, drives to goals, policies trained on the former."""

import math
import statistics
from collections.abc import Callable

from verify.cases.transfer import OTHER, drive_on_both, motion, policy_on_both
from verify.harness import (
    Case,
    Experiment,
    Row,
    Verdict,
    mean_share,
    ratio_of,
    share_of,
    told,
    wilson,
    worst_of,
)

STATIC = ["office_v2", "apartment_v1", "corridor_v1", "warehouse_v1", "cluttered_v1", "outdoor_v1"]
ROBOTS = ["3we_standard_v2", "turtlebot_like"]
PACES = ["operating", "hardware", "abrupt"]
SEQUENCES = 25  # of each case of motion
EPISODES = 60  # of each policy


def of_motion(pace: str, profile: str, figure: str) -> Callable[[Case], float]:
    """One figure of a case of motion."""
    return lambda case: float(case[pace][profile][figure])


def beside_each_other(pace: str, figure: str) -> Row:
    """With the profile as it is, with the fitted one, and of MuJoCo against itself."""
    profiles = ("plain", "fitted", "itself")
    return told(
        f"{pace}, {figure}: profile, fitted, MuJoCo itself",
        lambda cases: ", ".join(f"{mean(cases, of_motion(pace, profile, figure)):.2%}" for profile in profiles),
    )


def poses_apart(pace: str) -> Row:
    """At the ends, with the fitted profile."""
    return told(f"{pace}, final poses apart", lambda cases: f"{mean(cases, of_motion(pace, 'fitted', 'pose')):.2%}")


def mean(cases: list[Case], value: Callable[[Case], float]) -> float:
    return statistics.fmean(value(case) for case in cases)


def policy_ratio(cases: list[Case], _: bool) -> Verdict:
    """The success of a policy on MuJoCo over its own, with the interval of paired episodes."""
    if any("error" in case for case in cases):
        return Verdict("cases broke", ">= 0.95", "FAIL")
    own = [won for case in cases for won in case["mock"]]
    other = [won for case in cases for won in case[OTHER]]
    ratio = statistics.fmean(other) / statistics.fmean(own)
    misfit = statistics.stdev(b - ratio * a for a, b in zip(own, other, strict=True))
    spread = 1.96 * misfit / (statistics.fmean(own) * math.sqrt(len(own)))
    low, high = wilson(int(sum(other)), len(other))
    figure = f"{sum(other):.0f}/{len(other)} [{low:.1%}, {high:.1%}] of {sum(own):.0f}/{len(own)} = {ratio:.3f}"
    status = "pass" if ratio >= 0.95 else "FAIL"
    return Verdict(figure, ">= 0.95", status, f"[{ratio - spread:.3f}, {ratio + spread:.3f}]")


EXPERIMENTS = [
    *(
        Experiment(
            f"motion, {hardware}",
            motion,
            {"hardware": hardware, "sequences": SEQUENCES},
            cases=4,
            sample=1 if hardware == "turtlebot_like" else 0,
            rows=[
                mean_share("linear velocity apart", of_motion("operating", "fitted", "linear"), at_most=0.05),
                mean_share("angular velocity apart", of_motion("operating", "fitted", "angular"), at_most=0.05),
                mean_share("final poses apart", of_motion("operating", "fitted", "pose"), at_most=0.03),
                worst_of("the worst of them", of_motion("operating", "fitted", "farthest_pose"), at_most=0.05),
                *(beside_each_other(pace, figure) for pace in PACES for figure in ("linear", "angular", "combined")),
                *(poses_apart(pace) for pace in PACES[1:]),
            ],
        )
        for hardware in ROBOTS
    ),
    *(
        Experiment(
            f"move_to on both, 3we_standard_v2 in {scene}",
            drive_on_both,
            {"scene": scene, "hardware": "3we_standard_v2"},
            cases=60,
            sample=2 if scene == "apartment_v1" else 0,
            rows=[
                share_of("reached on MuJoCo", lambda case: case["arrived"][OTHER] == 1.0, at_least=0.97),
                ratio_of(
                    "success on MuJoCo over success on mock",
                    lambda case: case["arrived"][OTHER],
                    lambda case: case["arrived"]["mock"],
                    at_least=0.98,
                ),
                worst_of("contact on MuJoCo [m/s]", lambda case: case[OTHER]["contact_speed"], at_most=0.05),
            ],
        )
        for scene in STATIC
    ),
    *(
        Experiment(
            f"policy trained on mock, randomization {randomization}",
            policy_on_both,
            {"randomization": randomization, "training": 1, "episodes": EPISODES},
            sample=0,
            rows=[Row("success by a Robot on MuJoCo over its own on mock", policy_ratio)],
            limit=1800.0,
        )
        for randomization in ("none", "paper")
    ),
]
