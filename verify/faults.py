"""Breaks sensors and wheels of robots on their way: what is noticed, how soon, and what comes of it."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from verify.cases.breakdowns import (
    breakdowns,
    drives_of,
    echo_froze,
    harmless,
    has_lidar,
    has_none,
    in_time,
    in_time_or_harmless,
    knows_its_place,
    named,
    never_far_off,
    noticed_after,
    noticed_first,
    one_soon_or_harmless,
    others_undisturbed,
    soon_or_harmless,
    soon_or_never_far_off,
    stood,
    undisturbed,
    untouched,
    went_on,
)
from verify.harness import Case, Experiment, Row, each, info, known_miss, rate_of, share_within, where, within

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
Drive = dict[str, Any]

IN_TIME = "noticed within 250 ms or two periods + 50 ms"
SONARS = f"sonars that freeze: {IN_TIME}, or harmless"
UNTOUCHED = "with a lidar, without contact above 0.05 m/s"


def of_drives(
    name: str, holds: Callable[[Drive], bool], enough: float, about: Callable[[Drive], bool] | None = None
) -> Row:
    """The share of drives, or of some of them, in which something holds."""
    return share_within(name, lambda case: filter(about, drives_of(case)), holds, at_least=enough)


def times_of(name: str, time: Callable[[Drive], float | None]) -> Row:
    """How long something took in those drives in which it came about: 50, 95, 99 % and the longest."""

    def figure(drives: list[Case]) -> str:
        times = sorted(t for drive in drives if (t := time(drive)) is not None)
        if not times:
            return "never"
        shown = [times[min(len(times) - 1, int(share * len(times)))] for share in (0.5, 0.95, 0.99, 1.0)]
        return f"50, 95, 99, 100 %: {', '.join(f'{t:.2f}' for t in shown)} s"

    return within(info(name, figure), drives_of)


def always(knowing: float) -> list[Row]:
    """What is asked whatever breaks; `knowing`: of so many drives at least."""
    return [
        of_drives(UNTOUCHED, untouched, 1.0, has_lidar),
        of_drives("no command but finite ones", lambda drive: bool(drive["finite"]), 1.0),
        of_drives("knows its place to 0.25 m at the end", knows_its_place, knowing),
        of_drives("sensors ok again, and moving", went_on, 0.95),
        times_of("noticed after", noticed_after),
    ]


def noticed_in_time(kind: str) -> Row:
    """What has frozen may be noticed late in one drive of a thousand."""
    return of_drives(IN_TIME, in_time, 0.999 if kind == "frozen" else 1.0, lambda drive: not echo_froze(drive))


def plain(sonars: float | None) -> Iterator[Row]:
    """What is asked where something breaks that shows at once; `sonars`: the known share of those that freeze."""
    yield noticed_in_time("frozen")
    yield known_miss(
        of_drives(SONARS, in_time_or_harmless, 1.0, echo_froze),
        sonars,
        "frozen at no return it is like one that measures none; a robot without a lidar touches what it then misses",
    )


def subtle() -> Iterator[Row]:
    """What is asked where something breaks that shows by and by."""
    yield of_drives("with a lidar, noticed within 2 s, or harmless", soon_or_harmless, 1.0, has_lidar)
    yield of_drives(
        "without one, noticed within 2 s, or its place known to 0.25 m", soon_or_never_far_off, 1.0, has_none
    )
    yield times_of("sensors ok again after", lambda drive: drive["recovered"])


def common() -> list[Row]:
    """What is asked where one thing breaks."""
    return [
        of_drives("without an alarm or a bump before: the right sensor is named", named, 1.0, noticed_first),
        of_drives("stands still within 0.5 s of noticing", stood, 0.99),
        of_drives("with a lidar, harmless", harmless, 0.95, has_lidar),
        of_drives("without one, knows its place to 0.25 m all the way", never_far_off, 0.95, has_none),
        where(
            within(
                info("without one, no contact", lambda drives: f"{sum(map(untouched, drives))}/{len(drives)}"),
                drives_of,
            ),
            has_none,
        ),
        *always(0.995),
    ]


def of_each(kinds: Sequence[str], rows: list[Row]) -> Iterator[Row]:
    """The rows of each kind."""
    for row in rows:
        about = ["frozen"] if row.name == SONARS else kinds
        yield from each("kind", about, lambda kind, row=row: noticed_in_time(kind) if row.name == IN_TIME else row)


def single(where_: str, place: str, cases: int, sonars: float | None = None) -> list[Experiment]:
    """One thing breaks, in places of one sort."""
    return [
        Experiment(
            f"{name} faults in {where_}",
            breakdowns,
            {"drives": 5, "place": place},
            variants=[{"kind": kind} for kind in kinds],
            cases=cases * len(kinds),
            rows=[*rows, *(of_each(kinds, rows) if place else [])],
        )
        for name, kinds, rows in (
            ("plain", PLAIN, [*plain(sonars), *common()]),
            ("subtle", SUBTLE, [*subtle(), *common()]),
        )
    ]


EXPERIMENTS = [
    *single("generated buildings", "building", 60, sonars=22 / 23),
    *single("named scenes", "", 20),
    Experiment(
        "two faults at once in generated buildings",
        breakdowns,
        {"drives": 5, "place": "building", "kind": "pair"},
        cases=100,
        rows=[
            of_drives("with a lidar, one is noticed within 2 s, or harmless", one_soon_or_harmless, 1.0, has_lidar),
            *always(0.95),
        ],
    ),
    *(
        Experiment(
            name,
            run,
            {"seconds": seconds},
            cases=cases,
            rows=[
                within(
                    rate_of(
                        "false alarms a robot hour",
                        lambda drive: len(drive["alarms"]),
                        lambda drive: drive["seconds"] / 3600.0,
                        at_most=1.0,
                    ),
                    drives_of,
                )
            ],
        )
        for name, run, seconds, cases in [
            ("nothing breaks, on all robots", others_undisturbed, 300, 72),
            ("nothing breaks", undisturbed, 1200, 24),
        ]
    ),
]
