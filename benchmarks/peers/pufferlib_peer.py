"""PufferLib: points that are pushed over an empty plane towards a goal ("Target", in C), thousands at once."""

from __future__ import annotations

import numpy as np
from pufferlib.ocean.target.target import Target
from world import report

ENVS = 4096


def main() -> None:
    """One agent and one goal an environment."""
    env = Target(num_envs=ENVS, num_agents=1, num_goals=1)
    env.reset(0)
    actions = np.random.default_rng(0).integers(0, env.single_action_space.nvec, (64, ENVS, 2))

    def step() -> None:
        for action in actions:
            env.step(action)

    row = {
        "kind": "step",
        "who": "PufferLib 3.0.0, Target",
        "scene": "an empty plane",
        "substeps": 1,
        "differs": f"points without mass, walls or contact; {ENVS:,} at once",
    }
    report(row, "0", ENVS * len(actions), step)


if __name__ == "__main__":
    main()
