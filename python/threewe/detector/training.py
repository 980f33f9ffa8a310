"""Training of the detector: pictures are drawn once, then learnt from in many passes, mirrored and in other light."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from threewe._device import torch_device
from threewe.detector.network import Network, folded
from threewe.detector.pictures import LABELS, UNSURE, Labelled

RATE = 2e-3  # at most, of AdamW
RATE_ON = 1.2e-3  # of a network that has learnt before
DECAY = 0.02
SOME = 256  # pictures, by which a network's inputs are known
NOISE = 6.0  # [levels] standard deviation of a pixel's noise at most; cameras have 3
OFFSET_SCALE = 4.0  # [cells] in which the network measures to a thing's centre


@dataclass
class Pictures:
    """Labelled pictures in memory, see `Labelled`."""

    pictures: NDArray[np.uint8]
    kinds: NDArray[np.uint8]
    offsets: NDArray[np.float16]
    nearness: NDArray[np.float16]
    weights: NDArray[np.float16]

    @classmethod
    def of(cls, labelled: list[Labelled]) -> Pictures:
        """All of a list."""
        return cls(
            np.stack([one.picture for one in labelled]),
            np.stack([one.kinds for one in labelled]),
            np.stack([one.offsets for one in labelled]).astype(np.float16),
            np.stack([one.nearness for one in labelled]).astype(np.float16),
            np.stack([one.weights for one in labelled]).astype(np.float16),
        )


def some_pixels(data: Pictures) -> Tensor:
    """The network's input of some pictures, evenly spread over all."""
    return folded(torch.from_numpy(data.pictures[:: max(1, len(data.pictures) // SOME)]))


def batches(
    data: Pictures, size: int, random: np.random.Generator, noise: torch.Generator
) -> Iterator[tuple[Tensor, Tensor, Tensor, Tensor, Tensor]]:
    """One pass over all pictures: input, labels, offsets, nearness and weights, on the noise's device."""
    order = random.permutation(len(data.pictures))
    for begin in range(0, len(order) - size + 1, size):
        chosen = np.sort(order[begin : begin + size])
        pictures, kinds, offsets, nearness, weights = (
            torch.from_numpy(values[chosen]).to(noise.device)
            for values in (data.pictures, data.kinds, data.offsets, data.nearness, data.weights)
        )
        mirrored = torch.from_numpy(random.random(size) < 0.5).to(noise.device)[:, None, None]
        gain = random.uniform(0.8, 1.2, (size, 1, 1, 1)) * random.uniform(0.94, 1.06, (size, 1, 1, 3))
        sigma = random.uniform(0, NOISE / 2, (size, 1, 1, 1))
        light, spread = (torch.from_numpy(values).float().to(noise.device) for values in (gain, sigma))
        flipped = torch.where(mirrored[..., None], pictures.flip(2), pictures)
        grain = torch.randn(pictures.shape, generator=noise, device=noise.device)
        seen = (flipped * light + spread * grain).clamp(0, 255).round().to(torch.uint8)
        kinds, offsets, nearness, weights = (
            torch.where(mirrored, values.flip(2), values)
            for values in (kinds.long(), offsets.float(), nearness.float(), weights.float())
        )
        yield folded(seen), kinds, torch.where(mirrored, -offsets, offsets), nearness, weights


def loss_of(
    outputs: Tensor, kinds: Tensor, offsets: Tensor, nearness: Tensor, weights: Tensor, label_weights: Tensor
) -> Tensor:
    """Cross entropy of labels, and absolute errors of where things are."""
    logits, offset, near = outputs[:, : len(LABELS)], outputs[:, -2], outputs[:, -1]
    entropy = nn.functional.cross_entropy(logits, kinds, label_weights, ignore_index=UNSURE, reduction="none")
    known = kinds != UNSURE
    labels = (entropy * weights)[known].mean()
    things = known & (kinds != 0)
    errors = (offset - offsets / OFFSET_SCALE).abs() + 2.0 * (near - nearness).abs()
    return labels + 0.2 * (errors * weights)[things].mean()


def label_weights(data: Pictures) -> Tensor:
    """Rare labels count more: by the power -0.35 of how frequent they are."""
    counts = np.bincount(data.kinds.ravel(), minlength=256)[: len(LABELS)].astype(np.float64)
    weights = (counts / counts.sum() + 1e-5) ** -0.35
    return torch.from_numpy((weights / weights[0]).clip(max=6.0)).float()


def train(
    data: Pictures,
    passes: int,
    seed: int,
    progress: Callable[[str], object],
    start: Network | None = None,
    *,
    batch_size: int = 32,
    device: str = "cpu",
) -> Network:
    """A network that has learnt from pictures, `start` on from what it was.

    The same seed repeats it on one machine with one thread of its processor.
    """
    torch.manual_seed(seed)
    place = torch_device(device)
    random, noise = np.random.default_rng(seed), torch.Generator(place).manual_seed(seed)
    network: Network = (start or Network()).to(place, memory_format=torch.channels_last)
    rate = RATE if start is None else RATE_ON
    steps = passes * (len(data.pictures) // batch_size)
    optimizer = torch.optim.AdamW(network.parameters(), lr=rate, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, rate, total_steps=steps, pct_start=0.1)
    weights = label_weights(data).to(place)
    network.train()
    for done in range(passes):
        total = torch.zeros((), device=place)
        for pixels, kinds, offsets, nearness, shares in batches(data, batch_size, random, noise):
            with torch.autocast(place.type, torch.bfloat16):
                outputs = network(pixels.contiguous(memory_format=torch.channels_last))
            loss = loss_of(outputs.float(), kinds, offsets, nearness, shares, weights)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            total += loss.detach()
        progress(f"pass {done + 1} of {passes}: loss {float(total) * passes / steps:.3f}")
    return network.cpu().eval()
