"""Writes LeRobot datasets, v3.0 as LeRobot 0.6.1 does and v2.1, without LeRobot."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from threewe.data.lerobot.cameras import CODECS, Codec, clip_of, files_of, with_video_info
from threewe.data.lerobot.clips import Clip
from threewe.data.lerobot.dataset import Dataset
from threewe.data.lerobot.features import DEFAULT_FEATURES, Feature, parse_features
from threewe.data.lerobot.frames import FrameSource
from threewe.data.lerobot.info import VERSIONS, Info, Version
from threewe.data.lerobot.layout import Before, EpisodeRow, Layout, layout_of
from threewe.data.lerobot.replacing import linked_folder, replace_folder, require_free, state_of, working_folder
from threewe.data.lerobot.stats import table_stats
from threewe.errors import ConfigError, ContractError


class DatasetWriter:
    """Writes a dataset into a folder beside `root`, which takes that name when all of it is there.

    ```python
    features = {"action": {"dtype": "float32", "shape": (2,), "names": ["v", "w"]},
                "observation.images.front": {"dtype": "video", "shape": (480, 640, 3)}}
    with DatasetWriter("my_dataset", fps=10, features=features, robot_type="3we_standard_v2") as writer:
        writer.add_episode({"action": actions}, "go to the kitchen", {"observation.images.front": frames})
    ```

    An episode is durable when `close` has returned: files are synchronized and the folder is renamed. A program that
    dies earlier leaves a folder `.NAME.partial-*`, which no reader takes for a dataset, and no `root`. Where the block
    of a `with` raises, everything is removed.

    `codec` is that of colour videos: "copy" takes over H.264 packets and encodes what has none in the same way, "av1"
    and "h264" encode everything, as LeRobot does ("av1" is its default). Depth videos are HEVC in 12-bit codes (see
    `threewe.data.lerobot.depth`); an `image` feature with `info={"is_depth_map": True}` keeps depth lossless.

    Raises ConfigError for features or options that no dataset has, and where `root` exists already.
    """

    def __init__(
        self,
        root: str | Path,
        *,
        fps: int,
        features: Mapping[str, Any],
        robot_type: str | None = None,
        version: Version = "v3.0",
        codec: Codec = "copy",
        chunks_size: int = 1000,
        data_files_size_in_mb: float = 100,
        video_files_size_in_mb: float = 200,
    ) -> None:
        self.root = Path(root)
        if version not in VERSIONS:
            raise ConfigError(f"version {version!r}: known are {', '.join(VERSIONS)}")
        if codec not in CODECS:
            raise ConfigError(f"codec {codec!r}: known are {', '.join(CODECS)}")
        if type(fps) is not int or not 1 <= fps <= 1000:
            raise ConfigError(f"fps must be a whole number from 1 to 1000, as LeRobot keeps it, not {fps!r}")
        own = parse_features(features, "features")
        if taken := own.keys() & DEFAULT_FEATURES:
            raise ConfigError(f"features: {', '.join(sorted(taken))} are filled in by the writer: leave them out")
        require_free(self.root)
        everything = {**{name: _with_unit(feature) for name, feature in own.items()}, **DEFAULT_FEATURES}
        self.info = Info(
            version,
            fps,
            everything,
            robot_type,
            chunks_size=chunks_size,
            data_files_size_in_mb=data_files_size_in_mb,
            video_files_size_in_mb=video_files_size_in_mb,
        ).in_version(version)
        self.codec = codec
        self.tasks: list[str] = []
        self.rows: list[EpisodeRow] = []
        self.before: Before | None = None
        self.folder = working_folder(self.root)
        self.layout: Layout = layout_of(self.folder, self.info)
        self.closed = False

    @classmethod
    def append(cls, root: str | Path, *, codec: Codec | None = None) -> DatasetWriter:
        """Continues a dataset, also one that LeRobot wrote: `with DatasetWriter.append("my_dataset") as writer: ...`.

        New episodes get new files. Until `close` returns, and where the program dies, the dataset is as it was: the new
        one is made beside, of links to the old files, and changes places with it in one step. `codec` is that of the
        videos that are there (AV1, or else "copy"), unless given. Raises ConfigError where there is no sound dataset.
        """
        there = Dataset.open(root)
        known = {str(feature.info.get("video.codec")) for feature in there.features.values() if not feature.is_depth}
        writer = cls.__new__(cls)
        writer.root, writer.info = there.root, there.info
        writer.codec = codec or ("av1" if "av1" in known else "copy")
        if writer.codec not in CODECS:
            raise ConfigError(f"codec {codec!r}: known are {', '.join(CODECS)}")
        total = there.stats() if there.version == "v3.0" else {}
        writer.before = Before([episode.row for episode in there.episodes], total, state_of(there.root))
        writer.tasks, writer.rows, writer.closed = list(there.tasks), [], False
        writer.folder = linked_folder(there.root)
        writer.layout = layout_of(writer.folder, writer.info)
        writer.layout.resume(writer.before)
        return writer

    def add_episode(
        self,
        columns: Mapping[str, Any],
        task: str | Sequence[str],
        videos: Mapping[str, FrameSource] | None = None,
    ) -> int:
        """Adds an episode and returns its number.

        `columns` has an array `(frames, *shape)` for each feature that is a column (`(frames,)` for shape `(1,)`), and
        texts for strings; `videos` a source of as many frames for each camera, be its feature `video` or `image`.
        `task` is one text, or one a frame. Raises ContractError for missing or wrong ones, and then nothing was added;
        OSError where the disk is full or fails, and then the dataset is given up: it never gets its name.
        """
        if self.closed:
            raise ContractError("the dataset is closed")
        videos = dict(videos or {})
        length = self._length_of(columns, videos)
        tasks = [task] * length if isinstance(task, str) else list(task)
        if len(tasks) != length or not all(isinstance(text, str) for text in tasks):
            raise ContractError(f"task must be a text, or {length} of them, one a frame")
        values = {name: self._checked(name, columns[name], length) for name in self._numbers()}
        known = list(dict.fromkeys([*self.tasks, *tasks]))
        values |= self._counted(length, [known.index(text) for text in tasks])
        stats = table_stats({**values, "timestamp": np.arange(length) / self.info.fps}, self.info.features)
        with ExitStack() as stack:
            scratch = Path(stack.enter_context(tempfile.TemporaryDirectory(dir=self.folder, prefix="encoding-")))
            clips: dict[str, Clip] = {}
            for name in self.info.cameras:
                feature, file = self.info.features[name], scratch / f"{name}.mp4"
                clips[name], stats[name] = clip_of(videos[name], feature, self.codec, self.info.fps, file)
                stack.callback(clips[name].close)
            for name, feature in self.info.columns.items():
                if feature.is_camera:
                    values[name], stats[name] = files_of(videos[name], feature)
            ordered = {name: stats[name] for name in self.info.features if name in stats}
            row = EpisodeRow(self.episodes, list(dict.fromkeys(tasks)), length, self.frames, ordered)
            with self._all_or_nothing():
                self.layout.add(row, values, clips)
        self.tasks = known
        self.rows.append(row)
        return row.index

    @property
    def episodes(self) -> int:
        """How many there are so far, those of a dataset that is continued among them."""
        return len(self._all_rows)

    @property
    def frames(self) -> int:
        """Frames of all episodes so far."""
        return self._all_rows[-1].start + self._all_rows[-1].length if self._all_rows else 0

    @property
    def _all_rows(self) -> list[EpisodeRow]:
        return [*(self.before.rows if self.before else []), *self.rows]

    def close(self) -> None:
        """Completes the dataset under its name. Raises ConfigError where no episode was added, or the name is taken."""
        if self.closed:
            return
        if not self.rows:
            self.abort()
            raise ConfigError(f"{self.root}: a dataset needs an episode at least; none was added")
        if self.before is None:
            require_free(self.root)
        elif self.before.state != state_of(self.root):
            self.abort()
            raise ConfigError(f"{self.root}: was changed while episodes were appended to it; append them again")
        info = replace(self.info, features=self._described(), total_episodes=self.episodes)
        info = replace(info, total_frames=self.frames, total_tasks=len(self.tasks))
        with self._all_or_nothing():
            self.layout.close(info, self.tasks, self.rows)
            replace_folder(self.folder, self.root)
        self.closed = True

    def abort(self) -> None:
        """Gives up: removes what was written."""
        if not self.closed:
            self.closed = True
            with suppress(Exception):  # of a disk that is full
                self.layout.abandon()
            shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()

    @contextmanager
    def _all_or_nothing(self) -> Iterator[None]:
        """Where files can't be written to the end, the whole dataset is given up."""
        import av

        try:
            yield
        except BaseException as error:
            self.abort()
            if isinstance(error, av.FFmpegError) and not isinstance(error, OSError):
                raise ConfigError(f"{self.root}: a video cannot be written: {error}") from None
            raise

    def _numbers(self) -> list[str]:
        names = self.info.columns.items()
        return [name for name, feature in names if not feature.is_camera and name not in DEFAULT_FEATURES]

    def _length_of(self, columns: Mapping[str, Any], videos: Mapping[str, FrameSource]) -> int:
        cameras = {name for name, feature in self.info.features.items() if feature.is_camera}
        for given, wanted, what in (
            (columns.keys(), {*self._numbers()}, "columns"),
            (videos.keys(), cameras, "videos"),
        ):
            if missing := sorted(wanted - given):
                raise ContractError(f"{what}: {', '.join(missing)} missing")
            if unknown := sorted(given - wanted):
                raise ContractError(f"{what}: {', '.join(unknown)} not among the features")
        lengths = {name: len(values) for name, values in {**columns, **videos}.items()}
        if len(set(lengths.values())) != 1 or not next(iter(lengths.values())):
            raise ContractError(f"an episode has one length, and at least a frame; given are {lengths or 'none'}")
        for name in cameras:
            if tuple(videos[name].shape) != self.info.features[name].shape:
                shape = self.info.features[name].shape
                raise ContractError(f"{name}: frames have shape {tuple(videos[name].shape)}; the feature says {shape}")
        return next(iter(lengths.values()))

    def _checked(self, name: str, values: Any, length: int) -> Any:
        feature = self.info.features[name]
        if feature.dtype == "string":
            if wrong := [value for value in values if not isinstance(value, str)]:
                raise ContractError(f"{name}: {wrong[0]!r:.60} is no text")
            return list(values)
        array = np.asarray(values)
        if not np.can_cast(array.dtype, np.dtype(feature.dtype), "same_kind"):
            raise ContractError(f"{name}: {array.dtype} does not fit into {feature.dtype}")
        shape = (length,) if feature.shape == (1,) else (length, *feature.shape)
        if array.shape not in (shape, (length, *feature.shape)):
            raise ContractError(f"{name}: shape {array.shape}; the feature says {shape}")
        array = array.reshape(shape).astype(feature.dtype)
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            row = int(np.argwhere(~np.isfinite(array))[0][0])
            raise ContractError(f"{name}: frame {row} is not finite, and no policy can learn from that")
        return array

    def _counted(self, length: int, tasks: list[int]) -> dict[str, NDArray[Any]]:
        """The columns that number the frames; the time is that of the frame in its episode [s]."""
        return {
            "timestamp": (np.arange(length) / self.info.fps).astype(np.float32),
            "frame_index": np.arange(length),
            "episode_index": np.full(length, self.episodes),
            "index": np.arange(self.frames, self.frames + length),
            "task_index": np.array(tasks),
        }

    def _described(self) -> dict[str, Feature]:
        """Features with what LeRobot says of their videos."""
        if self.before is not None:
            return dict(self.info.features)
        described = dict(self.info.features)
        for name, found in self.layout.parameters.items():
            described[name] = with_video_info(described[name], found, self.codec, self.info.fps)
        return described


def _with_unit(feature: Feature) -> Feature:
    """Depth is in millimetres; LeRobot notes that."""
    if not feature.is_depth:
        return feature
    return replace(feature, info={"is_depth_map": True, "depth_unit": "mm", **feature.info})
