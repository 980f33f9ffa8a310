"""Exported MuJoCo models, as MuJoCo compiles and steps them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import threewe
from slices import Block, occupied, read_map
from test_export import LIDAR_HEIGHT, OCCUPIED, mounts

mujoco = pytest.importorskip("mujoco", reason="not shown: mujoco-core is not installed")

WHEELS = {
    "3we_standard_v2": {"radius": 0.0325, "half_length": 0.085, "half_width": 0.095},
    "turtlebot_like": {"radius": 0.033, "half_length": 0.0, "half_width": 0.08},
}


def exported(scene: str, robot: str, folder: Path) -> Any:
    (path,) = threewe.export(scene, robot, "mjcf", folder)
    return mujoco.MjModel.from_xml_path(str(path))


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The standard robot in the apartment; tests leave it as it is."""
    return exported("apartment_v1", "3we_standard_v2", tmp_path_factory.mktemp("mjcf"))


def scene_blocks(model: Any) -> list[Block]:
    """What surroundings are made of, but for the floor."""
    blocks = []
    kinds = {mujoco.mjtGeom.mjGEOM_BOX: "box", mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder"}
    for i in range(model.ngeom):
        geom = model.geom(i)
        if geom.bodyid[0] != 0 or geom.contype[0] == 0 or geom.name.startswith("ground"):
            continue
        w, _, _, z = geom.quat
        kind = kinds[mujoco.mjtGeom(geom.type[0])]
        half = geom.size if kind == "box" else np.array([geom.size[0] / 2, geom.size[0] / 2, geom.size[1]])
        blocks.append(Block(geom.name, kind, tuple(geom.pos), 2 * np.arctan2(z, w), tuple(2 * half)))
    return blocks


@pytest.mark.parametrize("scene", [*threewe.scene_names(), "generated"])
def test_a_slice_has_the_cells_of_the_scene(scene: str, tmp_path: Path) -> None:
    if scene == "generated":
        scene = str(tmp_path / "new.yaml")
        Path(scene).write_text(threewe.Scene.generate(5).to_yaml(name="new"))
    model = exported(scene, "3we_standard_v2", tmp_path)
    threewe.export(scene, "3we_standard_v2", "map", tmp_path)
    frame, picture = read_map(tmp_path)
    assert np.array_equal(occupied(scene_blocks(model), frame, LIDAR_HEIGHT), picture == OCCUPIED)


@pytest.mark.parametrize("name", threewe.profile_names())
def test_mass_inertia_and_sensors_are_the_profile_s(name: str, tmp_path: Path) -> None:
    model, profile = exported("apartment_v1", name, tmp_path), threewe.RobotProfile.load(name)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert mujoco.mj_getTotalmass(model) == pytest.approx(profile.mass, rel=1e-14)
    mass_matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass_matrix)
    assert mass_matrix[5, 5] == pytest.approx(inertia_of(name), rel=1e-12)  # about the base's vertical axis
    for sensor, (pose, height) in mounts(profile).items():
        found = data.cam(f"robot/{sensor}") if sensor == "camera" else data.site(f"robot/{sensor}")
        assert found.xpos == pytest.approx([pose.x, pose.y, height], abs=1e-12)
        turned = found.xmat.reshape(3, 3)
        ahead = {"camera": -turned[:, 2], "lidar": turned[:, 0]}.get(sensor, turned[:, 2])
        assert ahead == pytest.approx([np.cos(pose.theta), np.sin(pose.theta), 0], abs=1e-12)


def inertia_of(name: str) -> float:
    text = (threewe.asset_directories()[0] / "robots" / f"{name}.yaml").read_text()
    return float(text.split("inertia:")[1].split()[0])


def test_the_camera_sees_as_wide_as_the_robot_s(model: Any) -> None:
    view = threewe.RobotProfile.load("3we_standard_v2").camera.intrinsics
    camera = model.cam("robot/camera")
    assert np.tan(np.radians(camera.fovy[0]) / 2) == pytest.approx(0.5 * view.height / view.fy, rel=1e-12)
    assert list(model.cam_resolution[camera.id]) == [view.width, view.height]


def wheel_speeds(name: str, vx: float, vy: float, omega: float) -> np.ndarray:
    wheels = WHEELS[name]
    turn = (wheels["half_length"] + wheels["half_width"]) * omega
    if name == "turtlebot_like":
        return np.array([vx - turn, vx + turn]) / wheels["radius"]
    return np.array([vx - vy - turn, vx + vy + turn, vx + vy - turn, vx - vy + turn]) / wheels["radius"]


@cache
def empty_floor(name: str, folder: Path) -> Any:
    """The robot on the floor of the office, with nothing else there."""
    (path,) = threewe.export("office_v2", name, "mjcf", folder)
    spec = mujoco.MjSpec.from_file(str(path))
    for geom in list(spec.worldbody.geoms):
        if not geom.name.startswith("ground"):
            spec.delete(geom)
    return spec.compile()


def mean_velocity(model: Any, speeds: np.ndarray, seconds: float = 3.0) -> np.ndarray:
    """The body's velocity, a second after its wheels were told their speeds."""
    data = mujoco.MjData(model)
    data.ctrl[:] = speeds
    mujoco.mj_step(model, data, nstep=round(1 / model.opt.timestep))
    seen = []
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        w, x, y, z = data.qpos[3:7]
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        c, s = np.cos(yaw), np.sin(yaw)
        seen.append([c * data.qvel[0] + s * data.qvel[1], -s * data.qvel[0] + c * data.qvel[1], data.qvel[5]])
    return np.mean(seen, axis=0)


