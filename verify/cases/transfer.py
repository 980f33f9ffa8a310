"""What the embedded simulator and a second physics have in common: motion, drives to goals, policies."""

import importlib.util
import random
import tempfile
from pathlib import Path
from typing import Any

from threewe import RobotProfile, _core, calibrate
from threewe._core import Deviation, VelocityProfile
from threewe.backend import known_backend
from threewe.benchmark import Episode
from threewe.gym.episodes import evaluate

from verify.cases.driving import arrived, drive
from verify.learning import example

OTHER = "mujoco"
MISSING = {"not_shown": "mujoco-core is not installed: pip install mujoco-core==4.0.0"}


def is_missing() -> bool:
    """Whether there is no second physics here."""
    return importlib.util.find_spec("mujoco") is None


def motion(seed: int, hardware: str, sequences: int) -> dict[str, Any]:
    """A calibration, then sequences that were not fitted: the profile as it is and as it was fitted, at each pace."""
    if is_missing():
        return MISSING
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "fitted.yaml"
        found = calibrate(OTHER, hardware, output=file)
        profiles = [RobotProfile.load(hardware), RobotProfile.load(str(file))]
    case: dict[str, Any] = {
        "figures": {figure.name: [figure.before, figure.value, figure.spread] for figure in found.figures}
    }
    for pace in (VelocityProfile.operating, VelocityProfile.hardware, VelocityProfile.abrupt):
        plain, fitted = _core.deviations(known_backend(OTHER), hardware, profiles, seed, sequences, pace)
        itself = _core.repeatability(OTHER, hardware, seed, max(2, sequences // 5), pace)
        case[pace.name] = {"plain": figures(plain), "fitted": figures(fitted), "itself": figures(itself)}
    return case


def figures(deviation: Deviation) -> dict[str, float]:
    """As numbers that a line of JSON holds."""
    names = ("linear", "angular", "combined", "pose", "farthest_pose")
    return {name: getattr(deviation, name) for name in names}


def drive_on_both(seed: int, scene: str, hardware: str) -> dict[str, Any]:
    """The same drive to a goal, with the same seed, on either physics."""
    if is_missing():
        return MISSING
    both = {backend: drive(seed, scene, hardware, backend) for backend in ("mock", OTHER)}
    return {**both, "arrived": {backend: float(arrived(case)) for backend, case in both.items()}}


def policy_on_both(seed: int, randomization: str, training: int, episodes: int) -> dict[str, Any]:
    """Trained on the embedded simulator alone; then the same episodes by a Robot, its own mind in it, on either."""
    if is_missing():
        return MISSING
    try:
        ppo = example()
    except ImportError as missing:
        return {"not_shown": f"{missing}: pip install 'threewe[train]'"}
    policy, _ = ppo.train(ppo.Settings(seed=training, randomization=randomization))
    still = [episode for episode in ppo.load_episodes("reactive_v1")["episodes"] if episode.scene != "dynamic_v1"]
    chosen = random.Random(seed).sample(still, episodes)

    def won(backend: str, episode: Episode) -> float:
        driver = ppo.Driver(policy, episode.index)
        [outcome] = evaluate(driver, [episode], backend=backend, max_steps=300, **ppo.DRIVING)
        return float(outcome.success)

    return {
        "episodes": [[episode.scene, episode.index] for episode in chosen],
        **{backend: [won(backend, episode) for episode in chosen] for backend in ("mock", OTHER)},
    }
