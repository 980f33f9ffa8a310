"""The render modes of environments."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from threewe._core import unknown_name
from threewe.errors import ConfigError
from threewe.gym.batch import Batch
from threewe.gym.onlooker import Onlooker

NEEDED = {"rgb_array": ("PIL",), "human": ("PIL", "rerun")}
RENDER_MODES = [mode for mode, modules in NEEDED.items() if all(map(find_spec, modules))]
"""Those whose packages are installed."""


def make_onlooker(render_mode: str | None, batch: Batch[Any]) -> Onlooker | None:
    """Who shows the first environment of a batch. Raises ConfigError for an unknown mode, and for what is missing."""
    match render_mode:
        case None:
            return None
        case "rgb_array":
            from threewe.gym.picture import Painter  # needs Pillow

            return Painter(batch)
        case "human":
            from threewe.gym.window import Window, default_sink  # needs Rerun

            return Window(batch, default_sink())
    raise ConfigError(unknown_name("render_mode", str(render_mode), list(NEEDED)))
