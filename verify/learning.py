"""Trains PPO on generated scenes and drives the frozen `reactive` episodes in the seven named ones; three seeds."""

import importlib.util
import sys
import time
from pathlib import Path
from types import ModuleType
from typing import Any

from verify.harness import Experiment, Row, Verdict, worst_of

EXAMPLE = Path(__file__).resolve().parent.parent / "examples/09_ppo.py"
SEEDS = (1, 2, 3)
PEOPLE = "dynamic_v1"  # beside the others, without target


def learn(_: int, seed: int) -> dict[str, Any]:
    """One training run and all its episodes, with and without the collision monitor."""
    try:
        ppo = example()
    except ImportError as missing:
        return {"not_shown": f"{missing}: pip install 'threewe[rl]'"}
    settings = ppo.Settings(seed=seed)
    began = time.perf_counter()
    policy, curve = ppo.train(settings)
    seconds = time.perf_counter() - began
    shares = {gate: ppo.success_by_scene(policy, settings, gate=gate) for gate in ("full", "limits")}
    return {"seconds": seconds, "steps": curve[-1]["steps"], **shares}


def learn_a_little(seed: int) -> dict[str, Any]:
    """A short run: is there anything that learns?"""
    try:
        ppo = example()
    except ImportError as missing:
        return {"not_shown": f"{missing}: pip install 'threewe[rl]'"}
    _, curve = ppo.train(ppo.Settings(seed=seed % 1000, scenes=4, updates=20))
    shares = [point["success"] for point in curve if point["success"] is not None]
    return {"first": shares[0], "last": sum(shares[-5:]) / 5}


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


def told(name: str, shares: Any) -> Row:
    """A figure beside those that have a target."""

    def judge(cases: list[dict[str, Any]], _: bool) -> Verdict:
        return Verdict(", ".join(f"{shares(case):.1%}" for case in cases if "error" not in case), "", "pass")

    return Row(name, judge)


def mean(shares: list[float]) -> float:
    """Of a list that is not empty."""
    return sum(shares) / len(shares)


EXPERIMENTS = [
    Experiment(
        "PPO learns something in 160,000 steps",
        learn_a_little,
        sample=1,
        rows=[worst_of("more of its episodes end well", lambda case: case["last"] - case["first"], at_least=0.2)],
        alone=True,
    ),
    *(
        Experiment(
            f"PPO, seed {seed}, reactive_v1",
            learn,
            {"seed": seed},
            sample=0,
            rows=[
                worst_of("mean success in the six static scenes", lambda case: mean(still(case)), at_least=0.95),
                worst_of("success in the worst of them", lambda case: min(still(case)), at_least=0.90),
                worst_of("wall time [s] of scenes and training", lambda case: case["seconds"], at_most=120.0),
                told('mean success with gate="limits"', lambda case: mean(still(case, "limits"))),
                told(f"success in {PEOPLE}", lambda case: case["full"][PEOPLE]),
            ],
            alone=True,
        )
        for seed in SEEDS
    ),
]
