"""What reaches Rerun: read back from recordings, and compared with the scene, the truth and the robot itself."""

from __future__ import annotations

import asyncio
import io
import itertools
import math
import re
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import command_line
import numpy as np
import pytest
import rerun as rr
import threewe
import threewe.sync
from numpy.typing import NDArray
from PIL import Image
from rerun.chunk import RrdReader
from threewe import OccupancyGrid, Pose2D, Robot, Scene, TickView

from .toy_backend import QuietBackend

RERUN = Path(sys.executable).parent / "rerun"


class Recording:
    """A file, read back without the code that wrote it."""

    def __init__(self, path: Path) -> None:
        self._chunks = list(RrdReader(path).stream().to_chunks())

    @property
    def entities(self) -> set[str]:
        return {chunk.entity_path for chunk in self._chunks}

    def rows(self, entity: str, component: str) -> Iterator[tuple[float, Any]]:
        """(robot time [s], value) in order of time."""
        found = []
        for chunk in self._of(entity, static=False):
            batch = chunk.to_record_batch()
            if component in batch.schema.names:
                times = batch.column("robot_time").cast("int64").to_pylist()
                found += zip(times, batch.column(component).to_pylist(), strict=True)
        return iter([(time / 1e9, value) for time, value in sorted(found, key=lambda row: row[0]) if value is not None])

    def static(self, entity: str, component: str) -> Any:
        """The last value that was set for all times."""
        batches = [chunk.to_record_batch() for chunk in self._of(entity, static=True)]
        values = [b.column(component).to_pylist()[-1] for b in batches if component in b.schema.names]
        return values[-1]

    def _of(self, entity: str, static: bool) -> list[Any]:
        return [c for c in self._chunks if c.entity_path == f"/{entity}" and c.is_static == static]


def is_valid(path: Path) -> bool:
    """By Rerun's own judgement."""
    done = subprocess.run([RERUN, "rrd", "verify", path], capture_output=True, text=True)
    return done.returncode == 0 and "without error" in done.stdout + done.stderr


@dataclass
class Drive:
    """A recording and what another observer saw of the same drive."""

    path: Path
    recording: Recording
    scene: Scene
    grid: OccupancyGrid
    goal: tuple[float, float]
    ticks: dict[int, tuple[Pose2D, Pose2D, threewe.Velocity, threewe.Velocity]] = field(default_factory=dict)
    samples: dict[str, int] = field(default_factory=dict)


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Drive:
    """A noisy robot drives round a corner in the office."""
    path = tmp_path_factory.mktemp("viewer") / "drive.rrd"
    goal = (2.0, 1.0)

    async def run() -> tuple[Any, ...]:
        ticks: dict[int, Any] = {}
        samples: dict[str, int] = {}
        async with Robot(seed=3, viewer=str(path)) as robot:
            truth = robot.simulation
            assert truth is not None

            def look(tick: TickView) -> None:
                poses = truth.true_pose(), tick.pose.map_from_base
                ticks[round(tick.now * 50)] = (*poses, tick.pose.velocity, tick.commanded)
                for sample in tick.samples:
                    name = robot.features.sensors[sample.sensor].name
                    samples[name] = samples.get(name, 0) + 1

            robot.observe(look)
            await robot.move_to(*goal)
            await robot.sleep(1.5)
            return truth.scene, robot.get_map(), goal, ticks, samples

    scene, grid, *rest = asyncio.run(run())
    return Drive(path, Recording(path), scene, grid, *rest)


def test_a_recording_is_complete_when_the_robot_has_disconnected(drive: Drive) -> None:
    assert is_valid(drive.path)


# The scene


def outline_of(half_size: list[float], center: list[float], quaternion: list[float]) -> NDArray[np.float64]:
    """The four corners of an upright box, seen from above."""
    x, y, z, w = quaternion
    assert x == y == 0.0
    theta = 2 * math.atan2(z, w)
    corners = np.array([(1, -1), (1, 1), (-1, 1), (-1, -1)]) * half_size[:2]
    rotation = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
    return corners @ rotation.T + center[:2]


