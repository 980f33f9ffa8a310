"""What `threewe export` writes: the command, the map, and URDF as its parser reads it."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import command_line
import numpy as np
import pytest
import threewe
from slices import Block, occupied, read_map

OCCUPIED, FREE, UNKNOWN = 0, 254, 205
LIDAR_HEIGHT = 0.135  # [m] of the standard robot


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return command_line.threewe("export", *arguments, cwd=cwd)


@pytest.mark.parametrize("format", ["mjcf", "urdf", "sdf", "usd", "map"])
def test_the_command_writes_what_it_names(format: str, tmp_path: Path) -> None:
    done = run("--format", format, "--scene", "apartment_v1", "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    named = {tmp_path / line for line in done.stdout.splitlines()}
    assert named == {path for path in (tmp_path / "out").rglob("*") if path.is_file()}
    assert named


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--format", "mjfc"], "unknown format 'mjfc'; did you mean 'mjcf'?"),
        (["--format", "usd", "--scene", "ofice_v2"], "did you mean 'office_v2'?"),
        (["--format", "usd", "--robot", "3we_standart_v2"], "did you mean '3we_standard_v2'?"),
        (["--format", "map", "-o", "a_file"], "a_file"),
        ([], "--format"),
    ],
)
def test_what_cannot_be_exported_is_one_line_and_nothing_written(
    arguments: list[str], message: str, tmp_path: Path
) -> None:
    (tmp_path / "a_file").write_text("here")
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr.replace("\n", " ")
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["a_file"]
    assert (tmp_path / "a_file").read_text() == "here"


def test_names_and_objects_give_the_same_files(tmp_path: Path) -> None:
    by_name = threewe.export("corridor_v1", "turtlebot_like", "mjcf", tmp_path / "a")
    scene, robot = threewe.Scene.load("corridor_v1"), threewe.RobotProfile.load("turtlebot_like")
    by_object = threewe.export(scene, robot, "mjcf", tmp_path / "b")
    assert [path.read_bytes() for path in by_name] == [path.read_bytes() for path in by_object]


@pytest.mark.parametrize("scene", threewe.scene_names())
def test_maps_show_what_stands_in_the_plane_of_the_lidar(scene: str, tmp_path: Path) -> None:
    threewe.export(scene, "3we_standard_v2", "map", tmp_path)
    frame, picture = read_map(tmp_path)
    assert set(np.unique(picture)) == {OCCUPIED, FREE, UNKNOWN}
    place = threewe.Scene.load(scene)
    blocks = [wall_block(wall) for wall in place.walls]
    blocks += [prism_block(place_of, prism) for place_of in place.objects for prism in place_of.prisms]
    assert np.array_equal(occupied(blocks, frame, LIDAR_HEIGHT), picture == OCCUPIED)
    column, row = (int(-start / frame.resolution) for start in frame.origin)
    assert picture[row, column] == FREE


def wall_block(wall: Any) -> Block:
    (ax, ay), (bx, by) = wall.a, wall.b
    size = (float(np.hypot(bx - ax, by - ay)), wall.thickness, wall.height)
    return Block("", "box", ((ax + bx) / 2, (ay + by) / 2, wall.height / 2), float(np.arctan2(by - ay, bx - ax)), size)


def prism_block(thing: Any, prism: Any) -> Block:
    pose = thing.pose * prism.pose
    middle = (pose.x, pose.y, (prism.z_min + prism.z_max) / 2)
    height = prism.z_max - prism.z_min
    if prism.shape == type(prism).Shape.cylinder:
        return Block("", "cylinder", middle, 0.0, (prism.radius, prism.radius, height))
    return Block("", "box", middle, pose.theta, (prism.length, prism.width, height))


def urdf_of(path: Path) -> Any:
    parser = pytest.importorskip("urdf_parser_py.urdf", reason="not shown: urdf-parser-py is not installed")
    return parser.URDF.from_xml_string(path.read_bytes())


def test_the_scene_as_urdf_has_the_same_slice(tmp_path: Path) -> None:
    threewe.export("office_v2", "3we_standard_v2", "urdf", tmp_path)
    threewe.export("office_v2", "3we_standard_v2", "map", tmp_path)
    (link,) = urdf_of(tmp_path / "scene.urdf").links
    blocks = [urdf_block(part) for part in link.collisions if not part.name.startswith("floor")]
    frame, picture = read_map(tmp_path)
    assert np.array_equal(occupied(blocks, frame, LIDAR_HEIGHT), picture == OCCUPIED)


def urdf_block(part: Any) -> Block:
    shape = part.geometry
    x, y, z = part.origin.xyz
    is_box = hasattr(shape, "size")
    size = tuple(shape.size) if is_box else (shape.radius, shape.radius, shape.length)
    return Block(part.name, "box" if is_box else "cylinder", (x, y, z), part.origin.rpy[2], size)


@pytest.mark.parametrize("name", threewe.profile_names())
def test_a_robot_as_urdf_has_the_mass_the_wheels_and_the_sensors_of_its_profile(name: str, tmp_path: Path) -> None:
    threewe.export("apartment_v1", name, "urdf", tmp_path)
    robot, profile = urdf_of(tmp_path / "robot.urdf"), threewe.RobotProfile.load(name)
    assert robot.get_root() == "base_footprint"
    assert sum(link.inertial.mass for link in robot.links if link.inertial) == pytest.approx(profile.mass, rel=1e-14)
    wheels = [joint for joint in robot.joints if joint.type == "continuous"]
    assert len(wheels) == (4 if profile.kinematics == threewe.Kinematics.holonomic else 2)
    frames = {joint.child: joint.origin for joint in robot.joints if joint.type == "fixed"}
    for sensor, (pose, height) in mounts(profile).items():
        assert frames[sensor].xyz == pytest.approx([pose.x, pose.y, height], abs=1e-12)
        assert frames[sensor].rpy == pytest.approx([0, 0, pose.theta], abs=1e-12)
    shell = next(part for part in robot.link_map["base_link"].collisions if part.name == "shell")
    corners = np.array(profile.footprint)
    assert shell.geometry.size[:2] == pytest.approx(np.ptp(corners, axis=0))
    assert shell.origin.xyz[2] + shell.geometry.size[2] / 2 == pytest.approx(profile.height)
    text = (tmp_path / "robot.urdf").read_text()
    assert text.count('<command_interface name="velocity">') == len(wheels)


def mounts(profile: threewe.RobotProfile) -> dict[str, tuple[threewe.Pose2D, float]]:
    """Where the profile's sensors are, and how high."""
    found = {}
    if profile.lidar:
        found["lidar"] = (profile.lidar.base_from_lidar, profile.lidar.height)
    if profile.camera:
        found["camera"] = (profile.camera.base_from_camera, profile.camera.mount_height)
    if profile.ultrasonics:
        found |= {name: (pose, profile.ultrasonics.height) for name, pose in profile.ultrasonics.mounts.items()}
    return found
