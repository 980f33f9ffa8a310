"""The frames of one camera in one episode of a dataset, decoded from its video file or copied from it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from threewe.data.lerobot.clips import FileClip
from threewe.data.lerobot.depth import dequantize
from threewe.data.lerobot.features import Feature
from threewe.data.lerobot.mp4_boxes import check_mp4
from threewe.data.lerobot.parquet_file import first_line
from threewe.data.lerobot.stats import Stats
from threewe.data.video import most_pixels
from threewe.errors import ConfigError

if TYPE_CHECKING:
    import av
    from av.video.reformatter import VideoReformatter

CODECS = ("h264", "av1", "hevc", "vp9", "mpeg4")
MOST_FRAMES = 2**24
"""Of one file: six days at 30 a second."""


class VideoTrack:
    """A FrameSource over frames `start` to `start + length` of a video file; sequential reading decodes each once."""

    def __init__(self, path: Path, fps: int, feature: Feature, start: int, length: int) -> None:
        self.path, self.fps, self.feature = path, fps, feature
        self.start, self.length = start, length
        self.stats: Stats | None = None
        self._reading: Iterator[tuple[int, av.VideoFrame]] | None = None
        self._last: tuple[int, NDArray[Any]] | None = None
        self._reformatter: VideoReformatter | None = None
        check_mp4(path, MOST_FRAMES)

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, channels)."""
        height, width, channels = self.feature.shape
        return height, width, channels

    def __len__(self) -> int:
        return self.length

    def packet(self, i: int) -> None:
        """None: packets are copied by `clip`, all at once."""

    def image(self, i: int) -> NDArray[Any]:
        """Frame i: `(height, width, 3)` uint8 RGB or `(height, width)` uint16 [mm]. Raises ConfigError."""
        if not 0 <= i < self.length:
            raise IndexError(f"frame {i} of {self.length}")
        if self._last is not None and self._last[0] == i:
            return self._last[1]
        following = 0 if self._last is None else self._last[0] + 1
        if self._reading is None or not following <= i < following + 32:
            self._reading = self.frames(i)
        for number, frame in self._reading:
            if number == i:
                self._last = i, self._pixels(frame)
                return self._last[1]
            if number > i:
                break
        self._reading = self._last = None
        raise ConfigError(
            f"{self.path}: no frame at {(self.start + i) / self.fps:.4f} s, which is frame {i} of the episode"
        )

    def images(self) -> Iterator[tuple[int, NDArray[Any]]]:
        """Numbers and pixels of all frames that the file has for this episode."""
        for number, frame in self.frames():
            yield number, self._pixels(frame)

    def frames(self, first: int = 0) -> Iterator[tuple[int, av.VideoFrame]]:
        """Numbers and frames from `first` on. Raises ConfigError for damage, and for frames at times between."""
        import av

        try:
            with open_video(self.path, self.feature) as container:
                for frame in self._from(container, first):
                    number = self._number(frame)
                    if number >= self.length:
                        return
                    if number >= first:
                        yield number, frame
        except (av.FFmpegError, OSError, ValueError) as error:
            if isinstance(error, ConfigError):
                raise
            raise ConfigError(f"{self.path}: does not decode: {first_line(error)}") from None

    def _from(self, container: Any, first: int) -> Iterator[av.VideoFrame]:
        """Frames from a key frame at or before `first` on.

        A file is searched by times of decoding. Those of key frames can be some frames before their own, so that the
        first one found may be too late; then the search goes back.
        """
        stream = container.streams.video[0]
        for earlier in (0, 4, 64, None):
            wanted = 0 if earlier is None else max(self.start + first - earlier, 0)
            container.seek(round(wanted / self.fps / stream.time_base), stream=stream)
            frames = container.decode(stream)
            frame = next(frames, None)
            if frame is not None and (wanted == 0 or self._number(frame) <= first):
                yield frame
                yield from frames
                return

    def clip(self, fps: int) -> FileClip | None:
        """The packets of these frames to copy; None where they cannot be cut out, or the rate is another."""
        import av

        try:
            with open_video(self.path, self.feature):
                clip = FileClip(self.path, self.fps, self.length, self.start)
            packets = [(packet.pts, packet.is_keyframe, packet.size) for packet in clip.packets()]
        except (av.FFmpegError, OSError) as error:
            raise ConfigError(f"{self.path}: cannot be copied: {first_line(error)}") from None
        complete = sorted(time for time, _, _ in packets if time is not None) == list(range(self.length))
        if fps != self.fps or not complete or not packets[0][1] or packets[0][0] != 0:
            return None
        clip.size = sum(size for _, _, size in packets)
        return clip

    def _number(self, frame: av.VideoFrame) -> int:
        """A frame's number in the episode."""
        if frame.pts is None or frame.time_base is None:
            raise ConfigError(f"{self.path}: a frame without a time")
        position = float(frame.pts * frame.time_base * self.fps)
        if abs(position - round(position)) > 0.01:
            raise ConfigError(
                f"{self.path}: a frame at {position / self.fps:.4f} s, which is none of {self.fps} a second"
            )
        return round(position) - self.start

    def _pixels(self, frame: av.VideoFrame) -> NDArray[Any]:
        if frame.is_corrupt:
            raise ConfigError(f"{self.path}: the frame at {float(frame.time or 0):.4f} s is damaged")
        if (frame.height, frame.width) != self.shape[:2]:
            height, width = self.shape[:2]
            raise ConfigError(
                f"{self.path}: frames of {frame.width}x{frame.height}; meta/info.json says {width}x{height}"
            )
        if self.feature.is_depth:
            return dequantize(frame, self.feature.info)
        if self._reformatter is None:
            from av.video.reformatter import VideoReformatter

            self._reformatter = VideoReformatter()
        return np.asarray(self._reformatter.reformat(frame, format="rgb24", threads=1).to_ndarray(), np.uint8)


def open_video(path: Path, feature: Feature) -> Any:
    """Opens an MP4 for decoding, with decoders that take frames of this size and no larger. Raises ConfigError."""
    import av

    height, width = feature.shape[:2]
    limit = {"max_pixels": most_pixels(feature.shape), "err_detect": "explode"}
    try:
        container = av.open(
            str(path), format="mp4", options={"codec_whitelist": "h264,libdav1d,av1,hevc,vp9,libvpx-vp9,mpeg4"}
        )
    except (av.FFmpegError, ValueError, OSError) as error:
        raise ConfigError(f"{path}: no MP4 file that can be read: {first_line(error)}") from None
    try:
        if not container.streams.video:
            raise ConfigError(f"{path}: no video in it")
        context: Any = container.streams.video[0].codec_context
        if context is None or container.streams.video[0].codec.canonical_name not in CODECS:
            raise ConfigError(f"{path}: of a codec that is not read; known are {', '.join(CODECS)}")
        if (context.height, context.width) != (height, width):
            found = f"{context.width}x{context.height}"
            raise ConfigError(f"{path}: frames of {found}; meta/info.json says {width}x{height}")
        context.options = limit
        context.thread_count = 1
        return container
    except BaseException:
        container.close()
        raise