def test_walls_stand_where_they_stand(drive: Drive) -> None:
    parts = [drive.recording.static("scene/walls", f"Boxes3D:{c}") for c in ("half_sizes", "centers", "quaternions")]
    assert len(parts[0]) == len(drive.scene.walls) > 10
    for wall, half_size, center, quaternion in zip(drive.scene.walls, *parts, strict=True):
        corners = outline_of(half_size, center, quaternion)
        np.testing.assert_allclose((corners[0] + corners[1]) / 2, wall.b, atol=1e-5)
        np.testing.assert_allclose((corners[2] + corners[3]) / 2, wall.a, atol=1e-5)
        assert math.dist(corners[0], corners[1]) == pytest.approx(wall.thickness, abs=1e-5)
        assert (center[2] - half_size[2], center[2] + half_size[2]) == pytest.approx((0.0, wall.height), abs=1e-5)


@pytest.mark.parametrize("name", threewe.scene_names())
def test_furniture_stands_where_it_stands(name: str) -> None:
    from threewe._viewer_scene import object_solids

    for thing in Scene.load(name).objects:
        drawn = {type(solid).__name__: solid for solid in object_solids(thing)}
        boxes, rods = ([p for p in thing.prisms if p.shape.name == shape] for shape in ("box", "cylinder"))
        if boxes:
            solid = drawn.pop("Boxes3D")
            parts = [getattr(solid, c).as_arrow_array().to_pylist() for c in ("half_sizes", "centers", "quaternions")]
            for prism, half_size, center, quaternion in zip(boxes, *parts, strict=True):
                expected = [thing.pose.transform(corner) for corner in prism.outline()]
                np.testing.assert_allclose(outline_of(half_size, center, quaternion), expected, atol=1e-5)
                heights = center[2] - half_size[2], center[2] + half_size[2]
                assert heights == pytest.approx((prism.z_min, prism.z_max), abs=1e-5)
        if rods:
            solid = drawn.pop("Cylinders3D")
            parts = [getattr(solid, c).as_arrow_array().to_pylist() for c in ("lengths", "radii", "centers")]
            for prism, length, radius, center in zip(rods, *parts, strict=True):
                middle = thing.pose.transform((prism.pose.x, prism.pose.y))
                np.testing.assert_allclose(center[:2], middle, atol=1e-5)
                assert radius == pytest.approx(prism.radius, abs=1e-5)
                heights = center[2] - length / 2, center[2] + length / 2
                assert heights == pytest.approx((prism.z_min, prism.z_max), abs=1e-5)
        assert not drawn


def test_every_object_is_there_by_its_name(drive: Drive) -> None:
    drawn = {entity for entity in drive.recording.entities if entity.startswith("/scene/objects/")}
    assert drawn == {f"/scene/objects/{thing.name}" for thing in drive.scene.objects}


# The robot


def test_true_and_estimated_poses_are_told_apart(drive: Drive) -> None:
    differ = 0
    for robot, index in (("scene/true_robot", 0), ("map/estimated_robot", 1)):
        rows = list(drive.recording.rows(robot, "Transform3D:translation"))
        assert len(rows) == pytest.approx(len(drive.ticks) / 5, rel=0.05)
        for time, [(x, y, _)] in rows:
            poses = drive.ticks[round(time * 50)]
            assert (x, y) == pytest.approx((poses[index].x, poses[index].y), abs=1e-6)
            differ += (x, y) != pytest.approx((poses[1 - index].x, poses[1 - index].y), abs=1e-6)
    assert differ > 50


@pytest.mark.parametrize(("path", "index"), [("scene/true_path", 0), ("map/estimated_path", 1)])
def test_pieces_join_to_the_whole_path(drive: Drive, path: str, index: int) -> None:
    pieces = [np.array(strips[0])[:, :2] for _, strips in drive.recording.rows(path, "LineStrips3D:strips")]
    for before, after in itertools.pairwise(pieces):
        np.testing.assert_array_equal(before[1], after[0])
    poses = [tick[index] for tick in drive.ticks.values()]
    assert pieces[0][0] == pytest.approx((poses[0].x, poses[0].y), abs=0.1)
    assert pieces[-1][1] == pytest.approx((poses[-1].x, poses[-1].y), abs=0.06)


