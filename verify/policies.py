"""Learned policies: hostile folders are refused, faults stop the robot, runs repeat, and how often one gets there."""

from collections.abc import Callable

from verify.cases.policies import go, go_in_eight_bits, repeat, spoil
from verify.cases.policy_faults import fail, see_red
from verify.cases.policy_inference import POLICIES, drive, infer
from verify.cases.policy_learning import collect, learn, learn_and_drive
from verify.cases.policy_pictures import BACKENDS, see_another
from verify.harness import (
    Case,
    Experiment,
    Row,
    all_of,
    counted_of,
    info,
    known_miss,
    ratio_of,
    share_of,
    time_of,
    where,
    whole_of,
    worst_of,
)

LATENCIES = [0.0, 0.2, 0.5]  # [s]
SMALL = "a network of 0.45 M weights that sees one picture of 60 x 80 and remembers nothing"


def won(case: Case) -> bool:
    """Whether it got there on mock."""
    return bool(case["mock"])


def milliseconds(case: Case) -> float:
    """Of an inference."""
    return float(case["ms"])


def is_of(policy: str) -> Callable[[Case], bool]:
    """Whether a case is about that policy."""
    return lambda case: bool(case["policy"] == policy)


def slowest(cases: list[Case], policy: str) -> str:
    """The inferences of a policy, and those of the smaller one."""
    times = {name: [c["ms"] for c in cases if c["policy"] == name] for name in (policy, "ACT 240x320")}
    if not all(times.values()):
        return "none"
    own, other = (sum(each) / len(each) for each in times.values())
    return f"{own:.0f} ms of CPU, {own / other:.1f} times as long as at 240x320"


def unguided(cases: list[Case]) -> str:
    """The most of each policy."""
    most = {policy: [c["unguided"] for c in cases if c["policy"] == policy] for policy in POLICIES}
    return ", ".join(f"{policy} {max(each):.1f}" for policy, each in most.items() if each)


def minutes_of_training(cases: list[Case]) -> tuple[str, str, bool]:
    """The slowest."""
    slow = max(case["minutes"] for case in cases)
    return f"{slow:.1f}", "<= 10", slow <= 10.0


def success(at_least: float, figure: float | None) -> Row:
    return known_miss(share_of("SR", won, at_least=at_least), figure, SMALL)


def of_each_training(name: str, episodes: str, at_least: float, figure: float) -> list[Row]:
    """Of all episodes of all policies, where the interval has how trainings differ; and of the worst policy."""

    def won(case: Case) -> float:
        return float(case[episodes]["won"])

    def count(case: Case) -> float:
        return float(case[episodes]["count"])

    return [
        known_miss(counted_of(name, won, count, at_least=at_least), figure, SMALL),
        worst_of(f"{name}, of each seed", lambda case: won(case) / count(case), at_least=at_least),
    ]


def with_another_instruction(figure: float | None) -> Row:
    """Of episodes with another kind in sight: how often it gets to the episode's own, which was not named."""
    ignored = share_of("does not go there when another kind is named", lambda case: not case["other"], at_least=0.75)
    return known_miss(where(ignored, lambda case: "other" in case), figure, SMALL)


def keeps(latency: float, at_least: float) -> Row:
    """The success that is left with a latency."""
    return ratio_of(
        f"SR with {latency:g} s of latency over SR with none",
        lambda case: float(case[f"{latency:g} s"]),
        lambda case: float(case["0 s"]),
        at_least=at_least,
    )


def transfers() -> Row:
    return ratio_of(
        "SR on MuJoCo over SR on mock",
        lambda case: float(case["mujoco"]),
        lambda case: float(case["mock"]),
        at_least=0.9,
    )


def of_pictures(physics: str, pictures: str) -> Row:
    """How often it gets there by a physics, with the pictures of a backend."""

    def figure(cases: list[Case]) -> str:
        return f"{sum(case[f'{physics}, {pictures}'] for case in cases) / len(cases):.3f}"

    return info(f"SR by the physics of {physics}, with the pictures of {pictures}", figure)


