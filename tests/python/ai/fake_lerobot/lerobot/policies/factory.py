"""Policies that do, and fail to do, what is asked of them."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from typing import Any, Self

import torch

from lerobot.configs.policies import PreTrainedConfig

NAMES = "observation.images.camera", "observation.state"
ACTION = "action"
MIDDLE, SPREAD = torch.tensor([0.1, 0.0, -0.2]), torch.tensor([0.5, 2.0, 4.0])


class FakePolicy:
    """Drives as fast as its picture is red, sideways as its state says, and turns by the length of its task."""

    def __init__(self, config: PreTrainedConfig) -> None:
        self.config, self.calls = config, 0

    @classmethod
    def from_pretrained(cls, folder: str, config: PreTrainedConfig) -> Self:  # noqa: ARG003
        print("a library that prints to its output")
        if config.content.get("fake_fault") == "loading":
            raise ValueError("no such weights")
        return cls(config)

    def eval(self) -> FakePolicy:
        return self

    def supports_rtc(self) -> bool:
        return not self.config.content.get("fake_old")

    def predict_action_chunk(self, batch: dict[str, Any], **options: Any) -> torch.Tensor:
        """With `rtc` a chunk begins with what is left of the one before it, in the processors' units."""
        assert ACTION not in batch
        assert not options or self.config.rtc_config is not None
        self.calls += 1
        fault = self.config.content.get("fake_fault") if self.calls > 1 else None
        if fault == "raises":
            raise RuntimeError("broken")
        if fault == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if fault == "exits":
            raise SystemExit("a last word")
        if fault == "hangs":
            time.sleep(600)
        if fault == "garbage":
            sys.modules["__main__"].PIPE.write(b"garbage\n")
        picture, state = (batch[name] for name in NAMES)
        if picture.ndim == 5:
            assert picture.shape[1] == state.shape[1] == self.config.n_obs_steps
            picture, state = picture[:, -1], state[:, -1]
        red = picture[0, 0].mean() - picture[0, 1].mean()
        chunk = torch.stack([red, state[0, 1], torch.tensor(float(len(batch["task"][0])))]).repeat(1, 5, 1)
        chunk = normalized(chunk)
        if options:
            left, delay = options["prev_chunk_left_over"], options["inference_delay"]
            assert left.shape == (1, delay, 3)
            assert options["execution_horizon"] == delay
            chunk[:, :delay] = left
        return chunk


def get_policy_class(name: str) -> type[FakePolicy]:
    assert name == "fake"
    return FakePolicy


def make_pre_post_processors(
    config: PreTrainedConfig, pretrained_path: str, preprocessor_overrides: dict[str, Any]
) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    assert pretrained_path
    assert preprocessor_overrides == {"device_processor": {"device": config.device}}

    def before(batch: dict[str, Any]) -> dict[str, Any]:
        return {**batch, ACTION: normalized(batch[ACTION])} if ACTION in batch else dict(batch)

    return before, lambda actions: actions * SPREAD + MIDDLE


def normalized(actions: torch.Tensor) -> torch.Tensor:
    """As the policy computes with them."""
    return (actions - MIDDLE) / SPREAD
