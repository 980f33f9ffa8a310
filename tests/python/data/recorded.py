"""A small recording with a red couch ahead, made by a robot in simulation."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threewe import Robot
from threewe.data import Recording, TrajectoryRecorder

SEED = 4  # of these the couch is red
CUPS = "".join(f"  - {{category: cup, shape: mug, pose: [0.2, {0.2 + 0.2 * k}, 0]}}\n" for k in range(4))
SCENE = f"""name: red_room
description: A room with a red couch
starts:
  - [0.6, 1.5, 0]
rooms:
  - {{name: room, min: [0, 0], max: [4, 3], floor: tile, anchor: [1.0, 0.5]}}
walls:
  - {{a: [0, 0], b: [4, 0], thickness: 0.15}}
  - {{a: [4, 0], b: [4, 3], thickness: 0.15}}
  - {{a: [4, 3], b: [0, 3], thickness: 0.15}}
  - {{a: [0, 3], b: [0, 0], thickness: 0.15}}
objects:
{CUPS}  - {{category: couch, shape: two_seat, pose: [3.4, 1.5, 3.1416], name: red_couch}}
"""
SIZE = (96, 128)


@dataclass
class Recorded:
    """A folder of journals, and what the first image shows."""

    folder: Path
    couch: NDArray[np.bool_]  # (H, W) its pixels, while the robot stands
    color: NDArray[np.float64]  # (3,) of them, RGB, as the robot saw them

    @property
    def recording(self) -> Recording:
        return Recording(self.folder)

    def assert_red(self, rgb: NDArray[np.uint8]) -> None:
        """An image of the standing robot: the couch is red, and within 5 % as it was seen."""
        assert rgb.shape == (*SIZE, 3)
        found = rgb[self.couch].mean(axis=0)
        assert found[0] > found[1:].max() + 30
        np.testing.assert_allclose(found, self.color, atol=0.05 * 255)


def record(folder: Path, episodes: int = 2, video: bool = True) -> Recorded:
    """Stands for 0.4 s, then drives in an arc for 0.8 s; the second episode fails."""
    scene = folder / "red_room.yaml"
    folder.mkdir(parents=True)
    scene.write_text(SCENE)

    async def main() -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        async with Robot(hardware="3we_depth_v2", scene=str(scene), image_size=SIZE, seed=SEED) as robot:
            assert robot.simulation is not None
            truth, image = robot.simulation.look(), robot.get_camera_image()
            couch = truth.ids == truth.names.index("red_couch")
            with TrajectoryRecorder(robot, folder / "journals", video=video) as recorder:
                for k in range(episodes):
                    recorder.start_episode(task="go to the couch", metadata={"k": k, "note": "x/y"})
                    await robot.sleep(0.4)
                    robot.set_velocity(0.3, 0.0, 0.4)
                    await robot.sleep(0.8)
                    robot.stop()
                    recorder.end_episode(success=k != 1)
            return couch, image[couch].mean(axis=0)[::-1]

    couch, color = asyncio.run(main())
    return Recorded(folder / "journals", couch, color)
