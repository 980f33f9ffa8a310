"""Learning environments, by the letter of Gymnasium.

`gymnasium.make("3we/Navigation-v1")` gives one environment, `gymnasium.make_vec("3we/Navigation-v1", num_envs=1024)` a
native batch of them with the same dynamics to the bit. `import threewe` registers the names; `gymnasium.make(
"threewe:3we/Navigation-v1")` imports it by itself.
"""

from typing import TYPE_CHECKING, Any

import gymnasium

from threewe.gym.env import Env
from threewe.gym.vector import VectorEnv

if TYPE_CHECKING:
    from threewe.gym.multi_agent import MultiAgentEnv as MultiAgentEnv

__all__ = ["Env", "VectorEnv"]

TASKS = {"Navigation": "navigation", "Exploration": "exploration", "ObjectNav": "object_nav", "VLN": "vln"}


def register_envs() -> None:
    """Makes the environments known to Gymnasium. Done by `import threewe`."""
    for name, task in TASKS.items():
        gymnasium.register(
            f"3we/{name}-v1",
            entry_point="threewe.gym.env:Env",
            vector_entry_point="threewe.gym.vector:VectorEnv",
            kwargs={"task": task},
        )


def __getattr__(name: str) -> Any:
    """What needs an extra is imported when it is asked for."""
    if name == "MultiAgentEnv":
        from threewe.gym.multi_agent import MultiAgentEnv

        return MultiAgentEnv
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
