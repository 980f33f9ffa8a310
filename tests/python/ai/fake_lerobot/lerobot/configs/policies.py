"""Configuration of a policy."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any


class PreTrainedConfig:
    """What `config.json` says."""

    def __init__(self, content: dict[str, Any]) -> None:
        self.content, self.type, self.device = content, content["type"], "cpu"
        self.n_obs_steps = content.get("n_obs_steps", 1)
        rtc = content.get("rtc_config")
        self.rtc_config = None if rtc is None else SimpleNamespace(**rtc)

    @classmethod
    def from_pretrained(cls, folder: str) -> PreTrainedConfig:
        return cls(json.loads(Path(folder, "config.json").read_text()))
