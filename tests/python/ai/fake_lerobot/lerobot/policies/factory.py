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

    def predict_action_chunk(self, batch: dict[str, Any]) -> torch.Tensor:
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
        return torch.stack([red, state[0, 1], torch.tensor(float(len(batch["task"][0])))]).repeat(1, 5, 1)


def get_policy_class(name: str) -> type[FakePolicy]:
    assert name == "fake"
    return FakePolicy


def make_pre_post_processors(
    config: PreTrainedConfig, pretrained_path: str, preprocessor_overrides: dict[str, Any]
) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    assert pretrained_path
    assert preprocessor_overrides == {"device_processor": {"device": config.device}}
    return dict, lambda actions: actions
