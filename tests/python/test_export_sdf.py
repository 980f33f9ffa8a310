"""Exported Gazebo worlds and models, as Debian's sdformat parser reads them: strictly, against SDF 1.9."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import threewe
from slices import Block, occupied, read_map
from test_export import LIDAR_HEIGHT, OCCUPIED, mounts

ROOT = Path(__file__).resolve().parents[2]

NEWER_THAN_1_9 = {"gz_frame_id", "optical_frame_id"}


@pytest.fixture(scope="module")
def sdf_dump(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The parser, compiled against libsdformat."""
    if shutil.which("pkg-config") is None or subprocess.run(["pkg-config", "--exists", "sdformat12"]).returncode:
        pytest.skip("not shown: libsdformat-dev is not installed")
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", "sdformat12"], capture_output=True, text=True)
    program = tmp_path_factory.mktemp("sdf") / "sdf_dump"
    source = ROOT / "tests/cpp/export/sdf_dump.cpp"
    subprocess.run(["c++", "-std=c++17", source, "-o", program, *flags.stdout.split()], check=True)
    return program


def lines_of(program: Path, file: Path, folder: Path) -> list[list[str]]:
    done = subprocess.run([program, file, folder / "models"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return [line.split() for line in done.stdout.splitlines() if line]


def numbers(words: list[str]) -> list[float]:
    return [float(word) for word in words]


def test_a_world_is_read_without_a_complaint_and_has_the_cells_of_the_scene(sdf_dump: Path, tmp_path: Path) -> None:
    threewe.export("dynamic_v1", "3we_standard_v2", "sdf", tmp_path)
    threewe.export("dynamic_v1", "3we_standard_v2", "map", tmp_path)
    lines = lines_of(sdf_dump, tmp_path / "world.sdf", tmp_path)
    assert not [line for line in lines if line[0] == "error"]
    blocks = []
    for word, model, name, *rest in lines:
        if word == "collision" and model in ("walls", "furniture"):
            kind, values = rest[0], numbers(rest[1:])
            assert values[6:8] == [0, 0]  # upright
            blocks.append(Block(name, kind, tuple(values[3:6]), values[8], tuple(values[:3])))
    frame, picture = read_map(tmp_path)
    assert np.array_equal(occupied(blocks, frame, LIDAR_HEIGHT), picture == OCCUPIED)
    links = {line[1] for line in lines if line[0] == "link"}
    people = {f"person_{person.name}" for person in threewe.Scene.load("dynamic_v1").people}
    assert links == {"floor", "walls", "furniture", "ceiling", "3we_standard_v2", *people}


@pytest.mark.parametrize("name", threewe.profile_names())
def test_a_model_has_the_mass_the_wheels_and_the_sensors_of_its_profile(
    name: str, sdf_dump: Path, tmp_path: Path
) -> None:
    threewe.export("apartment_v1", name, "sdf", tmp_path)
    profile = threewe.RobotProfile.load(name)
    lines = lines_of(sdf_dump, tmp_path / "models" / name / "model.sdf", tmp_path)
    complaints = [" ".join(line) for line in lines if line[0] == "error"]
    newer = {
        match[1] for line in complaints if (match := re.search(r"XML Element\[(\w+)\].* not defined in SDF", line))
    }
    assert len(complaints) == sum("not defined in SDF" in line for line in complaints), complaints
    assert newer <= NEWER_THAN_1_9
    links = {line[2]: numbers(line[3:]) for line in lines if line[0] == "link"}
    assert sum(link[0] for link in links.values()) == pytest.approx(profile.mass, rel=1e-14)
    joints = [line for line in lines if line[0] == "joint"]
    assert len(joints) == len(links) - 1 == (4 if profile.kinematics == threewe.Kinematics.holonomic else 2)
    for _, _, parent, child, *axis in joints:
        assert parent == "base_link"
        assert child in links
        assert numbers(axis) == [0, 1, 0]
    sensors = {line[1]: (line[2], numbers(line[3:])) for line in lines if line[0] == "sensor"}
    for sensor, (pose, height) in mounts(profile).items():
        assert sensors[sensor][1][1:] == pytest.approx([pose.x, pose.y, height, 0, 0, pose.theta], abs=1e-12)
    if profile.lidar:
        assert sensors["lidar"][0] == "gpu_lidar"
        assert sensors["lidar"][1][0] == pytest.approx(1 / profile.lidar.turn)
    if profile.camera:
        assert sensors["camera"][0] == ("rgbd_camera" if profile.camera.depth else "camera")


def test_what_is_newer_than_the_parser_is_marked(tmp_path: Path) -> None:
    threewe.export("apartment_v1", "3we_depth_v2", "sdf", tmp_path)
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    root = ElementTree.parse(tmp_path / "models/3we_depth_v2/model.sdf", parser)
    marked = 0
    for parent in root.iter():
        children = list(parent)
        for before, child in zip([None, *children], children, strict=False):
            if child.tag in NEWER_THAN_1_9:
                assert before is not None
                assert before.text == " newer than SDF 1.9, not run in Gazebo yet "
                marked += 1
    assert marked == 8


@pytest.mark.parametrize(("name", "system"), [("3we_standard_v2", "MecanumDrive"), ("turtlebot_like", "DiffDrive")])
def test_systems_of_gazebo_name_joints_and_sizes(name: str, system: str, tmp_path: Path) -> None:
    threewe.export("apartment_v1", name, "sdf", tmp_path)
    model = ElementTree.parse(tmp_path / "models" / name / "model.sdf").getroot().find("model")
    assert model is not None
    plugins = {plugin.get("name"): plugin for plugin in model.findall("plugin")}
    drive = plugins[f"gz::sim::systems::{system}"]
    joints = {joint.get("name") for joint in model.findall("joint")}
    named = [element.text for element in drive if element.tag.endswith("_joint")]
    assert len(named) == len(joints)
    assert set(named) == joints
    world = ElementTree.parse(tmp_path / "world.sdf").getroot().find("world")
    assert world is not None
    systems = {plugin.get("name", "").rpartition("::")[2] for plugin in world.findall("plugin")}
    assert systems == {"Physics", "Sensors", "Imu", "Contact", "SceneBroadcaster", "UserCommands"}


def test_mecanum_wheels_hold_along_their_rollers_alone(tmp_path: Path) -> None:
    threewe.export("apartment_v1", "3we_standard_v2", "sdf", tmp_path)
    model = ElementTree.parse(tmp_path / "models/3we_standard_v2/model.sdf").getroot().find("model")
    assert model is not None
    signs = {}
    for link in model.findall("link"):
        found = link.find("collision/surface/friction/ode/fdir1")
        if found is not None:
            x, y, z = numbers((found.text or "").split())
            assert abs(x) == pytest.approx(abs(y))
            assert z == 0
            signs[link.get("name")] = np.sign(x * y)
            assert link.findtext("collision/surface/friction/ode/mu2") == "0"
    assert signs == {"front_left_wheel": -1, "front_right_wheel": 1, "rear_left_wheel": 1, "rear_right_wheel": -1}
