"""Depth in videos: LeRobot's logarithmic 12-bit codes (ported there from BEHAVIOR-1K), steps of 1 to 5 mm up to 10 m.

A video of depth is therefore not lossless. Depth that has to stay as measured is an `image` feature: 16-bit TIFF.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from threewe.errors import ConfigError

if TYPE_CHECKING:
    import av

CODES = 4095
DEPTH_INFO: dict[str, Any] = {
    "video.depth_min": 0.01,
    "video.depth_max": 10.0,
    "video.shift": 3.5,
    "video.use_log": True,
}
"""LeRobot's defaults: nearest and farthest depth and the shift of the logarithm [m]."""


def quantize(depth: NDArray[np.uint16], info: Mapping[str, Any]) -> av.VideoFrame:
    """A frame of 12-bit codes for `(height, width)` of depths [mm]."""
    import av

    low, high, shift, logarithmic = _scale(info)
    metres = depth.astype(np.float32) / np.float32(1000)
    if logarithmic:
        codes = (np.log(metres + np.float32(shift)) - low) / (high - low) * CODES
    else:
        codes = (metres - low) / (high - low) * CODES
    rounded = np.rint(codes).clip(0, CODES).astype(np.uint16)
    frame = av.VideoFrame(depth.shape[1], depth.shape[0], "gray12le")
    plane = np.frombuffer(frame.planes[0], np.uint16).reshape(depth.shape[0], -1)
    plane[:, : depth.shape[1]] = rounded
    return frame


def dequantize(frame: av.VideoFrame, info: Mapping[str, Any]) -> NDArray[np.uint16]:
    """`(height, width)` of depths [mm] from a frame of codes."""
    low, high, shift, logarithmic = _scale(info)
    codes = frame.to_ndarray(format="gray12le").astype(np.float32)
    metres = codes * ((high - low) / CODES) + low
    if logarithmic:
        metres = np.exp(metres) - shift
    millimetres: NDArray[np.uint16] = np.rint(metres * 1000).clip(0, 65535).astype(np.uint16)
    return millimetres


def scale_of(info: Mapping[str, Any]) -> dict[str, Any]:
    """What a feature says of its scale, the rest as LeRobot has it."""
    return {name: info.get(name, default) for name, default in DEPTH_INFO.items()}


def same_scale(info: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether codes mean the same depths."""
    return _scale(info) == _scale(other)


def _scale(info: Mapping[str, Any]) -> tuple[float, float, float, bool]:
    """Ends of the scale (of logarithms, if it is logarithmic), shift [m], and whether it is logarithmic."""
    known = scale_of(info)
    numbers = [known[f"video.{name}"] for name in ("depth_min", "depth_max", "shift")]
    if any(type(number) not in (int, float) or not 0 <= number <= 1000 for number in numbers):
        raise ConfigError(
            f"meta/info.json: depth_min, depth_max and shift {numbers!r:.80} must be metres from 0 to 1000"
        )
    low, high, shift = numbers
    if low >= high or low + shift <= 0:
        raise ConfigError(f"meta/info.json: depth_min {low}, depth_max {high} and shift {shift} [m] make no scale")
    if not known["video.use_log"]:
        return low, high, shift, False
    return math.log(low + shift), math.log(high + shift), shift, True
