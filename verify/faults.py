"""Breaks sensors and wheels of robots on their way: what is noticed, how soon, and what comes of it."""

from verify.cases.breakdowns import (
    alarms_an_hour,
    breakdowns,
    harmless,
    in_time,
    knows_its_place,
    named,
    noticed_after,
    one_soon_or_harmless,
    others_undisturbed,
    share_of_drives,
    soon_or_harmless,
    stood,
    times_of,
    undisturbed,
    untouched,
    went_on,
)
from verify.harness import Experiment, Row

PLAIN = ("silent", "frozen", "nan", "stamps_back", "stamps_ahead")
SUBTLE = (
    "noise",
    "lidar_bias",
    "gyro_bias",
    "delay",
    "delay_restamped",
    "dropout",
    "covered",
    "slip",
    "wheel_slip",
    "wheel_blocked",
)

RARELY = ("frozen", "delay_restamped")
"""One drive of a thousand notices late what has frozen, or touches something that its lidar shows half a second late
with a stamp that says otherwise: no claim for a sample."""


def always(*, knowing: float) -> list[Row]:
    """What is asked whatever breaks; `knowing`: of so many drives at least."""
    return [
        share_of_drives("without contact above 0.05 m/s, with a lidar", untouched, at_least=1.0),
        share_of_drives("no command but finite ones", lambda drive: bool(drive["finite"]), at_least=1.0),
        share_of_drives("knows its place to 0.25 m at the end", knows_its_place, at_least=knowing),
        share_of_drives("sensors sound again, and moving", went_on, at_least=0.95),
        times_of("noticed after", noticed_after),
    ]


def rows(kind: str) -> list[Row]:
    """What is asked where one thing breaks."""
    if kind in PLAIN:
        orelse = "; echoes that freeze: or harmless" if kind == "frozen" else ""
        first = [share_of_drives("noticed within 250 ms or two periods + 50 ms" + orelse, in_time, at_least=1.0)]
    else:
        first = [
            share_of_drives("noticed within 2 s, or harmless", soon_or_harmless, at_least=1.0),
            times_of("back in order after", lambda drive: drive["recovered"]),
        ]
    return [
        *first,
        share_of_drives("the right sensor is named", named, at_least=1.0),
        share_of_drives("stands still within 0.5 s of noticing", stood, at_least=0.99),
        share_of_drives("harmless", harmless, at_least=0.95),
        *always(knowing=0.995),
    ]


EXPERIMENTS = [
    *(
        Experiment(kind, breakdowns, {"kind": kind}, cases=20, sample=int(kind not in RARELY), rows=rows(kind))
        for kind in PLAIN + SUBTLE
    ),
    Experiment(
        "two at once",
        breakdowns,
        {"kind": "pair"},
        cases=40,
        sample=0,
        rows=[
            share_of_drives("one of them noticed within 2 s, or harmless", one_soon_or_harmless, at_least=1.0),
            *always(knowing=0.95),
        ],
    ),
    Experiment(
        "nothing breaks, on all robots",
        others_undisturbed,
        {"seconds": 300},
        cases=200,
        sample=2,
        rows=[alarms_an_hour(1.0)],
    ),
    Experiment("nothing breaks", undisturbed, {"seconds": 1200}, cases=60, sample=1, rows=[alarms_an_hour(1.0)]),
]
