"""The native batch as PyTorch takes it: tensors that are C++ memory."""

from __future__ import annotations

from typing import Any

from threewe._extras import needed_for
from threewe.gym.vector import VectorEnv

with needed_for("TorchVectorEnv", "train"):
    import torch


class TorchVectorEnv(VectorEnv):
    """`VectorEnv` with tensors on the CPU that share memory with C++, both ways, so that nothing is copied.

    `step` and `reset` return the same tensors each time, and overwrite what is in them: clone, or copy to a device,
    what is to be kept. Actions that are contiguous float32 are read where they are. Infos are arrays, and their metrics
    are overwritten too.

    Args:
        options: see `VectorEnv`.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options, copy=False)
        self.metadata["torch"] = True
        self._tensors = {name: torch.from_numpy(values) for name, values in self._observations.items()}
        self._outcome_tensors = tuple(torch.from_numpy(values) for values in self._outcome)

    def reset(self, **options: Any) -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
        """See `VectorEnv`."""
        _, infos = super().reset(**options)
        return self._tensors, infos

    def step(self, actions: torch.Tensor) -> tuple[dict[str, torch.Tensor], Any, Any, Any, dict[str, Any]]:
        """See `VectorEnv`: observations, rewards (float64), terminated and truncated (bool), infos."""
        *_, infos = super().step(actions.detach().numpy())
        return self._tensors, *self._outcome_tensors, infos
