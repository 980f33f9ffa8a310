"""Video files that hold many episodes, written packet by packet."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from threewe.data.lerobot.clips import Clip, StreamParameters

if TYPE_CHECKING:
    import av

MIB = 2**20


class VideoFile:
    """An MP4 that grows by clips with the same stream parameters; readable once it is closed."""

    def __init__(self, path: Path, fps: int, clip: Clip) -> None:
        import av

        path.parent.mkdir(parents=True, exist_ok=True)
        self.path, self.fps = path, fps
        self.frames = self.size = 0
        self.parameters: StreamParameters = clip.parameters
        self.output: Any = av.open(str(path), "w", format="mp4", options={"movflags": "faststart"})
        with clip.stream() as template:
            self.stream = self.output.add_stream_from_template(template, opaque=True)
        self.stream.time_base = _time_base(fps)
        self.append(clip)

    def takes(self, clip: Clip, limit: float) -> bool:
        """Whether a clip can be added without the file passing `limit` [MiB]."""
        return clip.parameters == self.parameters and self.size + clip.size < limit * MIB

    def append(self, clip: Clip) -> tuple[int, int]:
        """Adds a clip; its first frame in this file, and the one behind its last."""
        start = self.frames
        for packet in clip.packets():
            self._mux(packet, start)
        self.frames += clip.frames
        self.size += clip.size
        return start, self.frames

    def close(self) -> None:
        """Writes the tables that make it a file."""
        self.output.close()

    def _mux(self, packet: av.Packet, start: int) -> None:
        packet.pts = (packet.pts or 0) + start
        packet.dts = (packet.dts or 0) + start
        packet.stream = self.stream
        self.output.mux(packet)


class VideoFiles:
    """The files of one camera: a clip goes into the last one, or into the next where it does not fit."""

    def __init__(self, fps: int, limit: float) -> None:
        self.fps, self.limit = fps, limit
        self.last: VideoFile | None = None

    def add(self, clip: Clip, next_path: Any) -> tuple[bool, int, int]:
        """Whether a file was begun, at `next_path()`, and the clip's frames there, from and to."""
        if self.last is not None and self.last.takes(clip, self.limit):
            return False, *self.last.append(clip)
        self.close()
        self.last = VideoFile(next_path(), self.fps, clip)
        return True, 0, clip.frames

    def close(self) -> None:
        """Completes the last file."""
        if self.last is not None:
            self.last.close()
        self.last = None


def _time_base(fps: int) -> Any:
    """One of FFmpeg's for MP4: frames at whole ticks, at least 10,000 a second."""
    from fractions import Fraction

    ticks = fps
    while ticks < 10_000:
        ticks *= 2
    return Fraction(1, ticks)