def test_errors_are_measured_against_the_truth(drive: Drive) -> None:
    for time, [error] in drive.recording.rows("signals/error", "Scalars:scalars"):
        true, estimated, *_ = drive.ticks[round(time * 50)]
        assert error == pytest.approx(math.hypot(true.x - estimated.x, true.y - estimated.y), abs=1e-9)


def test_velocities_are_those_of_the_tick(drive: Drive) -> None:
    for name, index in (("estimated", 2), ("commanded", 3)):
        rows = list(drive.recording.rows(f"signals/velocity/{name}", "Scalars:scalars"))
        assert len(rows) > 50
        for time, values in rows:
            assert values == [*drive.ticks[round(time * 50)][index]]


def test_the_plan_leads_to_the_goal_and_is_gone_in_the_end(drive: Drive) -> None:
    plans = [strips for _, strips in drive.recording.rows("map/plan", "LineStrips3D:strips")]
    assert plans[0][0][-1][:2] == pytest.approx(drive.goal, abs=0.1)
    assert plans[-1] == []


def test_the_map_is_the_robots_own(drive: Drive) -> None:
    *_, (_, [cells]) = drive.recording.rows("map/grid", "GridMap:data")
    *_, (_, [origin]) = drive.recording.rows("map/grid", "GridMap:translation")
    *_, (_, [size]) = drive.recording.rows("map/grid", "GridMap:cell_size")
    assert size == pytest.approx(drive.grid.resolution)
    assert origin[:2] == pytest.approx(drive.grid.origin, abs=1e-5)
    picture = np.array(cells, np.uint8).reshape(drive.grid.height, drive.grid.width, 4)
    upside_down = drive.grid.data[::-1]
    np.testing.assert_array_equal(picture[..., 3] == 0, upside_down == -1)
    np.testing.assert_array_equal((picture == 255).all(axis=-1), upside_down == 0)
    assert (picture[upside_down == 100][:, :3] < 60).all()


def test_every_scan_and_ping_is_drawn(drive: Drive) -> None:
    for name in ("lidar", "ultrasonic_front_left", "ultrasonic_left", "ultrasonic_front_right", "ultrasonic_right"):
        component = "Points3D:positions" if name == "lidar" else "LineStrips3D:strips"
        assert len(list(drive.recording.rows(f"map/{name}", component))) == drive.samples[name] > 10
    charges = [charge for _, [charge] in drive.recording.rows("signals/battery/charge", "Scalars:scalars")]
    assert 90.0 < charges[-1] < charges[0] <= 100.0


def distance_to_box(point: NDArray[np.float64], middle: Pose2D, length: float, width: float) -> float:
    x, y = middle.inverse().transform((float(point[0]), float(point[1])))
    dx, dy = abs(x) - length / 2, abs(y) - width / 2
    outside = math.hypot(max(dx, 0.0), max(dy, 0.0))
    return outside if outside > 0.0 else -max(dx, dy)


async def test_a_turning_robot_draws_its_scans_on_the_walls(tmp_path: Path) -> None:
    """Every beam lies where it hit, though the robot turned by 6 degrees while the lidar turned once."""
    async with Robot(scene="corridor_v1", seed=2, viewer=str(tmp_path / "turn.rrd")) as robot:
        await robot.rotate(3.0)
        assert robot.simulation is not None
        scene, height = robot.simulation.scene, robot.profile.lidar.height  # type: ignore[union-attr]
    boxes = [
        (Pose2D((w.a[0] + w.b[0]) / 2, (w.a[1] + w.b[1]) / 2, math.atan2(w.b[1] - w.a[1], w.b[0] - w.a[0])),
         math.dist(w.a, w.b), w.thickness)
        for w in scene.walls
    ]  # fmt: skip
    parts = [(o.pose * p.pose, p) for o in scene.objects for p in o.prisms if p.z_min <= height <= p.z_max]
    boxes += [(pose, p.length, p.width) for pose, p in parts if p.shape.name == "box"]
    discs = [((pose.x, pose.y), p.radius) for pose, p in parts if p.shape.name == "cylinder"]
    scans = list(Recording(tmp_path / "turn.rrd").rows("map/lidar", "Points3D:positions"))
    assert len(scans) > 20
    off = [
        min(
            min(distance_to_box(point, *box) for box in boxes),
            min((abs(math.dist(point[:2], center) - radius) for center, radius in discs), default=math.inf),
        )
        for _, points in scans[5::5]
        for point in np.array(points)[::7]
    ]
    assert len(off) > 100
    assert np.quantile(off, 0.95) < 0.06  # 0.04 are the lidar's own; drawn from one pose, 0.13 and more


