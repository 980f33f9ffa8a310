"""LeRobot datasets, v3.0 and v2.1, without LeRobot: write, read, edit, convert and validate them."""

from threewe.data.lerobot.dataset import Dataset, Episode
from threewe.data.lerobot.editing import append, convert, filter_episodes, merge, split
from threewe.data.lerobot.features import Feature
from threewe.data.lerobot.frames import ArrayFrames, FrameSource, PacketFrames
from threewe.data.lerobot.info import Info
from threewe.data.lerobot.validating import Problem, validate
from threewe.data.lerobot.video_track import VideoTrack
from threewe.data.lerobot.writer import DatasetWriter

__all__ = [
    "ArrayFrames",
    "Dataset",
    "DatasetWriter",
    "Episode",
    "Feature",
    "FrameSource",
    "Info",
    "PacketFrames",
    "Problem",
    "VideoTrack",
    "append",
    "convert",
    "filter_episodes",
    "merge",
    "split",
    "validate",
]
