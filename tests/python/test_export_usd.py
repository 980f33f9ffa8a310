"""Exported USD stages, as OpenUSD composes and validates them."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import threewe
from slices import Block, occupied, read_map
from test_export import LIDAR_HEIGHT, OCCUPIED, mounts

pytest.importorskip("pxr", reason="not shown: usd-core is not installed")
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdValidation


def exported(scene: str, robot: str, folder: Path) -> Any:
    (path,) = threewe.export(scene, robot, "usd", folder)
    return Usd.Stage.Open(str(path))


def complaints(stage: Any) -> list[str]:
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) >= 20
    return [error.GetMessage() for error in UsdValidation.ValidationContext(validators).Validate(stage)]


@pytest.mark.parametrize("robot", threewe.profile_names())
@pytest.mark.parametrize("scene", ["apartment_v1", "dynamic_v1", "outdoor_v1"])
def test_every_validator_is_content(scene: str, robot: str, tmp_path: Path) -> None:
    assert not complaints(exported(scene, robot, tmp_path))


def test_validators_tell_a_broken_stage(tmp_path: Path) -> None:
    (path,) = threewe.export("apartment_v1", "3we_standard_v2", "usd", tmp_path)
    text = path.read_text()
    for good, bad in [("upAxis", "# upAxis"), ('"PhysicsRigidBodyAPI", "PhysicsMassAPI"', '"PhysicsMassAPI"')]:
        broken = tmp_path / "broken.usda"
        broken.write_text(text.replace(good, bad))
        stage = Usd.Stage.Open(str(broken))
        stage.Reload()
        assert complaints(stage), bad


def test_a_slice_has_the_cells_of_the_scene(tmp_path: Path) -> None:
    stage = exported("office_v2", "3we_standard_v2", tmp_path)
    threewe.export("office_v2", "3we_standard_v2", "map", tmp_path)
    blocks = []
    for prim in stage.Traverse():
        path = str(prim.GetPath())
        if not path.startswith(("/World/Scene/walls/", "/World/Scene/furniture/")):
            continue
        assert prim.HasAPI(UsdPhysics.CollisionAPI)
        placed = Gf.Transform(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
        turned = placed.GetRotation().GetQuat()
        theta = 2 * np.arctan2(turned.GetImaginary()[2], turned.GetReal())
        if prim.GetTypeName() == "Cube":
            size = tuple(placed.GetScale())
        else:
            cylinder = UsdGeom.Cylinder(prim)
            size = (cylinder.GetRadiusAttr().Get(),) * 2 + (cylinder.GetHeightAttr().Get(),)
        kind = "box" if prim.GetTypeName() == "Cube" else "cylinder"
        blocks.append(Block(path, kind, tuple(placed.GetTranslation()), theta, size))
    frame, picture = read_map(tmp_path)
    assert np.array_equal(occupied(blocks, frame, LIDAR_HEIGHT), picture == OCCUPIED)


@pytest.mark.parametrize("name", threewe.profile_names())
def test_a_robot_has_the_mass_the_joints_and_the_sensors_of_its_profile(name: str, tmp_path: Path) -> None:
    stage, profile = exported("apartment_v1", name, tmp_path), threewe.RobotProfile.load(name)
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.MassAPI)]
    masses = [UsdPhysics.MassAPI(prim).GetMassAttr().Get() for prim in bodies]
    assert sum(masses) == pytest.approx(profile.mass, rel=1e-6)
    joints = [UsdPhysics.RevoluteJoint(prim) for prim in stage.Traverse() if prim.IsA(UsdPhysics.RevoluteJoint)]
    assert len(joints) == len(bodies) - 1
    driven = [joint for joint in joints if joint.GetPrim().HasAPI(UsdPhysics.DriveAPI, "angular")]
    assert len(driven) == (4 if profile.kinematics == threewe.Kinematics.holonomic else 2)
    for joint in joints:  # both bodies agree where it is
        frames = []
        for bodies_of, place, turn in (
            (joint.GetBody0Rel(), joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
            (joint.GetBody1Rel(), joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
        ):
            body = UsdGeom.Xformable(stage.GetPrimAtPath(bodies_of.GetTargets()[0]))
            local = Gf.Matrix4d(Gf.Rotation(Gf.Quatd(turn.Get())), Gf.Vec3d(place.Get()))
            frames.append(np.array(local * body.ComputeLocalToWorldTransform(Usd.TimeCode.Default())))
        assert np.allclose(*frames, atol=1e-6)
    for sensor, (pose, height) in mounts(profile).items():
        prim = UsdGeom.Xformable(stage.GetPrimAtPath(f"/World/Robot/base_link/{sensor}"))
        placed = prim.ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        assert tuple(placed.ExtractTranslation()) == pytest.approx((pose.x, pose.y, height), abs=1e-12)
        ahead = placed.TransformDir(Gf.Vec3d(0, 0, -1) if sensor == "camera" else Gf.Vec3d(1, 0, 0))
        assert tuple(ahead) == pytest.approx((np.cos(pose.theta), np.sin(pose.theta), 0), abs=1e-6)


def test_the_camera_sees_as_wide_as_the_robot_s(tmp_path: Path) -> None:
    stage = exported("apartment_v1", "3we_depth_v2", tmp_path)
    camera = UsdGeom.Camera.Get(stage, "/World/Robot/base_link/camera").GetCamera()
    view = threewe.RobotProfile.load("3we_depth_v2").camera.intrinsics
    horizontal, vertical = (camera.GetFieldOfView(side) for side in (camera.FOVHorizontal, camera.FOVVertical))
    assert np.tan(np.radians(horizontal) / 2) == pytest.approx(0.5 * view.width / view.fx, rel=1e-5)
    assert np.tan(np.radians(vertical) / 2) == pytest.approx(0.5 * view.height / view.fy, rel=1e-5)


def test_rollers_are_closed_round_bodies(tmp_path: Path) -> None:
    stage = exported("apartment_v1", "3we_standard_v2", tmp_path)
    rollers = [prim for prim in stage.Traverse() if prim.GetTypeName() == "Mesh"]
    assert len(rollers) == 36
    mesh = UsdGeom.Mesh(rollers[0])
    points = np.array(mesh.GetPointsAttr().Get())
    corners = list(mesh.GetFaceVertexIndicesAttr().Get())
    edges: dict[tuple[int, int], int] = {}
    at = 0
    volume = 0.0
    for count in mesh.GetFaceVertexCountsAttr().Get():
        face = corners[at : at + count]
        at += count
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            edges[(a, b)] = edges.get((a, b), 0) + 1
        for b, c in pairwise(face[1:]):
            volume += float(np.dot(points[face[0]], np.cross(points[b], points[c]))) / 6
    assert all(edges.get((b, a)) == 1 == count for (a, b), count in edges.items())
    semi_axes = points.max(axis=0)
    assert volume == pytest.approx(4 / 3 * np.pi * np.prod(semi_axes), rel=0.1)
    assert volume > 0  # faces look outwards
