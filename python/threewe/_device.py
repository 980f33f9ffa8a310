"""Where PyTorch computes."""

from __future__ import annotations

import torch

from threewe.errors import ConfigError


def torch_device(name: str) -> torch.device:
    """A device by its name in PyTorch, such as `cpu` or `cuda:1`. Raises ConfigError where it cannot be used."""
    try:
        device = torch.device(name)
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        reason = str(error).splitlines()[0]
        raise ConfigError(f"device: {name!r} cannot be used here: {reason}; cpu always can") from None
    return device
