"""Pictures of what goes on in the robot's mind: a map that grows, a loop that closes, a robot that was carried away.

    python 11_mind.py

leaves mind_map.png, mind_loop.png and mind_lost.png in the current folder. It needs `pip install "threewe[demo]"`.
"""

import argparse
import asyncio
import tempfile
from pathlib import Path

import numpy as np
import threewe
from PIL import Image
from threewe import Robot, drawing
from threewe.slam import Slam, SlamConfig, read_log, synthesize

BEFORE, AFTER = (206, 92, 92, 255), (40, 110, 200, 255)


def beside(pictures: list[Image.Image], gap: int = 12) -> Image.Image:
    """One next to the other."""
    width = sum(picture.width for picture in pictures) + gap * (len(pictures) - 1)
    row = Image.new("RGB", (width, pictures[0].height), "white")
    left = 0
    for picture in pictures:
        row.paste(picture, (left, 0))
        left += picture.width + gap
    return row


async def growing_map(moments: list[float]) -> Image.Image:
    """A robot explores: its map, the way that it came, and where it is going, at some moments [s]."""
    async with Robot(scene="apartment_v1") as robot:
        view = drawing.View.of(robot.simulation.scene, 420)
        pictures, trail = [], []

        def look(progress: threewe.Progress) -> None:
            trail.append((progress.pose.x, progress.pose.y))
            if len(pictures) == len(moments) or robot.now < moments[len(pictures)]:
                return
            picture = drawing.draw_map(robot.get_map(), view)
            drawing.draw_path(picture, view, trail, drawing.TRAIL)
            drawing.draw_path(picture, view, robot.get_path(), drawing.PLAN, dashed=True)
            drawing.draw_robot(picture, view, progress.pose, robot.profile)
            pictures.append(drawing.finish(picture))

        await robot.explore(timeout=moments[-1] + 1.0, on_progress=look)
    return beside(pictures)


def closed_loop(survey: str) -> Image.Image:
    """A log is mapped: where the robot is known to have been in the end; and, ten times as far from there as it was,
    where it believed to be at each scan.
    """
    with tempfile.TemporaryDirectory() as folder:
        path, _ = synthesize(survey, Path(folder), seed=0)
        log = read_log(path)
    slam = Slam(SlamConfig(base_from_lidar=log.base_from_lidar))
    steps = zip(log.times, log.scans, log.odometry, strict=True)
    then = np.array([[*slam.add(scan, odometry, time)][:2] for time, scan, odometry in steps])
    times, known = np.hsplit(slam.trajectory()[:, :3], [1])

    grid = slam.map()
    low = np.array(grid.origin)
    high = low + np.array([grid.width, grid.height]) * grid.resolution
    view = drawing.View((low[0], low[1]), (high[0], high[1]), 1300 / (high[0] - low[0]))
    picture = drawing.draw_map(grid, view)
    drawing.draw_path(picture, view, known + 10.0 * (then - known), BEFORE, 0.12)
    drawing.draw_path(picture, view, known, AFTER, 0.12)
    for earlier, later in slam.closures().times:
        ends = [known[np.searchsorted(times[:, 0], time)] for time in (earlier, later)]
        drawing.draw_path(picture, view, ends, drawing.PLAN, 0.05)
    return drawing.finish(picture)


async def carried_away() -> Image.Image:
    """A robot in a given map is carried somewhere else: where it believed to be, and where it finds itself."""
    async with Robot(scene="apartment_v1") as robot:
        await robot.explore()
        given = robot.get_map()
        elsewhere = robot.simulation.sample_free_pose(seed=3)
    async with Robot(scene="apartment_v1", map=given, initial_pose=(0.0, 0.0, 0.0)) as robot:
        view = drawing.View.of(robot.simulation.scene, 700)
        picture = drawing.draw_map(given, view)
        drawing.draw_robot(picture, view, robot.get_pose(), robot.profile, BEFORE)
        robot.simulation.carry(elsewhere)
        began = robot.now
        while not robot.lost and robot.now < began + 10.0:
            await robot.sleep(0.1)
        print(f"noticed after {robot.now - began:.1f} s")
        while robot.lost and robot.now < began + 30.0:
            await robot.sleep(0.1)
        print(f"found itself after {robot.now - began:.1f} s")
        drawing.draw_robot(picture, view, robot.get_pose(), robot.profile, AFTER)
    return drawing.finish(picture)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--quick", action="store_true", help="less to see")
    quick = arguments.parse_args().quick
    asyncio.run(growing_map([1.0, 2.0] if quick else [1.0, 15.0, 45.0, 100.0])).save("mind_map.png")
    closed_loop("laboratory" if quick else "office_loop").save("mind_loop.png")
    asyncio.run(carried_away()).save("mind_lost.png")


if __name__ == "__main__":
    main()