@pytest.mark.parametrize(
    ("name", "commanded", "tolerance"),
    [
        # straight rollers move a body sideways by cos(angle) of what their wheel turns, 2 % less on average with nine
        ("3we_standard_v2", (0.5, 0.0, 0.0), 0.015),
        ("3we_standard_v2", (-0.3, 0.0, 0.0), 0.015),
        ("3we_standard_v2", (0.0, 0.5, 0.0), 0.04),
        ("3we_standard_v2", (0.0, -0.2, 0.0), 0.04),
        ("3we_standard_v2", (0.0, 0.0, 1.0), 0.03),
        ("3we_standard_v2", (0.3, 0.3, 0.0), 0.04),
        ("3we_standard_v2", (0.3, -0.2, 0.5), 0.04),
        ("turtlebot_like", (0.2, 0.0, 0.0), 0.01),
        ("turtlebot_like", (0.0, 0.0, 1.0), 0.01),
        ("turtlebot_like", (0.15, 0.0, -0.5), 0.02),
    ],
)
def test_robots_move_as_their_wheels_are_told(
    name: str, commanded: tuple[float, float, float], tolerance: float, tmp_path_factory: pytest.TempPathFactory
) -> None:
    model = empty_floor(name, tmp_path_factory.getbasetemp() / f"floor_{name}")
    moved = mean_velocity(model, wheel_speeds(name, *commanded))
    arm = 0.18  # [m], turns and metres in one unit
    off = np.array(moved - commanded) * [1, 1, arm]
    assert np.linalg.norm(off) <= tolerance * np.linalg.norm(np.array(commanded) * [1, 1, arm]), moved


def test_motors_give_no_more_than_the_profile_says_at_any_speed(model: Any) -> None:
    stall, no_load = 0.26, 48.2
    data = mujoco.MjData(model)
    joint = model.joint("robot/front_left_wheel").dofadr[0]
    for speed in np.linspace(-40, 40, 17):
        for setpoint in (-1000.0, 1000.0):
            data.qvel[joint], data.ctrl[0] = speed, setpoint
            mujoco.mj_forward(model, data)
            torque = data.qfrc_actuator[joint] + data.qfrc_passive[joint]
            assert torque == pytest.approx(np.sign(setpoint) * stall - stall * speed / no_load, abs=1e-12)
        data.ctrl[0] = speed
        mujoco.mj_forward(model, data)
        assert data.qfrc_actuator[joint] + data.qfrc_passive[joint] == pytest.approx(0, abs=1e-12)


def test_a_wheel_s_speed_follows_with_the_motor_s_lag(tmp_path: Path) -> None:
    model = empty_floor("3we_standard_v2", tmp_path)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=250)
    data.ctrl[:] = wheel_speeds("3we_standard_v2", 0.1, 0.0, 0.0)
    mujoco.mj_step(model, data, nstep=15)  # 0.03 s
    reached = np.mean(data.sensordata[:4]) / data.ctrl[0]
    assert reached == pytest.approx(1 - np.exp(-1), abs=0.06)


def test_floors_hold_as_the_scene_says(tmp_path: Path) -> None:
    model, scene = exported("outdoor_v1", "3we_standard_v2", tmp_path), threewe.Scene.load("outdoor_v1")
    tiles = [model.geom(i) for i in range(model.ngeom) if model.geom(i).name.startswith("ground")]
    assert len(tiles) > 1
    for tile in tiles:
        assert tile.friction[0] == pytest.approx(0.7 * scene.friction_at((tile.pos[0], tile.pos[1])), rel=1e-12)
        assert tile.pos[2] + tile.size[2] == pytest.approx(0, abs=1e-15)


def test_people_are_moved_by_whoever_steps_the_model(tmp_path: Path) -> None:
    model, scene = exported("dynamic_v1", "3we_standard_v2", tmp_path), threewe.Scene.load("dynamic_v1")
    assert model.nmocap == len(scene.people) > 0
    data = mujoco.MjData(model)
    for person in scene.people:
        body = model.body(f"person/{person.name}")
        assert tuple(body.pos[:2]) == pytest.approx(person.route[0])
        data.mocap_pos[body.mocapid[0]] = [*person.route[1], 0]
    mujoco.mj_kinematics(model, data)
    for person in scene.people:
        x, y, z = data.geom(f"person/{person.name}").xpos
        assert (x, y) == pytest.approx(person.route[1])
        assert model.geom(f"person/{person.name}").size[0] == person.radius
        assert z > 0.5


def test_a_robot_at_rest_feels_gravity_and_hears_the_wall_ahead(model: Any) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=500)
    assert np.abs(data.qvel[:6]).max() < 1e-3
    assert data.sensor("robot/accelerometer").data == pytest.approx([0, 0, 9.81], abs=0.02)
    assert data.sensor("robot/gyro").data == pytest.approx([0, 0, 0], abs=1e-3)
    ranges = [
        data.sensor(f"robot/ultrasonic_{side}").data[0] for side in ("front_left", "left", "front_right", "right")
    ]
    assert all(reading == -1 or 0.02 < reading <= 4.0 for reading in ranges)
    assert any(reading > 0 for reading in ranges)


def test_two_exports_step_alike(tmp_path: Path) -> None:
    ends = []
    for folder in ("a", "b"):
        model = exported("office_v2", "3we_standard_v2", tmp_path / folder)
        data = mujoco.MjData(model)
        data.ctrl[:] = wheel_speeds("3we_standard_v2", 0.3, 0.1, 0.2)
        mujoco.mj_step(model, data, nstep=1000)
        ends.append(data.qpos.copy())
    assert np.array_equal(*ends)
