"""Video of one episode before it is put into a file with others: encoded, or copied from packets or another file."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from threewe.data.lerobot.depth import quantize
from threewe.data.lerobot.frames import FrameSource
from threewe.data.video import KeyFrameEncoder
from threewe.errors import ContractError

if TYPE_CHECKING:
    import av

KEPT_IN_MEMORY = 64 * 2**20
"""[bytes] of an episode's packets; what is more goes to a temporary file."""

REORDERED = 64
"""Frames that a packet's time of decoding can be before its own, by which a file is searched."""

ENCODERS: dict[str, tuple[str, str, dict[str, str]]] = {
    "av1": ("libsvtav1", "yuv420p", {"g": "2", "crf": "30", "preset": "10", "svtav1-params": "fast-decode=0"}),
    "h264": ("h264", "yuv420p", {"g": "2", "crf": "30"}),
    "depth": ("hevc", "gray12le", {"g": "2", "crf": "30", "x265-params": "lossless=1:log-level=error"}),
}
"""Encoder, pixel format and options, as LeRobot 0.6.1 sets them: by default AV1, and lossless HEVC for depth.

LeRobot asks for preset 12. SVT-AV1 3.0, which it comes with, makes 10 of that, to the same bits; newer ones would make
11 of it, and larger files: 6 % instead of 3 % at the same quality.
"""

ENCODER_INFO: dict[str, dict[str, Any]] = {
    "av1": {"g": 2, "crf": 30, "preset": 12, "extra_options": {}},
    "h264": {"g": 2, "crf": 30, "preset": None, "extra_options": {}},
    "depth": {"g": 2, "crf": 30, "preset": None, "extra_options": {"x265-params": "lossless=1"}},
    "copy": {"g": 1, "crf": None, "preset": None, "extra_options": {}},
}
"""What LeRobot notes of them in `info.json`, with its own preset; in a copy each frame is a key frame."""


@dataclass(frozen=True)
class StreamParameters:
    """What has to be equal in all packets of one video file."""

    codec: str
    width: int
    height: int
    pix_fmt: str
    headers: bytes


class Clip(Protocol):
    """Frames of one episode, in the order of decoding, that can be copied into a file."""

    size: int
    frames: int

    @property
    def parameters(self) -> StreamParameters:
        """Of the stream."""

    def stream(self) -> Any:
        """A context manager that gives a stream to make another like it."""

    def packets(self) -> Iterator[av.Packet]:
        """Packets whose times count frames of this episode from 0."""

    def close(self) -> None:
        """Lets go of what it holds."""


class PacketClip:
    """Copies key frames of a source one by one; those that were kept raw are encoded like the others."""

    def __init__(self, source: FrameSource, fps: int, scratch: Path) -> None:
        self.frames, self.fps = len(source), fps
        self.lengths: list[int] = []
        self.spool = tempfile.SpooledTemporaryFile(max_size=KEPT_IN_MEMORY, dir=str(scratch))  # noqa: SIM115 (closed with the clip)
        try:
            self._fill(source)
        except BaseException:
            self.spool.close()
            raise

    def _fill(self, source: FrameSource) -> None:
        encoder: KeyFrameEncoder | None = None
        self.first = b""
        for i in range(len(source)):
            packet = source.packet(i)
            if packet is None:
                encoder = encoder or KeyFrameEncoder(source.shape, "rgb24")
                packet = encoder.encode(source.image(i))
            self.first = self.first or packet
            self.lengths.append(len(packet))
            self.spool.write(packet)
        self.size = sum(self.lengths)
        with self.stream() as stream:
            self.parameters = parameters_of(stream)
        if (self.parameters.height, self.parameters.width) != source.shape[:2]:
            found = f"{self.parameters.width}x{self.parameters.height}"
            raise ContractError(f"packets have {found} pixels; the source says {source.shape[1]}x{source.shape[0]}")

    @contextmanager
    def stream(self) -> Iterator[Any]:
        """The stream of its first packet."""
        import av

        try:
            with av.open(io.BytesIO(self.first), format="h264") as container:
                yield container.streams.video[0]
        except (av.FFmpegError, IndexError) as error:
            raise ContractError(f"the first packet is no H.264 key frame with SPS and PPS: {error}") from None

    def packets(self) -> Iterator[av.Packet]:
        """All of them."""
        import av

        self.spool.seek(0)
        for i, length in enumerate(self.lengths):
            packet = av.Packet(self.spool.read(length))
            packet.pts = packet.dts = i
            packet.duration = 1
            packet.time_base = _period(self.fps)
            packet.is_keyframe = True
            yield packet

    def close(self) -> None:
        """Forgets the packets."""
        self.spool.close()


class FileClip:
    """Frames of a file, `start` frames after its beginning."""

    def __init__(self, path: Path, fps: int, frames: int, start: int = 0, size: int = 0) -> None:
        self.path, self.fps, self.frames, self.start = path, fps, frames, start
        with self.stream() as stream:
            self.parameters = parameters_of(stream)
        self.size = size or path.stat().st_size

    @contextmanager
    def stream(self) -> Iterator[Any]:
        """The file's stream."""
        import av

        with av.open(str(self.path), format="mp4") as container:
            yield container.streams.video[0]

    def packets(self) -> Iterator[av.Packet]:
        """Those from `start` on, counted from 0."""
        import av

        with av.open(str(self.path), format="mp4") as container:
            stream = container.streams.video[0]
            period = _period(self.fps) / stream.time_base
            if self.start:
                container.seek(round(max(self.start - REORDERED, 0) * period), stream=stream)
            taken = 0
            for packet in container.demux(stream):
                if packet.pts is None or packet.dts is None or round(packet.pts / period) < self.start:
                    continue
                if taken == self.frames:
                    break
                taken += 1
                copy = av.Packet(bytes(packet))
                copy.pts = round(packet.pts / period) - self.start
                copy.dts = round(packet.dts / period) - self.start
                copy.duration, copy.time_base = 1, _period(self.fps)
                copy.is_keyframe = packet.is_keyframe
                yield copy

    def close(self) -> None:
        """Nothing is open."""


def encode(
    source: FrameSource, path: Path, fps: int, codec: str, info: Mapping[str, Any], on_image: Any = None
) -> FileClip:
    """Encodes a source into a file by one of ENCODERS; `on_image(i, image)` sees each image on its way.

    `info` is that of the feature, with the scale of depths.
    """
    import av

    os.environ.setdefault("SVT_LOG", "1")  # errors; else it prints its settings at each start
    name, pix_fmt, options = ENCODERS[codec]
    with av.open(str(path), "w", format="mp4") as output:
        stream: Any = output.add_stream(name, fps, options=options)
        stream.height, stream.width = source.shape[:2]
        stream.pix_fmt = pix_fmt
        for i in range(len(source)):
            image = source.image(i)
            if on_image is not None:
                on_image(i, image)
            frame = quantize(image, info) if codec == "depth" else av.VideoFrame.from_ndarray(image, format="rgb24")
            output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    return FileClip(path, fps, len(source))


def parameters_of(stream: Any) -> StreamParameters:
    """Of an opened stream."""
    context = stream.codec_context
    headers = bytes(context.extradata or b"")
    name = stream.codec.canonical_name
    return StreamParameters(name, context.width, context.height, context.pix_fmt or "", headers)


def _period(fps: int) -> Any:
    from fractions import Fraction

    return Fraction(1, fps)
