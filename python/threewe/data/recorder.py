"""Trajectory recorder: what robots sense, are asked for and do, at every tick, in a folder of crash-safe journals."""

from __future__ import annotations

import os
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar

from numpy.typing import ArrayLike

from threewe import _core, sync
from threewe._arguments import as_array, as_list, as_seed, as_switch, as_text
from threewe._loop_thread import LoopThread
from threewe.data.exporting import OnProgress, export
from threewe.data.recording import Recording
from threewe.data.video import EncoderThread
from threewe.errors import ContractError
from threewe.robot import Robot
from threewe.world import World

Metadata = Mapping[str, str | float | int | bool]
T = TypeVar("T")
Recordable = Robot | World | sync.Robot | sync.World | Sequence[Robot]


class TrajectoryRecorder:
    """Records a robot, or several of one world, on any backend: every tick (50 Hz) from `start_episode` to
    `end_episode`, in C++ and outside of the tick where that takes time.

    Each episode is one file. A process that is killed loses at most the last second of the current one and nothing of
    those before; `threewe data recover FOLDER` finishes what was cut off. Colour images are compressed while driving,
    each by itself; where that falls behind on a real robot they are kept raw, and none is dropped.

    Args:
        robot: a connected Robot or World, of `threewe` or of `threewe.sync`, or several Robots of one World.
        folder: where the journals go; a new one in `recordings/`, named after the time, where left out. An existing
            folder gets more episodes.
        sensors: names of those that are recorded, such as `["lidar", "camera"]`; all where left out.
        video: compress colour images as H.264 intra frames; raw, without loss, otherwise.

    Raises:
        ConfigError: a sensor that no robot has.
        RecordingError: the folder cannot be written, or another recorder writes into it.
    """

    def __init__(
        self,
        robot: Recordable,
        folder: str | os.PathLike[str] | None = None,
        *,
        sensors: Sequence[str] | None = None,
        video: bool = True,
    ) -> None:
        self._thread, world, robots = _parts(robot)
        self.folder = Path(folder) if folder is not None else _new_folder()
        names = [] if sensors is None else [as_text("sensors", name) for name in as_list("sensors", sensors)]
        video = as_switch("video", video)
        self._core = self._call(lambda: _core.Recorder(world, str(self.folder), robots, names, video))
        self._encoder = EncoderThread(self._core)
        if video:
            self._encoder.start()
        self._close = weakref.finalize(self, EncoderThread.end, self._encoder)

    def __repr__(self) -> str:
        return f"TrajectoryRecorder('{self.folder}'{', recording' if self.recording else ''})"

    @property
    def recording(self) -> bool:
        """An episode has begun."""
        return self._call(lambda: self._core.recording)

    @property
    def ticks(self) -> int:
        """Of the current episode."""
        return self._call(lambda: self._core.ticks)

    def start_episode(self, task: str = "", metadata: Metadata | None = None) -> int:
        """Begins an episode with the next tick.

        Args:
            task: what the robot is to do, in words.
            metadata: whatever is to be kept beside it.

        Returns:
            Its number, which no other episode of the folder has.

        Raises:
            ContractError: one has begun already.
            RecordingError: the folder cannot be written.
        """
        text, kept = as_text("task", task), _as_metadata(metadata)
        return self._call(lambda: self._core.start_episode(text, kept))

    def end_episode(self, success: bool | None = None, metadata: Metadata | None = None) -> None:
        """Ends the episode; returns when it is safe on the disk.

        Args:
            success: whether the task was done, where that was judged.
            metadata: what is known only now; added to what `start_episode` was given.

        Raises:
            ContractError: none has begun.
            RecordingError: the disk failed. What was written before is safe; see `recover`.
        """
        kept = _as_metadata(metadata)
        judged = None if success is None else as_switch("success", success)
        self._call(lambda: self._core.end_episode(judged, kept))

    def discard_episode(self) -> None:
        """Forgets the episode. Raises ContractError where none has begun."""
        self._call(self._core.discard_episode)

    def record_step(self, *, action: ArrayLike, robot: int = 0) -> None:
        """For loops of your own: keeps `action`, (n,) numbers as you count them, at the present robot time.

        An episode with steps is exported a row a step. What the robot executed is recorded anyway.
        """
        values = as_array("action", action, (None,)).tolist()
        index = as_seed("robot", robot, 32)
        self._call(lambda: self._core.record_step(index, values))

    def set_instruction(self, instruction: str, robot: int = 0) -> None:
        """What the robot is asked to do from now on, where that changes within an episode."""
        text, index = as_text("instruction", instruction), as_seed("robot", robot, 32)
        self._call(lambda: self._core.set_instruction(index, text))

    def set_takeover(self, takeover: bool, robot: int = 0) -> None:
        """Whether a person drives from now on, who corrects a policy; marked in every tick."""
        on, index = as_switch("takeover", takeover), as_seed("robot", robot, 32)
        self._call(lambda: self._core.set_takeover(index, on))

    def export(
        self,
        output: str | os.PathLike[str],
        format: str = "lerobot",
        *,
        fps: float | None = None,
        on_progress: OnProgress | None = None,
        **options: str | bool,
    ) -> Path:
        """Writes all finished episodes for others to read: see `threewe.data.export`."""
        return export(Recording(self.folder), output, format, fps=fps, on_progress=on_progress, **options)

    def _call(self, work: Callable[[], T]) -> T:
        """What a function returns on the robot's thread."""
        return work() if self._thread is None else self._thread.call(work)

    def close(self) -> None:
        """Ends an episode that is still open, without a judgement, and lets go of the folder. Twice does nothing."""
        if not self._close.alive:
            return
        try:
            if self.recording:
                self.end_episode()
        finally:
            self._close()
            self._call(self._core.close)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is not None and self.recording:
            self.end_episode(metadata={"ended_by": kind.__name__})
        self.close()


def _new_folder() -> Path:
    """Where recordings go by default."""
    stamp = time.strftime("%Y%m%d-%H%M%S")
    folder = Path("recordings") / stamp
    number = 1
    while folder.exists():
        number += 1
        folder = Path("recordings") / f"{stamp}-{number}"
    return folder


def _as_metadata(metadata: Metadata | None) -> dict[str, bool | int | float | str]:
    kept = {} if metadata is None else dict(metadata)
    for name, value in kept.items():
        if not isinstance(name, str) or not isinstance(value, bool | int | float | str):
            raise ContractError(f"metadata holds text, numbers and booleans by name, got {name!r}: {value!r}")
        if isinstance(value, int) and not -(2**63) <= value < 2**63:
            raise ContractError(f"metadata {name!r}: {value} has more than 64 bits")
    return kept


def _parts(robot: Recordable) -> tuple[LoopThread | None, _core.World, list[int]]:
    """The thread of a robot of `threewe.sync`, the world, and which of its robots (all where empty)."""
    if isinstance(robot, sync.Robot | sync.World):
        _, world, indices = _parts(robot._target)
        return robot._thread, world, indices
    if isinstance(robot, World):
        return None, robot._world, []
    robots: list[Robot] = [robot] if isinstance(robot, Robot) else as_list("robot", robot)
    for one in robots:
        if not isinstance(one, Robot):
            raise ContractError(f"robot must be a Robot, a World, or a list of Robots, got {one!r}")
        if one._world is not robots[0]._world:
            raise ContractError("robots of several worlds have no common time: a recorder for each")
    if not robots:
        raise ContractError("robot must be a Robot, a World, or a list of Robots, got none")
    return None, robots[0]._world, [one._index for one in robots]
