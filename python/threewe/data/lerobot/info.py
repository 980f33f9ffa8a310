"""`meta/info.json`: what a LeRobot dataset says about itself."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, cast

from threewe.data.lerobot.features import DEFAULT_FEATURES, LARGEST_COUNT, Feature, parse_features
from threewe.data.lerobot.places import DATA_V21, DATA_V30, VIDEO_V21, VIDEO_V30, Template, inside
from threewe.errors import ConfigError

Version = Literal["v3.0", "v2.1"]
VERSIONS: tuple[Version, ...] = ("v3.0", "v2.1")
LARGEST_JSON = 64 * 2**20
"""[bytes] of a JSON file that is read at once."""


@dataclass(frozen=True)
class Info:
    """A dataset's version, rate, features, counts and limits; those of files are in MiB, as LeRobot counts them."""

    version: Version
    fps: int
    features: Mapping[str, Feature]
    robot_type: str | None = None
    total_episodes: int = 0
    total_frames: int = 0
    total_tasks: int = 0
    chunks_size: int = 1000
    data_files_size_in_mb: float = 100
    video_files_size_in_mb: float = 200
    data_path: Template = field(default_factory=lambda: Template(DATA_V30, "data_path"))
    video_path: Template = field(default_factory=lambda: Template(VIDEO_V30, "video_path"))

    @property
    def cameras(self) -> list[str]:
        """The features whose images are in videos."""
        return [name for name, feature in self.features.items() if feature.dtype == "video"]

    @property
    def columns(self) -> dict[str, Feature]:
        """The features that are columns of the table."""
        return {name: feature for name, feature in self.features.items() if feature.dtype != "video"}

    def to_json(self) -> dict[str, Any]:
        """As LeRobot writes it: 0.6.1 for v3.0, 0.3 for v2.1."""
        features = {name: feature.to_json() for name, feature in self.features.items()}
        counts = {
            "total_episodes": self.total_episodes,
            "total_frames": self.total_frames,
            "total_tasks": self.total_tasks,
        }
        splits = {"splits": {"train": f"0:{self.total_episodes}"}}
        video = {"video_path": self.video_path.text if self.cameras else None}
        if self.version == "v2.1":
            chunks = math.ceil(self.total_episodes / self.chunks_size)
            total = {"total_videos": self.total_episodes * len(self.cameras), "total_chunks": chunks}
            paths = {"data_path": self.data_path.text, **video, "features": features}
            head = {"codebase_version": self.version, "robot_type": self.robot_type}
            return {**head, **counts, **total, "chunks_size": self.chunks_size, "fps": self.fps, **splits, **paths}
        return {
            "codebase_version": self.version,
            "fps": self.fps,
            "features": features,
            **counts,
            "chunks_size": self.chunks_size,
            "data_files_size_in_mb": self.data_files_size_in_mb,
            "video_files_size_in_mb": self.video_files_size_in_mb,
            "data_path": self.data_path.text,
            **video,
            "robot_type": self.robot_type,
            **splits,
        }

    def in_version(self, version: Version) -> Info:
        """The same with the paths of a version."""
        data, video = (DATA_V30, VIDEO_V30) if version == "v3.0" else (DATA_V21, VIDEO_V21)
        return replace(
            self, version=version, data_path=Template(data, "data_path"), video_path=Template(video, "video_path")
        )


def read_info(root: Path) -> Info:
    """Reads and checks `meta/info.json`. Raises ConfigError that names the field."""
    path = inside(root, "meta/info.json")
    raw = read_json(path)
    if not isinstance(raw, dict):
        raise ConfigError(f"{path}: must hold a mapping, not {type(raw).__name__}")
    version = raw.get("codebase_version")
    if version not in VERSIONS:
        raise ConfigError(f"{path}: codebase_version {version!r:.40}; read are {' and '.join(VERSIONS)}")
    features = parse_features(raw.get("features"), str(path))
    for name, default in DEFAULT_FEATURES.items():
        if name not in features or (features[name].dtype, features[name].shape) != (default.dtype, default.shape):
            raise ConfigError(f"{path}: features[{name!r}] must be {default.dtype} with shape {list(default.shape)}")
    info = Info(
        version=cast(Version, version),
        fps=whole(raw, "fps", path, 1, 10_000),
        features=features,
        robot_type=text_or_none(raw, "robot_type", path),
        total_episodes=whole(raw, "total_episodes", path, 0, 10_000_000),
        total_frames=whole(raw, "total_frames", path, 0, LARGEST_COUNT),
        total_tasks=whole(raw, "total_tasks", path, 0, 10_000_000),
        chunks_size=whole(raw, "chunks_size", path, 1, 10_000_000, 1000),
        data_files_size_in_mb=positive(raw, "data_files_size_in_mb", path, 100),
        video_files_size_in_mb=positive(raw, "video_files_size_in_mb", path, 200),
    ).in_version(cast(Version, version))
    info = replace(info, data_path=Template(raw.get("data_path", info.data_path.text), f"{path}: data_path"))
    if info.cameras:
        video = raw.get("video_path") or info.video_path.text
        info = replace(info, video_path=Template(video, f"{path}: video_path"))
    return info


def read_json(path: Path) -> Any:
    """A JSON file's value; NaN and infinities are refused. Raises ConfigError."""
    return parse_json(read_bytes(path), str(path))


def read_json_lines(path: Path) -> list[dict[str, Any]]:
    """A JSON object a line. Raises ConfigError with the line."""
    lines = enumerate(read_bytes(path).split(b"\n"), 1)
    rows = [(number, parse_json(line, f"{path}:{number}")) for number, line in lines if line.strip()]
    for number, row in rows:
        if not isinstance(row, dict):
            raise ConfigError(f"{path}:{number}: must be a mapping, not {type(row).__name__}")
    return [row for _, row in rows]


def read_bytes(path: Path) -> bytes:
    """A file of at most 64 MiB. Raises ConfigError."""
    size = path.stat().st_size
    if size > LARGEST_JSON:
        raise ConfigError(f"{path}: {size} bytes; at most {LARGEST_JSON} are read")
    return path.read_bytes()


def parse_json(content: bytes, where: str) -> Any:
    """A JSON value. Raises ConfigError."""

    def refuse(word: str) -> None:
        raise ValueError(f"{word} is no JSON number")

    try:
        return json.loads(content, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"{where}: no JSON: {error}") from None


def whole(raw: dict[str, Any], name: str, where: Path, least: int, most: int, default: int | None = None) -> int:
    """A whole number within bounds. Raises ConfigError."""
    value = raw.get(name, default)
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if type(value) is not int or not least <= value <= most:
        raise ConfigError(f"{where}: {name} must be a whole number from {least} to {most}, not {value!r:.60}")
    return value


def positive(raw: dict[str, Any], name: str, where: Path, default: float) -> float:
    """A size [MiB]. Raises ConfigError."""
    value = raw.get(name, default)
    if type(value) not in (int, float) or not 0 < value <= LARGEST_COUNT:
        raise ConfigError(f"{where}: {name} must be a positive number, not {value!r:.60}")
    return cast(float, value)


def text_or_none(raw: dict[str, Any], name: str, where: Path) -> str | None:
    """A text, if there is one. Raises ConfigError."""
    value = raw.get(name)
    if value is not None and not isinstance(value, str):
        raise ConfigError(f"{where}: {name} must be text, not {value!r:.60}")
    return value
