"""How well our SLAM localises in places it has never seen and in given maps, maps logs, and is like its model."""

from verify.cases.generated import in_generated
from verify.cases.given_maps import (
    claims_the_truth,
    consistent,
    finds_itself,
    is_relocalized,
    notices,
    of_placements,
    of_those_carried,
    placements,
    time_to_be_back,
)
from verify.cases.localization import (
    MODEL,
    SCENES,
    agrees,
    close,
    close_all_the_way,
    drives,
    drives_of,
    errors_of_all,
    of_drives,
    write_model,
)
from verify.cases.logs import SURVEYS, TOURS, closed, mapped, spoiled
from verify.cases.trajectories import errors_row, kept_track, trajectory_rows
from verify.harness import Case, Experiment, Row, all_of, each, info, share_within, time_of, worst_of


def localising() -> list[Row]:
    """What is asked of drives in places that the robot has never seen."""
    return [
        close(position=0.10, heading=0.010),
        errors_of_all(),
        share_within("drives within 0.10 m from beginning to end", drives_of, close_all_the_way, at_least=0.95),
        of_drives(all_of("never lost", lambda drive: drive["lost"] == 0)),
        of_drives(worst_of("between corrections [s]", lambda drive: drive["period"], at_most=0.1001)),
        of_drives(worst_of("from a scan's end to its correction [s]", lambda drive: drive["delay"], at_most=0.021)),
    ]


def tracking(consistent: float | None = None) -> list[Row]:
    """What is asked of ten minutes; `consistent`: the share that is known to be, see `trajectory_rows`."""
    return [
        *trajectory_rows(consistent),
        errors_row(),
        all_of("never lost", lambda case: case["lost"] == 0),
        time_of("CPU of a robot minute [s]", lambda case: case["cpu"] / 10.0, at_most=6.0),
        time_of("CPU of a tick, 99 % of them [ms]", lambda case: case["tick"], at_most=4.0),
    ]


def in_own_maps() -> list[Row]:
    """What is asked of robots that are put into a map, and carried away."""
    return [
        of_placements("finds itself within 10 s, standing", finds_itself, 0.95),
        of_placements("never claims a pose that is 0.3 m off", claims_the_truth, 1.0),
        of_those_carried("relocalized within 10 s after it was carried away", is_relocalized, 0.98),
        of_those_carried("relocalized within 3 s", lambda placement: time_to_be_back(placement) <= 3.0, 0.5),
        of_those_carried("notices within 5 s that it was carried away", notices, 0.95),
    ]


def is_named_or_good(case: Case) -> bool:
    """Its relations are about as good as those of the log that was spoiled, or an incident says what is wrong."""
    return bool(case["events"] or case["translation"] <= 4.0 * case["plain"] + 0.05)


def error_beside_the_plain(cases: list[Case]) -> str:
    spoiled, plain = (sum(case[name] for case in cases) / len(cases) for name in ("translation", "plain"))
    return f"{1e3 * spoiled:.0f} mm, of the logs as they were {1e3 * plain:.0f} mm"


HELD_OUT = [
    Experiment("localising in generated buildings", in_generated, {"run": drives}, cases=100, rows=localising()),
    Experiment(
        "ten minutes in generated buildings",
        in_generated,
        {"run": kept_track},
        variants=[{"randomization": randomization} for randomization in ("none", "hard")],
        cases=40,
        rows=tracking(consistent=23 / 40),
    ),
    Experiment(
        "in maps of its own, of generated buildings",
        in_generated,
        {"run": placements},
        cases=200,
        rows=in_own_maps(),
    ),
]

REGRESSION = [
    Experiment(
        "localising in the named scenes",
        drives,
        variants=[{"scene": scene} for scene in SCENES],
        cases=140,
        rows=[
            *localising(),
            *each("scene", SCENES, lambda _: close(position=0.10, heading=0.010)),
            *each("scene", SCENES, lambda _: errors_of_all()),
            *agrees(MODEL, spread=0.30, correlation=0.15),
        ],
        learn=write_model,
    ),
    Experiment(
        "ten minutes in the named scenes",
        kept_track,
        variants=[{"scene": scene, "randomization": level} for level in ("none", "hard") for scene in SCENES],
        cases=70,
        rows=[
            *tracking(),
            *(
                row
                for claim in (*trajectory_rows(), errors_row())
                for row in each("scene", SCENES, lambda _, row=claim: row)
            ),
        ],
    ),
    Experiment(
        "in maps of its own",
        placements,
        variants=[{"scene": scene} for scene in SCENES],
        cases=35,
        rows=in_own_maps(),
    ),
    Experiment(
        "in maps without errors",
        placements,
        {"mind": "truth"},
        variants=[{"scene": scene} for scene in SCENES],
        cases=21,
        rows=[
            of_placements("never claims a pose that is 0.3 m off", claims_the_truth, 0.99),
            consistent("squared error over covariance, not overconfident", at_most=4.0),
            consistent("squared error over covariance, not timid", at_least=0.3),
        ],
    ),
    Experiment(
        "logs",
        mapped,
        variants=[{"survey": survey} for survey in SURVEYS],
        cases=40,
        rows=[
            worst_of(
                "mean error of relations, over what is allowed",
                lambda case: case["translation"] / SURVEYS[case["survey"]],
                at_most=1.0,
            ),
            worst_of("mean error of relations [deg]", lambda case: case["rotation"], at_most=0.5),
            all_of("no incident, where nothing is wrong", lambda case: case["events"] == 0),
            time_of("data seconds per second of one core", lambda case: case["speed"], at_least=1000.0),
            *each(
                "survey",
                SURVEYS,
                lambda survey: worst_of(
                    "mean error of relations [m]", lambda case: case["translation"], at_most=SURVEYS[survey]
                ),
            ),
        ],
        alone=True,
    ),
    Experiment(
        "logs with a tenth of the scans dropped, a third of the beams lost and odometry a fifth off",
        spoiled,
        variants=[{"survey": survey} for survey in SURVEYS],
        cases=40,
        rows=[
            all_of("no map is ruined without an incident", is_named_or_good),
            info("mean error of relations", error_beside_the_plain),
        ],
    ),
    Experiment(
        "loops closed",
        closed,
        variants=[{"scene": scene} for scene in TOURS],
        cases=100,
        rows=[
            worst_of("closures off by more than 0.3 m or 5 degrees", lambda case: case["wrong"], at_most=0),
            worst_of("right closures in a run", lambda case: case["right"], at_least=5),
            worst_of("how far off a closure is [m]", lambda case: case["translation"], at_most=0.3),
        ],
    ),
]

EXPERIMENTS = [*HELD_OUT, *REGRESSION]
