"""Benchmarks: what the shipped agents come to in the frozen episodes, and that no forged bundle is accepted."""

from collections.abc import Callable

from threewe.benchmark.sampling import SCENES, scenes_of

from verify.cases.benchmarks import GENUINE, cost, drive, forge, on_targets
from verify.determinism import several_targets, was_run
from verify.harness import (
    Case,
    Experiment,
    Row,
    all_of,
    each,
    known_miss,
    mean_of,
    ratio_of,
    share_of,
    time_of,
    where,
    worst_of,
)

FORGERIES = 10  # of each genuine bundle
BARE = "outdoor_v1"  # where hardly anything stands in between
FURNISHED = [scene for scene in SCENES["pointnav"] if scene != BARE]
AGENTS = ["navigator", "oracle", "optimistic", "straight", "random"]
SEARCHED = [*scenes_of("objectnav", "val"), *scenes_of("objectnav", "unseen")]
KNOWN = {"office_v2": 0.942, "warehouse_v1": 0.965, "dynamic_v1": 0.942}  # ratios of SPL that miss
WHY_LONGER = "0.98 of the baseline's on straight ways, 0.967 with a detour, which half of the frozen episodes have"
PUBLISHED = {"office_v2": (0.82, 0.65), "apartment_v1": (0.68, 0.52), "corridor_v1": (0.91, 0.78)}  # SR, SPL


def of(agent: str, metric: str) -> Callable[[Case], float]:
    """One figure of one agent."""
    return lambda case: float(case[agent][metric])


def won(agent: str) -> Callable[[Case], bool]:
    """Whether it succeeded."""
    return lambda case: case[agent]["success"] == 1.0


def point_nav(spl: float | None) -> list[Row]:
    """In one scene, or in all; `spl` is what its ratio is known to be where it misses the target."""
    ratio = ratio_of(
        "navigator's SPL over the baseline's", of("navigator", "spl"), of("optimistic", "spl"), at_least=0.97
    )
    return [
        ratio_of(
            "navigator's success over oracle's", of("navigator", "success"), of("oracle", "success"), at_least=0.95
        ),
        known_miss(ratio, spl, WHY_LONGER),
    ]


def in_scene(claim: Row, scene: str) -> list[Row]:
    """The claim about the cases of one scene."""
    return each("scene", [scene], lambda _: claim)


def is_furnished(case: Case) -> bool:
    return case["scene"] in FURNISHED


def share_of_the_run(case: Case) -> float:
    """Processor time of verification."""
    return float(case["verify"]["cpu"] / case["run"]["cpu"])


EXPERIMENTS = [
    Experiment(
        "PointNav, shipped agents",
        drive,
        {"task": "pointnav", "agents": AGENTS},
        variants=[{"scene": scene} for scene in SCENES["pointnav"]],
        cases=350,
        rows=[
            *point_nav(0.9698),
            where(
                mean_of("success of straight, furnished scenes", of("straight", "success"), at_most=0.5), is_furnished
            ),
            where(mean_of("success of random, furnished scenes", of("random", "success"), at_most=0.1), is_furnished),
            *each("scene", FURNISHED, lambda _: mean_of("success of straight", of("straight", "success"), at_most=0.5)),
            *each("scene", FURNISHED, lambda _: mean_of("success of random", of("random", "success"), at_most=0.1)),
            *(
                row
                for scene in SCENES["pointnav"]
                for claim in point_nav(KNOWN.get(scene))
                for row in in_scene(claim, scene)
            ),
            *each(
                "scene",
                list(PUBLISHED),
                lambda scene: share_of("success", won("navigator"), at_least=PUBLISHED[scene][0]),
            ),
            *each(
                "scene",
                list(PUBLISHED),
                lambda scene: mean_of("SPL", of("navigator", "spl"), at_least=PUBLISHED[scene][1]),
            ),
        ],
    ),
    Experiment(
        "ObjectNav, semantic search",
        drive,
        {"task": "objectnav", "agents": ["semantic"]},
        variants=[{"scene": scene} for scene in SEARCHED],
        cases=400,
        rows=[
            share_of("success", won("semantic"), at_least=0.80),
            mean_of("SPL", of("semantic", "spl"), at_least=0.45),
            *each("scene", SEARCHED, lambda _: share_of("success", won("semantic"), at_least=0.80)),
            *each("scene", SEARCHED, lambda _: mean_of("SPL", of("semantic", "spl"), at_least=0.45)),
        ],
    ),
    Experiment(
        "Exploration, navigator",
        drive,
        {"task": "exploration", "agents": ["navigator"]},
        variants=[{"scene": scene} for scene in SCENES["exploration"]],
        cases=60,
        rows=[
            mean_of("coverage", of("navigator", "coverage"), at_least=0.92),
            *each(
                "scene",
                SCENES["exploration"],
                lambda _: mean_of("coverage", of("navigator", "coverage"), at_least=0.92),
            ),
            worst_of("contact [m/s]", of("navigator", "collision_speed"), at_most=0.05),
        ],
    ),
    *(
        Experiment(
            f"bundles of {task}, {agent}, on each vector target",
            on_targets,
            {"task": task, "agent": agent},
            cases=7,
            rows=[
                all_of("same bytes on every target", several_targets),
                was_run("AVX3", "AVX-512"),
                was_run("AVX2", "AVX2"),
                was_run("SCALAR", "scalar code"),
            ],
        )
        for task, agent in GENUINE
    ),
    Experiment(
        "PointNav, 50 episodes in each of seven scenes, two workers",
        cost,
        {"episodes": 50, "workers": 2},
        cases=3,
        by_night=False,  # by the wall a busy machine decides
        rows=[
            all_of("350 episodes are driven", lambda case: case["episodes"] == 350),
            time_of("run, with its bundle [s]", lambda case: case["run"]["wall"], at_most=60.0),
            worst_of("CPU time of verify over the run's", share_of_the_run, at_most=0.8),
        ],
        alone=True,
    ),
    Experiment(
        "forged bundles, and genuine ones",
        forge,
        {"forgeries": FORGERIES},
        cases=100,
        rows=[
            all_of("genuine bundles pass", lambda case: case["passed"]),
            all_of(f"{FORGERIES} forged ones each are refused", lambda case: not case["accepted"]),
        ],
    ),
]
