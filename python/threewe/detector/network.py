"""Convolutional network of the detector, in PyTorch: the form that is trained. `threewe.detector.weights` writes the
integer form, which the robot runs.

A feature pyramid: features of 1/4 to 1/32 of the picture's size, the coarse ones added back to those of 1/8, and for
each cell there the logits of its label, the column of its thing's centre and its nearness.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from threewe.detector.pictures import LABELS

OUTPUTS = len(LABELS) + 2
"""Logits, then the offset to the centre's column [4 cells] and the nearness [1/m]."""


class Layer(nn.Module):
    """A convolution, batch normalization and ReLU. With `add`, another layer's output is added before the ReLU."""

    def __init__(self, inputs: int, outputs: int, size: int = 3, stride: int = 1) -> None:
        super().__init__()
        self.convolution = nn.Conv2d(inputs, outputs, size, stride, size // 2, bias=False)
        self.normalization = nn.BatchNorm2d(outputs)

    def forward(self, features: Tensor, add: Tensor | None = None) -> Tensor:
        """(N, inputs, H, W) to (N, outputs, H / stride, W / stride)."""
        x = self.normalization(self.convolution(features))
        return torch.relu(x if add is None else x + add)


class Network(nn.Module):
    """(N, 12, H/2, W/2) of a picture / 255, every 2 x 2 pixels in the channels, to (N, OUTPUTS, H/8, W/8)."""

    def __init__(self) -> None:
        super().__init__()
        self.stem = Layer(12, 32, stride=2)
        self.down_8 = Layer(32, 64, stride=2)
        self.a_8, self.b_8 = Layer(64, 64), Layer(64, 64)
        self.down_16 = Layer(64, 80, stride=2)
        self.a_16, self.b_16 = Layer(80, 80), Layer(80, 80)
        self.down_32 = Layer(80, 112, stride=2)
        self.a_32, self.b_32 = Layer(112, 112), Layer(112, 112)
        self.up_16 = Layer(112, 80, size=1)
        self.c_16 = Layer(80, 80)
        self.up_8 = Layer(80, 64, size=1)
        self.c_8, self.d_8 = Layer(64, 64), Layer(64, 64)
        self.head = nn.Conv2d(64, OUTPUTS, 1)

    def forward(self, pixels: Tensor) -> Tensor:
        """See the class."""
        x = self.down_8(self.stem(pixels))
        at_8 = self.b_8(self.a_8(x), x)
        x = self.down_16(at_8)
        at_16 = self.b_16(self.a_16(x), x)
        x = self.down_32(at_16)
        at_32 = self.b_32(self.a_32(x), x)
        x = self.c_16(twice(self.up_16(at_32), at_16) + at_16)
        x = self.c_8(twice(self.up_8(x), at_8) + at_8)
        return self.head(self.d_8(x))


def twice(features: Tensor, like: Tensor) -> Tensor:
    """Features of twice the size, each repeated, cut to that of others."""
    x = features.repeat_interleave(2, 2).repeat_interleave(2, 3)
    return x[:, :, : like.shape[2], : like.shape[3]]


def folded(pictures: Tensor) -> Tensor:
    """(N, H, W, 3) uint8 BGR to the network's input."""
    n, height, width, _ = pictures.shape
    x = pictures.reshape(n, height // 2, 2, width // 2, 2, 3).permute(0, 2, 4, 5, 1, 3)
    return x.reshape(n, 12, height // 2, width // 2).float() / 255
