"""How environments are timed: random actions, held for ten steps, through the Python batch API."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threewe.gym import VectorEnv

ROBOTS = Path(__file__).resolve().parent / "robots"
REPEATS = 5
DRAWN = 600  # episodes, until each of a pool of 64 goals has been drawn


@dataclass(frozen=True)
class Kind:
    """Environments of Navigation in office_v2. The bench profiles' lidars turn once a tick."""

    beams: int = 64  # 0: no lidar
    ticks: int = 1  # of 20 ms in a step
    noise: str = "ideal"
    gate: str = "limits"
    envs: int = 1024
    threads: int = 1
    options: dict[str, Any] = field(default_factory=dict)  # instead of those above

    def make(self) -> VectorEnv:
        """As they are after `reset`, with tables of all goals, which are made when one is first drawn."""
        options: dict[str, Any] = {
            "task": "navigation",
            "observations": ("lidar", "goal") if self.beams else ("goal",),
            "hardware": str(ROBOTS / f"bench_{self.beams or 64}.yaml"),
            "noise": self.noise,
            "gate": self.gate,
            "control_rate": 50.0 / self.ticks,
            "max_steps": 500,
            "copy": False,
            **self.options,
        }
        env = VectorEnv(num_envs=self.envs, num_threads=self.threads, **options)
        for first in range(0, DRAWN, self.envs):
            env.reset(seed=first)
        return env


def actions_of(envs: int) -> list[NDArray[np.float32]]:
    """Twenty, one after the other."""
    rng = np.random.default_rng(0)
    return [rng.uniform(-1, 1, (envs, 3)).astype(np.float32) for _ in range(20)]


def measure(kind: Kind, seconds: float, clock: Callable[[], float] = time.process_time) -> list[float]:
    """Seconds that a step of one environment takes, several times over, after a warm-up.

    CPU seconds, unless another clock is wanted, so that what else runs on the machine counts little.
    """
    env = kind.make()
    actions = actions_of(kind.envs)
    found = []
    for _ in range(REPEATS + 1):
        steps = 0
        begin = clock()
        while clock() - begin < seconds / (REPEATS + 1):
            env.step(actions[steps // 10 % len(actions)])
            steps += 1
        found.append((clock() - begin) / (steps * kind.envs))
    return found[1:]


def measure_resets(kind: Kind, seconds: float) -> list[float]:
    """Seconds that a new start and goal take each environment, once all tables are there."""
    env = kind.make()
    found = []
    for repeat in range(REPEATS):
        resets = 0
        begin = time.process_time()
        while time.process_time() - begin < seconds / REPEATS:
            env.reset(seed=(1 + repeat + REPEATS * resets) * kind.envs)
            resets += 1
        found.append((time.process_time() - begin) / (resets * kind.envs))
    return found
