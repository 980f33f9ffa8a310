"""Pictures of what goes on in the autonomy stack: a map that grows, a loop that closes, a kidnapped robot,
the ways that a plan is chosen from, and how a robot gets out where it is stuck.

    python 11_autonomy.py

leaves autonomy_map.png, autonomy_loop.png, autonomy_lost.png, autonomy_fan.png and autonomy_stuck.png in the current
folder. It needs `pip install "threewe[demo]"`.
"""

import argparse
import asyncio
import tempfile
from pathlib import Path

import numpy as np
import threewe
from PIL import Image, ImageDraw
from threewe import Pose2D, Robot, SampledPlan, drawing
from threewe.slam import Slam, SlamConfig, read_log, synthesize

BEFORE, AFTER = (206, 92, 92, 255), (40, 110, 200, 255)
SAMPLE, FAINT, CHOSEN = (190, 196, 206, 255), (160, 194, 232, 255), (16, 40, 110, 255)


def beside(pictures: list[Image.Image], gap: int = 12) -> Image.Image:
    """One next to the other."""
    width = sum(picture.width for picture in pictures) + gap * (len(pictures) - 1)
    row = Image.new("RGB", (width, pictures[0].height), "white")
    left = 0
    for picture in pictures:
        row.paste(picture, (left, 0))
        left += picture.width + gap
    return row


def is_due(robot: Robot, moments: list[float], pictures: list[Image.Image]) -> bool:
    """Is it time [s] for the next picture?"""
    return len(pictures) < len(moments) and robot.now >= moments[len(pictures)]


def draw_drive(
    robot: Robot, pose: Pose2D, view: drawing.View, trajectory: list[tuple[float, float]], width: float
) -> Image.Image:
    """The map, the way that the robot came, where it is going, in lines so wide [m], and the robot."""
    picture = drawing.draw_map(robot.get_map(), view)
    drawing.draw_path(picture, view, trajectory, drawing.TRAJECTORY, width)
    drawing.draw_path(picture, view, robot.get_path(), drawing.PLAN, width, dashed=True)
    drawing.draw_robot(picture, view, pose, robot.profile)
    return picture


def captioned(picture: Image.Image, caption: str) -> Image.Image:
    """The picture at its final size, framed, under a line of text."""
    above, done = 38, drawing.finish(picture)
    page = Image.new("RGB", (done.width, above + done.height), "white")
    page.paste(done, (0, above))
    draw = ImageDraw.Draw(page)
    draw.rectangle((0, above, page.width - 1, page.height - 1), outline=drawing.UNKNOWN)
    draw.text((2, 0), caption, drawing.INK, drawing.text_font(26))
    return page


async def growing_map(moments: list[float]) -> Image.Image:
    """A robot explores: its map, the way that it came, and where it is going, at some moments [s]."""
    async with Robot(scene="apartment_v1") as robot:
        view = drawing.View.of(robot.simulation.scene, 420)
        pictures, trajectory = [], []

        def look(progress: threewe.Progress) -> None:
            trajectory.append((progress.pose.x, progress.pose.y))
            if is_due(robot, moments, pictures):
                pictures.append(drawing.finish(draw_drive(robot, progress.pose, view, trajectory, 0.06)))

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
        robot.simulation.teleport(elsewhere)
        began = robot.now
        while not robot.lost and robot.now < began + 10.0:
            await robot.sleep(0.1)
        print(f"noticed after {robot.now - began:.1f} s")
        while robot.lost and robot.now < began + 30.0:
            await robot.sleep(0.1)
        print(f"found itself after {robot.now - began:.1f} s")
        drawing.draw_robot(picture, view, robot.get_pose(), robot.profile, AFTER)
    return drawing.finish(picture)