async def test_the_map_lies_in_the_scene_where_it_truly_lies(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    async with Robot(
        scene="corridor_v1", start_pose=(1.0, 0.2, 0.5), initial_pose=(5.0, -3.0, 2.0), noise="ideal", viewer=str(path)
    ) as robot:
        await robot.move_forward(0.5)
    recording = Recording(path)
    [(_, [turn])] = recording.rows("map", "Transform3D:rotation_axis_angle")
    [(_, [(x, y, _)])] = recording.rows("map", "Transform3D:translation")
    scene_from_map = Pose2D(x, y, turn["angle"])
    true = [value[0][:2] for _, value in recording.rows("scene/true_robot", "Transform3D:translation")]
    estimated = [value[0][:2] for _, value in recording.rows("map/estimated_robot", "Transform3D:translation")]
    assert estimated[0] == pytest.approx((5.0, -3.0), abs=0.01)
    np.testing.assert_allclose([scene_from_map.transform(tuple(point)) for point in estimated], true, atol=0.02)


async def test_a_robot_without_a_simulation_has_no_truth_to_show(tmp_path: Path) -> None:
    path = tmp_path / "real.rrd"
    threewe.register_backend("quiet_viewer", QuietBackend)
    async with Robot(backend="quiet_viewer", viewer=str(path)) as robot:
        await robot.move_forward(0.5)
    assert is_valid(path)
    recording = Recording(path)
    assert not [entity for entity in recording.entities if entity.startswith("/scene") or "error" in entity]
    *_, (_, [(x, y, _)]) = recording.rows("map/estimated_robot", "Transform3D:translation")
    assert (x, y) == pytest.approx((0.5, 0.0), abs=0.05)


# Pictures


def pixels_of(blob: list[int]) -> NDArray[Any]:
    return np.array(Image.open(io.BytesIO(bytes(blob))))


def test_a_red_object_is_red_in_rerun() -> None:
    from threewe.viewer import color_image

    bgr = np.full((48, 64, 3), 120, np.uint8)
    bgr[16:32, 16:48] = (0, 0, 255)
    image = color_image(bgr)
    assert isinstance(image, rr.EncodedImage)
    [blob] = image.blob.as_arrow_array().to_pylist()  # type: ignore[union-attr]
    rgb = pixels_of(blob).astype(int)
    assert np.abs(rgb[20:28, 20:44] - (255, 0, 0)).max() < 12
    assert np.abs(rgb[:10] - 120).max() < 12


def test_pictures_are_those_of_the_camera_where_it_was(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    taken: dict[int, tuple[Any, Pose2D]] = {}

    async def run() -> threewe.RobotProfile:
        async with Robot(hardware="3we_depth_v2", noise="ideal", viewer=str(path)) as robot:
            assert robot.simulation is not None
            truth = robot.simulation
            poses = {0: truth.true_pose()}

            def look(tick: TickView) -> None:
                poses[round(tick.now * 100)] = truth.true_pose()
                for sample in tick.samples:
                    if isinstance(sample.data, threewe.RGBDImage):
                        pose = min(poses.items(), key=lambda item: abs(item[0] - 100 * sample.measured))[1]
                        taken[round(tick.now * 50)] = sample.data, pose

            robot.observe(look)
            await robot.rotate(2.0)
            return robot.profile

    camera = asyncio.run(run()).camera
    assert camera is not None
    recording = Recording(path)
    color, depth, place, turn = (
        list(recording.rows(entity, component))
        for entity, component in (
            ("map/camera/color", "EncodedImage:blob"),
            ("map/camera/depth", "DepthImage:buffer"),
            ("map/camera", "Transform3D:translation"),
            ("map/camera", "Transform3D:rotation_axis_angle"),
        )
    )
    assert len(color) == len(place) == len(turn) > 5
    for (time, [jpeg]), (_, [(x, y, z)]), (_, [rotation]) in zip(color, place, turn, strict=True):
        image, pose = taken[round(time * 50)]
        assert np.abs(pixels_of(jpeg).astype(int) - image.color[..., ::-1]).mean() < 6
        expected = pose * camera.base_from_camera
        assert (x, y, z) == pytest.approx((expected.x, expected.y, camera.mount_height), abs=0.02)
        assert math.remainder(rotation["angle"] - expected.theta, math.tau) == pytest.approx(0.0, abs=0.03)
    assert len(depth) > 2
    for time, [millimeters] in depth:
        image, _ = taken[round(time * 50)]
        pixels = np.array(millimeters, np.uint8).view(np.uint16).reshape(image.depth.shape)
        np.testing.assert_allclose(pixels / 1000.0, image.depth, atol=0.00051)


def test_people_are_where_they_walk(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    seen: dict[int, dict[str, Pose2D]] = {}

    async def run() -> None:
        async with Robot(scene="dynamic_v1", viewer=str(path)) as robot:
            assert robot.simulation is not None
            truth = robot.simulation
            robot.observe(lambda tick: seen.update({round(tick.now * 50): {p.name: p.pose for p in truth.people()}}))
            await robot.sleep(2.0)

    asyncio.run(run())
    recording = Recording(path)
    names = list(seen.popitem()[1])
    assert names
    for name in names:
        rows = list(recording.rows(f"scene/people/{name}", "Transform3D:translation"))
        assert len(rows) > 10
        for time, [(x, y, _)] in rows[:-1]:
            pose = seen[round(time * 50)][name]
            assert (x, y) == pytest.approx((pose.x, pose.y), abs=1e-5)


# It only looks


async def test_a_viewer_changes_no_command(tmp_path: Path) -> None:
    async def commands(viewer: str | None) -> list[Any]:
        seen: list[Any] = []
        async with Robot(hardware="3we_depth_v2", seed=5, viewer=viewer) as robot:
            robot.observe(lambda tick: seen.append((tick.now, *tick.commanded, *tick.pose.map_from_base)))
            await robot.move_to(2.0, 1.0)
            robot.set_velocity(0.2, 0.1, 0.5)
            await robot.sleep(1.0)
        return seen

    without = await commands(None)
    assert await commands(str(tmp_path / "run.rrd")) == without
    assert len(without) > 200


async def test_a_robot_that_begins_anew_goes_on_in_the_same_recording(tmp_path: Path) -> None:
    path = tmp_path / "reset.rrd"
    async with Robot(scene="corridor_v1", viewer=str(path)) as robot:
        await robot.move_forward(0.5)
        first = robot.now
        assert robot.simulation is not None
        robot.simulation.reset(seed=1)
        await robot.move_forward(0.5)
        second = robot.now
    assert is_valid(path)
    rows = list(Recording(path).rows("scene/true_robot", "Transform3D:translation"))
    assert rows[-1][0] == pytest.approx(first + second, abs=0.2)
    last, fresh = (max((row for row in rows if row[0] <= first), key=lambda row: row[0]),
                   min((row for row in rows if row[0] > first), key=lambda row: row[0]))  # fmt: skip
    assert last[1][0][0] > 0.45
    assert fresh[1][0][0] < 0.05


async def test_connecting_again_records_anew(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    robot = Robot(scene="corridor_v1", viewer=str(path))
    for _ in range(2):
        async with robot:
            await robot.connect()
            await robot.move_forward(0.3)
        assert is_valid(path)


def test_the_blocking_robot_has_a_viewer_too(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    with threewe.sync.Robot(scene="corridor_v1", hardware="3we_base_v2", viewer=str(path)) as robot:
        robot.move_forward(0.3)
    assert is_valid(path)
    assert "/map/lidar" not in Recording(path).entities
    assert "/map/ultrasonic_front_left" in Recording(path).entities


# What goes wrong is said in one line


def test_unknown_viewers_name_the_nearest() -> None:
    with pytest.raises(threewe.ConfigError, match=r"unknown viewer 'rerum'; did you mean 'rerun'\?"):
        Robot(viewer="rerum")
    with pytest.raises(threewe.ContractError, match="viewer must be a string"):
        Robot(viewer=True)  # type: ignore[arg-type]


def test_a_window_needs_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(threewe.ConfigError, match="there is no display"):
        Robot(viewer="rerun")


async def test_a_file_that_cannot_be_written_connects_nothing(tmp_path: Path) -> None:
    robot = Robot(scene="corridor_v1", viewer=str(tmp_path / "missing" / "run.rrd"))
    with pytest.raises(threewe.ConfigError, match=r"missing/run.rrd"):
        await robot.connect()
    assert not robot.connected


def test_a_missing_package_is_named_with_the_remedy() -> None:
    script = """
import sys
sys.modules["rerun"] = None
import threewe
threewe.Robot()
try:
    threewe.Robot(viewer="rerun")
except threewe.ConfigError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert 'pip install "threewe[viz]"' in done.stdout, done.stderr


# The command


def threewe_command(*arguments: str, cwd: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", "from threewe.cli import main; main()", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=cwd)


def test_view_records_an_exploration(tmp_path: Path) -> None:
    done = command_line.threewe("view", "apartment_v1", "--seconds", "5", "--save", "home.rrd", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "5 robot s" in done.stdout
    assert is_valid(tmp_path / "home.rrd")
    rows = list(Recording(tmp_path / "home.rrd").rows("map/estimated_robot", "Transform3D:translation"))
    assert rows[-1][0] - rows[0][0] == pytest.approx(5.0, abs=0.3)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["ofice_v2", "--save", "x.rrd"], "did you mean 'office_v2'?"),
        (["--save", "x.mp4"], "ends in .rrd, not '.mp4'"),
        (["--save", "x.rrd", "--serve"], "choose one"),
        (["--hardware", "3we_base_v2", "--save", "x.rrd"], "no sensor 'lidar'"),
    ],
)
def test_what_cannot_be_viewed_is_one_line(arguments: list[str], complaint: str, tmp_path: Path) -> None:
    done = command_line.threewe("view", *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert complaint in done.stderr.replace("\n", " ")
    assert "Traceback" not in done.stderr


def listeners(port: int) -> set[str]:
    """The addresses on which somebody listens at a port, as /proc has them."""
    lines = [line.split() for name in ("tcp", "tcp6") for line in Path(f"/proc/net/{name}").read_text().splitlines()]
    listening = [line[1].split(":") for line in lines if line[3] == "0A"]
    return {address for address, at in listening if int(at, 16) == port}


@pytest.mark.parametrize(("option", "addresses"), [("--serve", {"0100007F"}), ("--serve-network", {"00000000"})])
def test_view_serves_browsers_until_ctrl_c(option: str, addresses: set[str], tmp_path: Path) -> None:
    process = threewe_command("view", "corridor_v1", "--seconds", "1", option, cwd=tmp_path)
    assert process.stdout is not None
    address = process.stdout.readline().removeprefix("Rerun viewer: ").strip()
    while "until Ctrl-C" not in (line := process.stdout.readline()):
        assert line, "it ended too early"
    with urllib.request.urlopen(address) as page:
        assert b"Rerun" in page.read()
    page_port, data_port = (int(port) for port in re.findall(r"localhost(?::|%3A)(\d+)", address))
    assert listeners(page_port) == addresses
    assert listeners(data_port) == addresses
    process.send_signal(signal.SIGINT)
    process.communicate()
    assert process.returncode == 0
    assert listeners(page_port) == set()
