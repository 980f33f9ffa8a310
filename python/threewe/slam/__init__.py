"""Mapping on its own: scans and odometry in, poses and a map out; logs, and how well they are mapped."""

from __future__ import annotations

from threewe._core import LogSpec, SlamConfig, SlamEvent, log_names
from threewe.slam.carmen import read_carmen, write_carmen
from threewe.slam.formats import read_log
from threewe.slam.log import Log
from threewe.slam.mapper import Slam
from threewe.slam.relations import Accuracy, Relations, accuracy, relation_errors
from threewe.slam.replay import Replay, replay
from threewe.slam.ros_map import load_map, save_map
from threewe.slam.synth import synthesize

__all__ = [
    "Accuracy",
    "Log",
    "LogSpec",
    "Relations",
    "Replay",
    "Slam",
    "SlamConfig",
    "SlamEvent",
    "accuracy",
    "load_map",
    "log_names",
    "read_carmen",
    "read_log",
    "relation_errors",
    "replay",
    "save_map",
    "synthesize",
    "write_carmen",
]
