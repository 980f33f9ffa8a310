"""Messages of Foxglove's schemas."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from numpy.typing import NDArray

from threewe._core import CameraIntrinsics, Pose2D

OPTICAL = (-0.5, 0.5, -0.5, 0.5)
"""x, y, z, w: from an optical frame (z ahead, x right, y down) to one that looks along x with z up."""


def stamped(message: Any, time: int, frame: str | None = None) -> Any:
    """The message with its time [ns since 1970] and frame."""
    message.timestamp.FromNanoseconds(time)
    if frame is not None:
        message.frame_id = frame
    return message


def transform(parent: str, child: str, place: Pose2D, height: float, time: int) -> FrameTransform:
    """parent_from_child."""
    made: FrameTransform = stamped(FrameTransform(parent_frame_id=parent, child_frame_id=child), time)
    made.translation.x, made.translation.y, made.translation.z = place.x, place.y, height
    made.rotation.z, made.rotation.w = math.sin(place.theta / 2), math.cos(place.theta / 2)
    return made


def optical_transform(parent: str, child: str, time: int) -> FrameTransform:
    """From a camera's optical frame to its body, which looks along x."""
    made: FrameTransform = stamped(FrameTransform(parent_frame_id=parent, child_frame_id=child), time)
    made.translation.SetInParent()
    made.rotation.x, made.rotation.y, made.rotation.z, made.rotation.w = OPTICAL
    return made


def transforms(*parts: FrameTransform) -> FrameTransforms:
    """Several in one message."""
    return FrameTransforms(transforms=parts)


def pose(place: Pose2D, frame: str, time: int) -> PoseInFrame:
    """A pose on the floor."""
    made: PoseInFrame = stamped(PoseInFrame(), time, frame)
    made.pose.position.x, made.pose.position.y = place.x, place.y
    made.pose.orientation.z, made.pose.orientation.w = math.sin(place.theta / 2), math.cos(place.theta / 2)
    return made


def scan(
    ranges: NDArray[np.float32], angle_min: float, angle_increment: float, range_max: float, frame: str, time: int
) -> LaserScan:
    """Where nothing came back the range is infinite, where it is invalid NaN: as viewers want it, who draw neither."""
    shown = np.where(ranges <= 0.0, np.nan, np.where(ranges >= np.float32(range_max), np.inf, ranges))
    made: LaserScan = stamped(LaserScan(ranges=shown.tolist()), time, frame)
    made.start_angle, made.end_angle = angle_min, angle_min + (len(ranges) - 1) * angle_increment
    made.pose.orientation.w = 1.0
    return made


def calibration(camera: CameraIntrinsics, frame: str, time: int) -> CameraCalibration:
    """Of a pinhole without distortion."""
    k = [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
    p = [camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    made = CameraCalibration(width=camera.width, height=camera.height, K=k, R=r, P=p)
    stamped(made, time, frame)
    return made


def video(packet: bytes, frame: str, time: int) -> CompressedVideo:
    """An H.264 access unit, Annex B."""
    made: CompressedVideo = stamped(CompressedVideo(data=packet, format="h264"), time, frame)
    return made


def image(pixels: NDArray[Any], encoding: str, frame: str, time: int) -> RawImage:
    """Of encoding `bgr8`, or `16UC1` for depth [mm]."""
    packed = np.ascontiguousarray(pixels)
    made = RawImage(width=packed.shape[1], height=packed.shape[0], encoding=encoding, step=packed.strides[0])
    made.data = packed.tobytes()
    stamped(made, time, frame)
    return made
