"""Record: drives as crash-safe journals, replayed to the bit, and as a dataset that LeRobot loads.

python 13_record.py
"""

import sys
import tempfile
from pathlib import Path

from threewe.data import Recording, TrajectoryRecorder
from threewe.sync import Robot

GOALS = [(2.0, 1.0), (0.5, -0.5), (0.0, 0.0)]


def main(folder: Path) -> None:
    with Robot(image_size=(120, 160)) as robot, TrajectoryRecorder(robot, folder / "recording") as recorder:
        for x, y in GOALS[:1] if "--quick" in sys.argv else GOALS:
            recorder.start_episode(task=f"go to {x}, {y}")
            result = robot.move_to(x, y)
            recorder.end_episode(success=result.success)

    recording = Recording(folder / "recording")
    for episode in recording:
        images = len(episode.camera())
        print(f"{episode.task}: {len(episode.time)} ticks, {len(episode.lidar())} scans, {images} images")
        report = episode.replay()
        print(f"  made anew: {report.max_deviation} m apart after {report.ticks} ticks")
        assert report.first_difference is None

    try:
        import pyarrow  # noqa: F401 (of the extra "data")
    except ModuleNotFoundError:
        print("no dataset: pip install 'threewe[data]'")
        return
    from threewe.data.exporting import export
    from threewe.data.lerobot import validate

    dataset = export(recording, folder / "dataset", "lerobot", fps=10)
    print(f"exported at 10 Hz; {len(validate(dataset))} problems found")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        main(Path(scratch))
