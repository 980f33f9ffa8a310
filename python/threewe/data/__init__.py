"""Recordings and datasets: record robots crash-safely, export for learning, keep what others wrote in order.

from threewe.data import TrajectoryRecorder

recorder = TrajectoryRecorder(robot)
recorder.start_episode(task="go to the kitchen")
await robot.move_to(2.0, 1.0)
recorder.end_episode(success=True)
recorder.export("dataset_v1", format="lerobot", fps=10)
"""

from threewe._core import ReplayReport
from threewe.data.recorder import TrajectoryRecorder
from threewe.data.recording import CameraTrack, RecordedEpisode, Recording, recover

__all__ = ["CameraTrack", "RecordedEpisode", "Recording", "ReplayReport", "TrajectoryRecorder", "recover"]
