"""Sources of a camera's frames, and single images as PNG, TIFF and H.264 key frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from threewe.data.video import KeyFrameDecoder, most_pixels, only_frame
from threewe.errors import ConfigError, ContractError


class FrameSource(Protocol):
    """The frames of one camera in one episode."""

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, channels): 3 channels of colour, 1 of depth."""

    def __len__(self) -> int: ...

    def packet(self, i: int) -> bytes | None:
        """Frame i as an H.264 access unit (Annex B, a key frame, its SPS and PPS in band); None if it was kept raw."""

    def image(self, i: int) -> NDArray[Any]:
        """Frame i: `(height, width, 3)` uint8 RGB, or `(height, width)` uint16 of a depth camera [mm]."""


class ArrayFrames:
    """Frames that are in memory: `(frames, height, width, 3)` uint8 RGB, or `(frames, height, width)` uint16 [mm]."""

    def __init__(self, images: NDArray[Any]) -> None:
        colour = images.ndim == 4 and images.shape[3] == 3 and images.dtype == np.uint8
        depth = images.ndim == 3 and images.dtype == np.uint16
        if not colour and not depth:
            kinds = "(frames, height, width, 3) of uint8 or (frames, height, width) of uint16"
            raise ContractError(f"images must be {kinds}, not {images.shape} of {images.dtype}")
        self.images = images

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, channels)."""
        height, width = self.images.shape[1:3]
        return int(height), int(width), 3 if self.images.ndim == 4 else 1

    def __len__(self) -> int:
        return len(self.images)

    def packet(self, i: int) -> None:
        """None: there are no packets."""

    def image(self, i: int) -> NDArray[Any]:
        """Frame i."""
        image: NDArray[Any] = self.images[i]
        return image


class PacketFrames:
    """Frames that are H.264 key frames in memory, in Annex B with SPS and PPS; decoded one at a time when asked for."""

    def __init__(self, packets: Sequence[bytes], shape: tuple[int, int, int]) -> None:
        self.packets, self.shape = packets, shape
        self._decoder: KeyFrameDecoder | None = None

    def __len__(self) -> int:
        return len(self.packets)

    def packet(self, i: int) -> bytes:
        """Frame i as it was encoded."""
        return self.packets[i]

    def image(self, i: int) -> NDArray[Any]:
        """Frame i `(height, width, 3)` uint8 RGB. Raises ConfigError where it does not decode."""
        import av

        self._decoder = self._decoder or KeyFrameDecoder(self.shape, "rgb24")
        try:
            return self._decoder.decode(self.packets[i])
        except (av.FFmpegError, ValueError) as error:
            raise ConfigError(f"frame {i}: no H.264 key frame: {error}") from None


def encode_image(image: NDArray[Any]) -> bytes:
    """PNG of `(height, width, 3)` uint8 RGB; TIFF of `(height, width)` uint16, which loses nothing either."""
    import av

    name, given, stored = ("tiff", "gray16le", "gray16le") if image.ndim == 2 else ("png", "rgb24", "rgb24")
    encoder = av.VideoCodecContext.create(name, "w")
    encoder.height, encoder.width = image.shape[:2]
    encoder.pix_fmt, encoder.time_base = stored, _seconds(1)
    encoder.options = {"compression_algo": "deflate"} if image.ndim == 2 else {}
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format=given)
    return b"".join(bytes(packet) for packet in [*encoder.encode(frame), *encoder.encode(None)])


def decode_image(content: bytes, shape: tuple[int, ...], where: str) -> NDArray[Any]:
    """PNG, JPEG or TIFF of this shape: as `encode_image` takes it. Raises ConfigError."""
    import av

    kinds = {b"\x89PNG": "png", b"\xff\xd8\xff": "mjpeg", b"II*\x00": "tiff", b"MM\x00*": "tiff"}
    kind = next((kinds[start] for start in kinds if content.startswith(start)), None)
    if kind is None:
        raise ConfigError(f"{where}: neither PNG, JPEG nor TIFF")
    decoder = av.VideoCodecContext.create(kind, "r")
    decoder.options = {"max_pixels": most_pixels(shape)}
    decoder.thread_count = 1
    try:
        frame = only_frame(decoder, content)
    except (av.FFmpegError, ValueError) as error:
        raise ConfigError(f"{where}: no {kind} image of {shape[1]}x{shape[0]}: {error}") from None
    if (frame.height, frame.width) != tuple(shape[:2]):
        raise ConfigError(f"{where}: {frame.width}x{frame.height} pixels; features say {shape[1]}x{shape[0]}")
    image: NDArray[Any] = frame.to_ndarray(format="rgb24" if shape[2] == 3 else "gray16le")
    if shape[2] != 3 and frame.format.name not in ("gray16le", "gray16be"):
        raise ConfigError(f"{where}: {frame.format.name}; depth has 16 bits a pixel")
    return image


def _seconds(rate: int) -> Any:
    from fractions import Fraction

    return Fraction(1, rate)
