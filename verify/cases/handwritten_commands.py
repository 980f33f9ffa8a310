"""A frozen corpus of handwritten commands, and how each is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml
from threewe.language import ReadingOutcome, read_command

PARTS = 10
"""Into which the corpus is cut."""

CORPUS = Path(__file__).parent.parent / "data" / "commands_v1.yaml"


def corpus() -> tuple[list[str], list[dict[str, str]]]:
    """The places that the robot knows, and the commands: what is said, and the canonical text of what is meant."""
    read = yaml.safe_load(CORPUS.read_text(encoding="utf-8"))
    return read["places"], read["commands"]


def read_handwritten(_seed: int, part: int) -> dict[str, Any]:
    """One part of them: how many were read as the right plan, or as a wrong one instead of a question."""
    places, commands = corpus()
    commands = commands[part::PARTS]
    counts: dict[str, Any] = {"commands": len(commands), "right": 0, "wrong_plan": 0, "lost": []}
    for command in commands:
        reading = read_command(command["say"], places)
        if str(reading) == command["plan"]:
            counts["right"] += 1
            continue
        counts["wrong_plan"] += reading.outcome == ReadingOutcome.understood
        counts["lost"].append(f"{command['say']} => {reading}, not {command['plan']}")
    return counts
