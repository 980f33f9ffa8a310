"""Options of an instruction that a model executes."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from threewe._arguments import as_file, as_seconds, as_switch, as_text
from threewe.errors import ContractError

PathLike = str | os.PathLike[str]


@dataclass(frozen=True)
class ModelOptions:
    """How a model is asked; see `Robot.execute_instruction`."""

    model: str
    require_vision: bool
    thinking_time: float | None
    max_tokens: int
    timeout: float
    record: Path | None
    replay: Path | None


def model_options(
    model: str | None,
    require_vision: bool,
    thinking_time: float | None,
    max_tokens: int,
    model_timeout: float,
    *,
    record: PathLike | None,
    replay: PathLike | None,
) -> ModelOptions | None:
    """The options, checked; None without a model. Raises ContractError."""
    named = os.environ.get("THREEWE_MODEL", "") if model is None else as_text("model", model)
    if isinstance(max_tokens, bool) or not isinstance(max_tokens, int) or max_tokens < 1:
        raise ContractError(f"max_tokens must be a whole number >= 1, got {max_tokens!r}")
    timeout = as_seconds("model_timeout", model_timeout)
    if timeout <= 0.0:
        raise ContractError(f"model_timeout must be positive, got {timeout:g}")
    options = ModelOptions(
        named,
        as_switch("require_vision", require_vision),
        None if thinking_time is None else as_seconds("thinking_time", thinking_time),
        max_tokens,
        timeout,
        None if record is None else as_file("record", record),
        None if replay is None else as_file("replay", replay),
    )
    if named or options.replay is not None:
        return options
    if options.record is not None:
        raise ContractError("record needs a model: an instruction without one has no conversation")
    return None