def draw_plan(picture: Image.Image, view: drawing.View, plan: SampledPlan, map_from_odom: Pose2D) -> None:
    """All ways that were tried, grey; those that count, the bluer the more; and dark the plan that is their mean."""

    def draw(way: np.ndarray, color: drawing.Color, width: float) -> None:
        points = [map_from_odom.transform((x, y)) for x, y, _ in way]
        drawing.draw_path(picture, view, points, color, width)

    most = plan.weights.max()
    for sample in np.argsort(plan.weights, kind="stable"):
        weight = plan.weights[sample]
        color = SAMPLE
        if weight > 0.0:
            share = 1.0 + np.log(weight / most) / 16.0  # less than exp(-16) of the best counts for nothing
            color = tuple(round(a + share * (b - a)) for a, b in zip(FAINT, AFTER, strict=True))
        draw(plan.trajectories[sample], color, 0.006 if weight == 0.0 else 0.009)
    draw(plan.poses, CHOSEN, 0.03)


async def fan_of_plans(moments: list[float]) -> Image.Image:
    """A robot drives among people: what its plan is chosen from, at some moments [s]."""
    async with Robot(scene="dynamic_v1") as robot:
        pictures = []

        def look(progress: threewe.Progress) -> None:
            plan = robot.get_plan()
            if plan is None or not is_due(robot, moments, pictures):
                return
            map_from_odom = robot.get_transform("map", "odom")
            middle = map_from_odom.transform(plan.poses[len(plan.poses) // 2, :2])
            view = drawing.View((middle[0] - 1.2, middle[1] - 1.1), (middle[0] + 1.2, middle[1] + 1.1), 175)
            picture = drawing.draw_map(robot.get_map(), view)
            draw_plan(picture, view, plan, map_from_odom)
            drawing.draw_path(picture, view, robot.get_path(), drawing.PLAN, 0.02, dashed=True)
            for person in robot.get_people():
                ahead = np.add(person.position, person.velocity)
                way = [map_from_odom.transform(place) for place in (person.position, ahead)]
                drawing.draw_path(picture, view, way, drawing.ROUTE, 0.03)
                drawing.draw_person(picture, view, way[0], 0.2)
            drawing.draw_robot(picture, view, progress.pose, robot.profile)
            pictures.append(captioned(picture, f"{robot.now:.1f} s"))

        await robot.move_to(11.3, -3.2, timeout=moments[-1] + 1.0, on_progress=look)
    return beside(pictures)


async def stuck_robot(moments: list[float]) -> Image.Image:
    """A robot gets stuck in a gap, backs off, and creeps through: what it does at some moments [s]."""
    robot = Robot(scene="cluttered_v1", hardware="turtlebot_like", start_pose=(11.03, 1.12, 0.46), seed=5)
    async with robot:
        view = drawing.View((-4.1, 0.0), (-2.4, 1.5), 196)
        pictures, trajectory = [], []

        def look(progress: threewe.Progress) -> None:
            trajectory.append((progress.pose.x, progress.pose.y))
            if is_due(robot, moments, pictures):
                caption = f"{robot.now:.1f} s: {progress.recovery.name.replace('_', ' ')}"
                pictures.append(captioned(draw_drive(robot, progress.pose, view, trajectory, 0.025), caption))

        result = await robot.move_to(-4.02, -0.11, on_progress=look)
        print(result)
    return beside(pictures)


def save(picture: Image.Image, name: str) -> None:
    """As a small file: few colours are enough."""
    picture.quantize(128).save(name)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--quick", action="store_true", help="less to see")
    quick = arguments.parse_args().quick
    save(asyncio.run(growing_map([1.0, 2.0] if quick else [1.0, 15.0, 45.0, 120.0])), "autonomy_map.png")
    save(closed_loop("laboratory" if quick else "office_loop"), "autonomy_loop.png")
    save(asyncio.run(carried_away()), "autonomy_lost.png")
    save(asyncio.run(fan_of_plans([1.0, 2.0] if quick else [2.0, 3.6, 22.0])), "autonomy_fan.png")
    save(asyncio.run(stuck_robot([1.0, 2.0] if quick else [33.3, 34.9, 48.1, 74.6, 82.0])), "autonomy_stuck.png")


if __name__ == "__main__":
    main()
