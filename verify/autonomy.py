"""The autonomy stack in places that nobody tuned to: buildings, mazes, like corridors, and robots of other sizes.

Navigation has the rows of single behaviours and of the named scenes, slam those of localisation.
"""

from collections.abc import Callable

from verify.cases.driving import arrived, contact, explore, spl_of, truly_there
from verify.cases.generated import drive_far, ends_standing, in_generated, no_clock
from verify.cases.labyrinths import PLACES, mislead
from verify.cases.scaled import drive_in_sizes
from verify.harness import (
    Case,
    Experiment,
    Row,
    all_of,
    each,
    info,
    mean_of,
    ratio_of,
    share_of,
    where,
    within,
    worst_of,
)

ARRIVED = "reached, truly within 0.25 m"
STANDARD, TURTLEBOT = "3we_standard_v2", "turtlebot_like"
ROBOTS = [STANDARD, TURTLEBOT]
SCALES = [0.5, 1.0, 3.0]


def no_contact() -> Row:
    return worst_of("contact by its own motion [m/s]", contact, at_most=0.05)


def times_the_baseline(case: Case) -> float:
    return float(case["seconds"] / case["reference_seconds"])


def drives_of(case: Case) -> list[Case]:
    drives: list[Case] = case["drives"]
    return drives


def lags(scale: float) -> Callable[[Case], float]:
    """How much less a robot of another size arrives than the original."""

    def difference(case: Case) -> float:
        by_scale = {drive["scale"]: arrived(drive) for drive in drives_of(case)}
        return float(by_scale[1.0]) - float(by_scale[scale])

    return difference


def success_by_size(cases: list[Case]) -> str:
    drives = [drive for case in cases for drive in drives_of(case)]
    shares = [[arrived(drive) for drive in drives if drive["scale"] == scale] for scale in SCALES]
    return ", ".join(f"x{scale:g}: {sum(share)}/{len(share)}" for scale, share in zip(SCALES, shares, strict=True))


EXPERIMENTS = [
    *(
        Experiment(
            f"far goals, {hardware}, {how}, in generated buildings",
            in_generated,
            {"run": drive_far, "hardware": hardware, "randomization": randomization},
            cases=300,
            sample=sample,
            rows=[
                share_of(ARRIVED, arrived, at_least=enough),
                all_of("never reached, unless it truly is there", truly_there),
                all_of("ends by no clock, and standing", lambda case: no_clock(case) and ends_standing(case)),
                ratio_of(
                    "SPL over the optimistic replanner's", spl_of, lambda case: case["optimist_spl"], at_least=0.97
                ),
                no_contact(),
            ],
            limit=3600.0,
        )
        for hardware, randomization, how, enough, sample in [
            (STANDARD, "none", "plain", 0.98, 12),
            (TURTLEBOT, "none", "plain", 0.97, 8),
            (STANDARD, "hard", "hard", 0.95, 6),
            (TURTLEBOT, "hard", "hard", 0.95, 6),
        ]
    ),
    Experiment(
        "explore generated buildings until it is done",
        in_generated,
        {"run": explore, "times": None},
        cases=50,
        sample=5,
        rows=[
            mean_of("mean coverage", lambda case: case["coverage"], at_least=0.97),
            worst_of("coverage", lambda case: case["coverage"], at_least=0.95),
            mean_of("time over nearest-frontier's", times_the_baseline, at_most=1.1),
            no_contact(),
        ],
    ),
    Experiment(
        "places made to mislead",
        mislead,
        variants=[{"place": place, "hardware": hardware} for place in PLACES for hardware in ROBOTS],
        cases=160,
        sample=8,
        rows=[
            all_of("never reached, unless it truly is there", truly_there),
            share_of(
                "reached, or says how unsure it is",
                lambda case: case["reason"] in ("reached", "uncertain"),
                at_least=0.97,
            ),
            no_contact(),
            where(
                mean_of("a narrow door [s]", lambda case: case["seconds_a_door"], at_most=15.0),
                lambda case: case["place"] == "doors",
            ),
            *each("place", PLACES, lambda _: share_of(ARRIVED, arrived, at_least=0.9)),
        ],
    ),
    Experiment(
        "robots of other sizes in buildings scaled alike",
        drive_in_sizes,
        {"scales": SCALES},
        variants=[{"hardware": hardware} for hardware in ROBOTS],
        cases=200,
        sample=4,
        rows=[
            *(
                mean_of(f"arrives less often than the original, x{scale:g}", lags(scale), form="{:.1%}", at_most=0.02)
                for scale in SCALES
                if scale != 1.0
            ),
            info("reached, truly within 0.25 m", success_by_size),
            within(all_of("never reached, unless it truly is there", truly_there), drives_of),
            within(no_contact(), drives_of),
            *each("hardware", ROBOTS, lambda _: info(ARRIVED, success_by_size)),
        ],
        limit=3600.0,
    ),
]