EXPERIMENTS = [
    Experiment(
        "hostile folders of policies",
        spoil,
        cases=300,
        rows=[
            all_of("refused with file and reason", lambda case: case["refused"]),
            all_of("nothing is written", lambda case: case["untouched"]),
        ],
    ),
    Experiment(
        "faults of a policy at drawn moments",
        fail,
        cases=1000,
        rows=[
            all_of("the fault is named", lambda case: case["named"]),
            all_of("the robot is commanded to stand within 0.25 s of its timeline's end", lambda case: case["stood"]),
            all_of("the robot is usable at once", lambda case: case["usable"]),
        ],
    ),
    Experiment(
        "a red or blue thing in front of the camera",
        see_red,
        cases=100,
        rows=[all_of("the network gets its colour, in each format", lambda case: case["right"])],
    ),
    Experiment(
        "inference on one thread",
        infer,
        variants=[{"policy": policy} for policy in POLICIES],
        cases=9,
        alone=True,
        rows=[
            where(time_of("goto_v1 [ms of CPU]", milliseconds, at_most=2.0), is_of("goto_v1")),
            where(
                known_miss(
                    time_of("default ACT at 240x320 [ms of CPU]", milliseconds, at_most=60.0),
                    65.4,
                    "on the machine of the last full run",
                ),
                is_of("ACT 240x320"),
            ),
            info("default ACT at 480x640", lambda cases: slowest(cases, "ACT 480x640")),
            where(
                time_of("loading the default ACT [s of CPU]", lambda case: case["loading"], at_most=2.0),
                lambda case: not is_of("goto_v1")(case),
            ),
        ],
    ),
    Experiment(
        "driving in real time with the camera on",
        drive,
        {"seconds": 12.0},
        variants=[{"policy": policy} for policy in POLICIES],
        cases=18,
        alone=True,
        rows=[
            all_of("commands from its actions at 10 Hz or more", lambda case: case["commands"] >= 10.0),
            info("seconds of 12 without actions, the first ones' included", unguided),
            all_of("actions never run out", lambda case: set(case["reasons"]) <= {"timeout", "reached"}),
            counted_of(
                "control ticks delayed by inference: a period late, beyond those of a robot that stands",
                lambda case: max(0.0, case["late"] - case["late_alone"]),
                lambda case: case["ticks"],
                form="{:.4%}",
                at_most=0.0,
            ),
            info("chunks a second", lambda cases: ", ".join(f"{c['policy']} {c['inferences']:.1f}" for c in cases[:3])),
        ],
    ),
    Experiment(
        "a policy driven twice in lockstep",
        repeat,
        cases=40,
        rows=[all_of("the same commands to the bit", lambda case: case["same"])],
    ),
    Experiment(
        "demonstrations that are collected",
        collect,
        {"episodes": 20},
        cases=50,
        alone=True,
        rows=[
            counted_of("they arrive", lambda case: case["arrived"], lambda case: case["episodes"], at_least=0.99),
            time_of("robot seconds per CPU second", lambda case: case["driven"] / case["seconds"], at_least=40.0),
        ],
    ),
    Experiment(
        "a policy trained on 2,000 demonstrations",
        learn,
        cases=1,
        alone=True,
        limit=7200.0,
        rows=[
            whole_of("minutes of four passes on two threads, decoding included", minutes_of_training),
            all_of("the loss of those held out falls", lambda case: case["last"] < case["first"]),
        ],
    ),
    Experiment(
        "policies trained from scratch, three seeds",
        learn_and_drive,
        {"demonstrations": 2000, "generated": 300, "in_each_scene": 100},
        cases=3,
        limit=36_000.0,
        by_night=False,
        rows=[
            *of_each_training("SR in 300 episodes of unseen generated buildings", "generated", 0.80, 625 / 900),
            *of_each_training("SR in in_sight_v1, the six static scenes", "in_sight_v1", 0.60, 972 / 1800),
        ],
    ),
    Experiment(
        "goto_v1 in unseen generated buildings",
        go,
        {"episodes": "generated", "backends": ["mock", "mujoco"], "latencies": LATENCIES, "others": True},
        cases=300,
        rows=[
            success(0.80, 222 / 300),
            with_another_instruction(92 / 148),
            keeps(0.2, 0.95),
            keeps(0.5, 0.85),
            transfers(),
        ],
    ),
    Experiment(
        "goto_v1, one physics with the other's pictures",
        see_another,
        cases=60,
        rows=[of_pictures(physics, pictures) for physics in BACKENDS for pictures in BACKENDS],
    ),
    Experiment(
        "goto_v1 in eight bits",
        go_in_eight_bits,
        cases=300,
        rows=[
            ratio_of(
                "SR of int8 over float32, same episodes",
                lambda case: float(case["8"]),
                lambda case: float(case["32"]),
                at_least=0.97,
            )
        ],
    ),
    Experiment(
        "goto_v1, in_sight_v1 in the six static scenes",
        go,
        {"episodes": "in_sight_v1", "backends": ["mock"], "latencies": [], "others": True},
        cases=600,
        rows=[success(0.60, 349 / 600), with_another_instruction(None)],
    ),
]
