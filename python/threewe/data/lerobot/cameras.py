"""A camera's frames on their way into a dataset: as a clip of a video or as files in the table, with statistics."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

from threewe.data.lerobot.clips import ENCODER_INFO, Clip, PacketClip, StreamParameters, encode
from threewe.data.lerobot.dataset import TableImages
from threewe.data.lerobot.depth import same_scale, scale_of
from threewe.data.lerobot.features import Feature
from threewe.data.lerobot.frames import FrameSource, encode_image
from threewe.data.lerobot.stats import PixelCounts, Stats, frames_stats
from threewe.data.lerobot.video_track import VideoTrack

Codec = Literal["copy", "h264", "av1"]
CODECS: tuple[Codec, ...] = ("copy", "h264", "av1")


def clip_of(source: FrameSource, feature: Feature, codec: Codec, fps: int, file: Path) -> tuple[Clip, Stats]:
    """A source's frames for a video, copied or encoded into `file`, and their statistics."""
    clip = copied(source, feature, fps) if codec == "copy" or feature.is_depth else None
    if clip is None and codec == "copy" and not feature.is_depth:
        clip = PacketClip(source, fps, file.parent)
    if clip is not None:
        return clip, source_stats(source, feature)
    counts = PixelCounts(len(source), feature)
    return encode(source, file, fps, "depth" if feature.is_depth else codec, feature.info, counts.add), counts.stats()


def copied(source: FrameSource, feature: Feature, fps: int) -> Clip | None:
    """The packets of another dataset, where they mean the same here."""
    if not isinstance(source, VideoTrack) or (feature.is_depth and not same_scale(source.feature.info, feature.info)):
        return None
    return source.clip(fps)


def files_of(source: FrameSource, feature: Feature) -> tuple[list[bytes], Stats]:
    """A source's frames for the table, as PNG or TIFF, and their statistics."""
    if isinstance(source, TableImages):
        return [source.file_of(i) for i in range(len(source))], source_stats(source, feature)
    return [encode_image(source.image(i)) for i in range(len(source))], source_stats(source, feature)


def source_stats(source: FrameSource, feature: Feature) -> Stats:
    """Statistics of a source's images: those that a dataset has of them already, where they have quantiles."""
    known: Stats | None = getattr(source, "stats", None)
    shape = (source.shape[2], 1, 1)
    if known is not None and all(known[key].shape == shape for key in known if key != "count") and "q50" in known:
        return known
    return frames_stats(source.image, len(source), feature)


def with_video_info(feature: Feature, found: StreamParameters, codec: Codec, fps: int) -> Feature:
    """A feature with what LeRobot says of a video: of its stream, and of how it was encoded."""
    noted = ENCODER_INFO["depth" if feature.is_depth else codec]
    info = {
        "video.height": found.height,
        "video.width": found.width,
        "video.codec": found.codec,
        "video.pix_fmt": found.pix_fmt,
        "video.fps": fps,
        "video.channels": 1 if feature.is_depth else 3,
        "has_audio": False,
        **{f"video.{key}": value for key, value in noted.items() if key != "extra_options"},
        "video.fast_decode": 0,
        "video.video_backend": "pyav",
        "video.extra_options": noted["extra_options"],
        **(scale_of(feature.info) if feature.is_depth else {}),
        "is_depth_map": feature.is_depth,
    }
    if codec == "copy":  # what a dataset says of how its packets came about stays true
        names = {f"video.{key}" for key in ENCODER_INFO["copy"]}
        info |= {key: value for key, value in feature.info.items() if key in names}
    return replace(feature, info={**feature.info, **info})
