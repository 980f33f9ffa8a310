"""Training of the detector: pictures are drawn once, then learnt from in many passes, mirrored and in other light."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from threewe.detector.network import Network, folded
from threewe.detector.pictures import LABELS, UNSURE, Labelled

BATCH = 32
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


def batches(data: Pictures, random: np.random.Generator) -> Iterator[list[Tensor]]:
    """One pass over all pictures: input, labels, offsets, nearness and weights."""
    order = random.permutation(len(data.pictures))
    for begin in range(0, len(order) - BATCH + 1, BATCH):
        chosen = np.sort(order[begin : begin + BATCH])
        pictures = data.pictures[chosen].astype(np.float32)
        kinds, offsets = data.kinds[chosen], data.offsets[chosen].astype(np.float32)
        nearness, weights = data.nearness[chosen].astype(np.float32), data.weights[chosen].astype(np.float32)
        mirrored = random.random(BATCH) < 0.5
        pictures[mirrored] = pictures[mirrored, :, ::-1]
        for values in (kinds, nearness, weights):
            values[mirrored] = values[mirrored, :, ::-1]
        offsets[mirrored] = -offsets[mirrored, :, ::-1]
        gain = random.uniform(0.8, 1.2, (BATCH, 1, 1, 1)) * random.uniform(0.94, 1.06, (BATCH, 1, 1, 3))
        sigma = random.uniform(0, NOISE / 2, (BATCH, 1, 1, 1)).astype(np.float32)
        noise = random.standard_normal(pictures.shape, dtype=np.float32)
        pictures = np.clip(pictures * gain.astype(np.float32) + sigma * noise, 0, 255).round().astype(np.uint8)
        labels = [kinds.astype(np.int64), offsets, nearness, weights]
        yield [folded(torch.from_numpy(pictures)), *(torch.from_numpy(values) for values in labels)]


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
    data: Pictures, passes: int, seed: int, progress: Callable[[str], object], start: Network | None = None
) -> Network:
    """A network that has learnt from pictures, `start` on from what it was.

    The same seed repeats it on one machine with one thread.
    """
    torch.manual_seed(seed)
    random = np.random.default_rng(seed)
    network: Network = (start or Network()).to(memory_format=torch.channels_last)
    rate = RATE if start is None else RATE_ON
    steps = passes * (len(data.pictures) // BATCH)
    optimizer = torch.optim.AdamW(network.parameters(), lr=rate, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, rate, total_steps=steps, pct_start=0.1)
    weights = label_weights(data)
    network.train()
    for done in range(passes):
        sums = []
        for pixels, kinds, offsets, nearness, shares in batches(data, random):
            with torch.autocast("cpu", torch.bfloat16):
                outputs = network(pixels.contiguous(memory_format=torch.channels_last))
            loss = loss_of(outputs.float(), kinds, offsets, nearness, shares, weights)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            sums.append(loss.item())
        progress(f"pass {done + 1} of {passes}: loss {np.mean(sums):.3f}")
    network.eval()
    return network
