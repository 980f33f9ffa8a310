"""H.264 intra frames: each picture is a key frame with its parameter sets, so that every one can be decoded, repeated,
left out or copied into an MP4 file without the others."""

from __future__ import annotations

import logging
import threading
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from threewe import _core

if TYPE_CHECKING:
    import av

logger = logging.getLogger("threewe")


def most_pixels(shape: Sequence[int]) -> str:
    """`max_pixels` of a decoder of frames (height, width, ...): that of its buffers, which are aligned."""
    return str((shape[0] + 64) * (shape[1] + 64))


OPTIONS = {
    "preset": "ultrafast",
    "tune": "zerolatency",  # a packet comes out for each picture that goes in
    "crf": "23",
    "x264-params": "keyint=1:scenecut=0:repeat-headers=1:annexb=1",
}


class KeyFrameEncoder:
    """Compresses pictures of one even size, each by itself.

    Args:
        shape: (height, width, 3).
        format: of the pixels, `bgr24` as in 3we or `rgb24` as in datasets.
    """

    def __init__(self, shape: tuple[int, ...], format: str) -> None:
        import av
        from av.video.reformatter import VideoReformatter

        self._format, self._reformatter = format, VideoReformatter()
        self._context = av.CodecContext.create("libx264", "w")
        self._context.height, self._context.width = shape[:2]
        self._context.pix_fmt = "yuv420p"
        self._context.time_base = Fraction(1, 90_000)
        self._context.thread_count = 1
        self._context.options = dict(OPTIONS)
        self._count = 0

    def encode(self, picture: NDArray[np.uint8]) -> bytes:
        """An Annex B access unit of (height, width, 3) uint8."""
        import av

        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format=self._format)
        frame = self._reformatter.reformat(frame, format="yuv420p", threads=1)
        frame.pts = self._count
        self._count += 1
        [packet] = self._context.encode(frame)
        return bytes(packet)


class KeyFrameDecoder:
    """Decodes such access units, in any order; takes no more memory than pictures of this size need.

    Args:
        shape: (height, width, 3).
        format: of the pixels, `bgr24` or `rgb24`.
    """

    def __init__(self, shape: tuple[int, ...], format: str) -> None:
        import av

        self._format = format
        self._context: av.VideoCodecContext = av.VideoCodecContext.create("h264", "r")
        self._context.options = {"max_pixels": most_pixels(shape)}
        self._context.thread_count = 1

    def decode(self, packet: bytes) -> NDArray[np.uint8]:
        """(height, width, 3) uint8. Raises ValueError, or av.FFmpegError, where there is no such frame in it."""
        frame = only_frame(self._context, packet)
        self._context.flush_buffers()
        return np.asarray(frame.to_ndarray(format=self._format), np.uint8)


def only_frame(decoder: av.VideoCodecContext, content: bytes) -> av.VideoFrame:
    """The frame of a packet. Raises ValueError where there is none, or another."""
    import av

    frames: list[av.VideoFrame] = [*decoder.decode(av.Packet(content)), *decoder.decode(None)]
    if len(frames) != 1:
        raise ValueError(f"{len(frames)} frames in it")
    return frames[0]


class EncoderThread(threading.Thread):
    """Compresses a recorder's images for as long as it is open. Where that fails they are kept raw."""

    def __init__(self, recorder: _core.Recorder) -> None:
        super().__init__(name="threewe video encoder", daemon=True)
        self._recorder = recorder
        self._encoders: dict[tuple[int, int, tuple[int, ...]], KeyFrameEncoder] = {}

    def run(self) -> None:
        """Until the recorder is closed."""
        while (frame := self._recorder.next_frame()) is not None:
            packet = None
            try:
                packet = self._encode(frame)
            except Exception:
                logger.exception("images are recorded uncompressed, since their encoder failed")
                self._recorder.detach_encoder()
            if packet is None:
                self._recorder.put_raw(frame)
            else:
                self._recorder.put_packet(frame, packet)

    def _encode(self, frame: _core.RecordingFrame) -> bytes | None:
        """The access unit; None for sizes that 4:2:0 video does not have."""
        color = frame.color
        height, width = color.shape[:2]
        if height % 2 or width % 2 or height * width == 0:
            return None
        key = (frame.robot, frame.sensor, color.shape)
        if key not in self._encoders:
            self._encoders[key] = KeyFrameEncoder(color.shape, "bgr24")
        return self._encoders[key].encode(color)

    def end(self) -> None:
        """Waits for it."""
        self._recorder.detach_encoder()
        if self.is_alive() and threading.current_thread() is not self:
            self.join()
