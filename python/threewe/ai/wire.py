"""Messages of openpi's websocket protocol: msgpack, in which a NumPy array is a map of its bytes, type and shape.

As openpi-client packs them (https://github.com/Physical-Intelligence/openpi). A server first sends a map that describes
it; then each message is an observation, and each answer has the array `actions`, or is a text that says what is wrong.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from threewe._extras import needed_for

LARGEST = 64 * 2**20
"""[bytes] of a message"""
KINDS = {"|u1", "<f4", "<f8", "<i4", "<i8", "|b1"}
"""Types of arrays that are read; none is an object."""
ARRAY, NUMBER = b"__ndarray__", b"__npgeneric__"


def pack(content: Any) -> bytes:
    """A message."""
    with needed_for("policies over the network", "policy"):
        import msgpack
    return bytes(msgpack.packb(content, default=_packed))


def unpack(message: bytes) -> Any:
    """What a message says. Raises ValueError for one that says nothing, or has arrays of other sizes than it says."""
    with needed_for("policies over the network", "policy"):
        import msgpack
    try:
        return msgpack.unpackb(message, object_hook=_unpacked)
    except (msgpack.UnpackException, ValueError, TypeError, KeyError, RecursionError, OverflowError) as error:
        raise ValueError(f"no message of openpi's protocol: {type(error).__name__}: {error}") from None


def _packed(value: Any) -> Any:
    if isinstance(value, np.ndarray) and value.dtype.str in KINDS:
        return {ARRAY: True, b"data": value.tobytes(), b"dtype": value.dtype.str, b"shape": value.shape}
    raise TypeError(f"{type(value).__name__} cannot be sent")


def _unpacked(content: dict[Any, Any]) -> Any:
    if ARRAY not in content and NUMBER not in content:
        return content
    kind = content[b"dtype"]
    if kind not in KINDS:
        raise ValueError(f"an array of {str(kind)[:20]!r}")
    if NUMBER in content:
        return np.dtype(kind).type(content[b"data"])
    shape, data = content[b"shape"], content[b"data"]
    whole = isinstance(shape, list) and len(shape) <= 8 and all(type(n) is int and 0 <= n < 2**31 for n in shape)
    if not whole or not isinstance(data, bytes) or math.prod(shape) * np.dtype(kind).itemsize != len(data):
        raise ValueError("an array whose bytes do not fit its shape")
    return np.frombuffer(data, kind).reshape(shape)
