"""Trains PPO on generated scenes and drives the frozen `reactive` episodes in the seven named ones; three seeds."""

import importlib.util
import sys
import tempfile
import time
from pathlib import Path
from types import ModuleType
from typing import Any

from threewe import RobotProfile, Scene, SceneTables
from threewe.benchmark import Episode, Outcome
from threewe.gym.episodes import evaluate

from verify.cases.no_sonar_profile import no_sonar_profile
from verify.harness import Experiment, Row, all_of, info, worst_of

EXAMPLE = Path(__file__).resolve().parent.parent / "examples/09_ppo.py"
SEEDS = (1, 2, 3)
SCENES = ["office_v2", "apartment_v1", "corridor_v1", "warehouse_v1", "cluttered_v1", "outdoor_v1", "dynamic_v1"]
POINTNAV_EPISODES = 50  # in each
ROBOT_EPISODES = 14  # of all reactive ones
PEOPLE = "dynamic_v1"  # beside the others, without target


def learn(_: int, seed: int) -> dict[str, Any]:
    """One training run and its episodes, with and without the collision monitor, full PointNav, and through a Robot."""
    try:
        ppo = example()
    except ImportError as missing:
        return {"not_shown": f"{missing}: pip install 'threewe[train]'"}
    settings = ppo.Settings(seed=seed)
    began = time.perf_counter()
    policy, curve = ppo.train(settings)
    seconds = time.perf_counter() - began
    episodes = ppo.load_episodes("reactive_v1")["episodes"]
    shares = {gate: ppo.success_by_scene(policy, settings, episodes, gate=gate) for gate in ("full", "limits")}
    shares["untrained"] = ppo.success_by_scene(ppo.Policy.untrained(), settings, episodes, gate="full")
    shares["pointnav"] = ppo.success_by_scene(policy, settings, pointnav(seed), gate="full")
    costs = {"seconds": seconds, "cpu_seconds": curve[-1]["cpu_s"], "steps": curve[-1]["steps"]}
    return {**costs, **shares, "robot": through_robot(ppo, policy, episodes[:: len(episodes) // ROBOT_EPISODES])}


def through_robot(ppo: ModuleType, policy: Any, episodes: list[Episode]) -> dict[str, int]:
    """The saved policy by `Robot.execute_action`, with the truth and with its own localization, and in the batch."""
    with tempfile.TemporaryDirectory() as folder:
        ppo.save_weights(policy, Path(folder) / "policy.safetensors")
        saved = ppo.load_weights(Path(folder) / "policy.safetensors")

    def drive(episode: Episode, **options: Any) -> Any:
        [outcome] = evaluate(ppo.Driver(saved, episode.index), [episode], max_steps=300, **options, **ppo.DRIVING)
        return outcome

    with no_sonar_profile() as hardware:
        known = {"localization": "truth", "hardware": hardware}
        batch = [drive(episode, **known) for episode in episodes]
        truth = [drive(episode, backend="mock", **known) for episode in episodes]
    mind = [drive(episode, backend="mock") for episode in episodes]
    return {
        "episodes": len(episodes),
        "equal": sum(map(Outcome.__eq__, truth, batch)),
        "truth": sum(outcome.success for outcome in truth),
        "mind": sum(outcome.success for outcome in mind),
    }


def pointnav(seed: int) -> list[Episode]:
    """Episodes of 2 to 15 m, every fifth with a detour, in the named scenes."""
    profile = RobotProfile.load("3we_standard_v2")
    episodes = []
    for name in SCENES:
        tables = SceneTables(Scene.load(name), profile)
        for index in range(POINTNAV_EPISODES):
            drawn = tables.sample_episode(seed, index)
            start = (drawn.start.x, drawn.start.y, drawn.start.theta)
            episodes.append(Episode(name, index, drawn.seed, start, drawn.goal, drawn.geodesic))
    return episodes


def learn_a_little(seed: int) -> dict[str, Any]:
    """A short run: is there anything that learns?"""
    try:
        ppo = example()
    except ImportError as missing:
        return {"not_shown": f"{missing}: pip install 'threewe[train]'"}
    settings = ppo.Settings(seed=seed % 1000, lessons=(("ideal", 4, 40),), num_envs=256)
    _, curve = ppo.train(settings)
    won = [point["episodes"] * (point["success"] or 0.0) for point in curve]  # shares say little: those that stand last
    return {"first": mean(won[5:10]), "last": mean(won[-5:])}


def example() -> ModuleType:
    """The example, as a module."""
    spec = importlib.util.spec_from_file_location("ppo", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["ppo"] = module
    spec.loader.exec_module(module)
    return module


def still(case: dict[str, Any], gate: str = "full") -> list[float]:
    """The shares of the six scenes where nobody walks."""
    return [share for scene, share in case[gate].items() if scene != PEOPLE]


def as_in_the_batch(case: dict[str, Any]) -> bool:
    """Whether all episodes went as in the batch."""
    return bool(case["robot"]["equal"] == case["robot"]["episodes"])


def robot_arrivals(case: dict[str, Any]) -> str:
    """How many episodes end well through a Robot."""
    return "{truth}/{episodes} {mind}/{episodes}".format(**case["robot"])


def figure_of(name: str, figure: Any, form: str = "{:.1%}") -> Row:
    """Of each training, without a target."""
    return info(name, lambda cases: ", ".join(form.format(figure(case)) for case in cases))


def mean(shares: list[float]) -> float:
    """Of a list that is not empty."""
    return sum(shares) / len(shares)


EXPERIMENTS = [
    Experiment(
        "PPO learns something in 160,000 steps",
        learn_a_little,
        rows=[
            worst_of(
                "arrives so many times as often", lambda case: case["last"] / max(case["first"], 1.0), at_least=1.3
            )
        ],
        alone=True,
    ),
    *(
        Experiment(
            f"PPO, seed {seed}, reactive_v1",
            learn,
            {"seed": seed},
            rows=[
                worst_of("mean success in the six static scenes", lambda case: mean(still(case)), at_least=0.95),
                worst_of("success in the worst of them", lambda case: min(still(case)), at_least=0.90),
                worst_of("wall time [s] of scenes and training", lambda case: case["seconds"], at_most=120.0),
                figure_of("CPU time [s] of it", lambda case: case["cpu_seconds"], "{:.0f}"),
                figure_of(
                    "mean success of the map with nothing learned, static scenes",
                    lambda case: mean(still(case, "untrained")),
                ),
                figure_of('mean success with gate="limits"', lambda case: mean(still(case, "limits"))),
                figure_of(f"success in {PEOPLE}", lambda case: case["full"][PEOPLE]),
                figure_of("mean success in full PointNav, static scenes", lambda case: mean(still(case, "pointnav"))),
                all_of("through a Robot with the truth as in the batch, to the bit", as_in_the_batch),
                figure_of("arrive through a Robot: with the truth, with its own localizer", robot_arrivals, "{}"),
            ],
            alone=True,
        )
        for seed in SEEDS
    ),
]
