"""From the embedded simulator to MuJoCo: motion once calibrated, drives to goals, policies trained on the former."""

import statistics
from collections.abc import Callable

from verify.cases.generated import in_generated
from verify.cases.transfer import OTHER, drive_on_both, motion, policy_on_both
from verify.harness import Case, Experiment, Row, counted_of, each, info, mean_of, share_of, within, worst_of

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
    return info(
        f"{pace}, {figure}: profile, fitted, MuJoCo itself",
        lambda cases: ", ".join(f"{mean(cases, of_motion(pace, profile, figure)):.2%}" for profile in profiles),
    )


def poses_apart(pace: str) -> Row:
    """At the ends, with the fitted profile."""
    return info(f"{pace}, final poses apart", lambda cases: f"{mean(cases, of_motion(pace, 'fitted', 'pose')):.2%}")


def mean(cases: list[Case], value: Callable[[Case], float]) -> float:
    return statistics.fmean(value(case) for case in cases)


def episodes_of(case: Case) -> list[Case]:
    """Each episode of a policy: whether it was won on either physics."""
    return [{"mock": own, OTHER: other} for own, other in zip(case["mock"], case[OTHER], strict=True)]


def apart(name: str, figure: str, at_most: float) -> Row:
    """With the fitted profile, within the operating limits."""
    return mean_of(name, of_motion("operating", "fitted", figure), form="{:.2%}", at_most=at_most)


def of_scene() -> list[Row]:
    """The same drives on both."""
    return [
        share_of("reached on MuJoCo", lambda case: case["arrived"][OTHER] == 1.0, at_least=0.97),
        counted_of(
            "success on MuJoCo over success on mock",
            lambda case: case["arrived"][OTHER],
            lambda case: case["arrived"]["mock"],
            form="{:.3f}",
            at_least=0.98,
        ),
        worst_of("contact on MuJoCo [m/s]", lambda case: case[OTHER]["contact_speed"], at_most=0.05),
    ]


EXPERIMENTS = [
    *(
        Experiment(
            f"motion, {hardware}",
            motion,
            {"hardware": hardware, "sequences": SEQUENCES},
            cases=4,
            rows=[
                apart("linear velocity apart", "linear", at_most=0.05),
                apart("angular velocity apart", "angular", at_most=0.05),
                apart("final poses apart", "pose", at_most=0.03),
                worst_of("the worst of them", of_motion("operating", "fitted", "farthest_pose"), at_most=0.05),
                *(beside_each_other(pace, figure) for pace in PACES for figure in ("linear", "angular", "combined")),
                *(poses_apart(pace) for pace in PACES[1:]),
            ],
        )
        for hardware in ROBOTS
    ),
    Experiment(
        "move_to on both, 3we_standard_v2",
        drive_on_both,
        {"hardware": "3we_standard_v2"},
        variants=[{"scene": scene} for scene in STATIC],
        cases=360,
        rows=[*of_scene(), *(row for claim in of_scene() for row in each("scene", STATIC, lambda _, row=claim: row))],
    ),
    Experiment(
        "move_to on both, 3we_standard_v2 in generated buildings",
        in_generated,
        {"run": drive_on_both, "hardware": "3we_standard_v2"},
        cases=60,
        rows=of_scene(),
    ),
    *(
        Experiment(
            f"policy trained on mock, randomization {randomization}",
            policy_on_both,
            {"randomization": randomization, "training": 1, "episodes": EPISODES},
            rows=[
                within(
                    counted_of(
                        "success by a Robot on MuJoCo over its own on mock",
                        lambda episode: episode[OTHER],
                        lambda episode: episode["mock"],
                        at_least=0.95,
                    ),
                    episodes_of,
                )
            ],
            limit=1800.0,
        )
        for randomization in ("none", "paper")
    ),
]
