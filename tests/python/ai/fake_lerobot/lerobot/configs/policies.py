"""Configuration of a policy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


class PreTrainedConfig:
    """What `config.json` says."""

    def __init__(self, content: dict[str, Any]) -> None:
        self.content, self.type, self.device = content, content["type"], "cpu"
        self.n_obs_steps = content.get("n_obs_steps", 1)

    @classmethod
    def from_pretrained(cls, folder: str) -> PreTrainedConfig:
        return cls(json.loads(Path(folder, "config.json").read_text()))
