"""Observations that stand for all that a policy will see: int8 and Hailo's compiler choose their ranges by them."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from threewe._core import Pose2D, Velocity
from threewe._extras import needed_for
from threewe.ai.folder import EMBEDDED, PREFIX, STATE, Policy, image_input
from threewe.ai.runner import VLARunner, network_input
from threewe.errors import ConfigError

Feed = dict[str, NDArray[np.float32]]
"""What a graph takes, by name."""

COUNT = 200
"""Observations."""
SEED = "calibration"
"""Of the generated buildings."""
WAYS = (0.0, 0.3, 0.6, 0.8)
"""Of the way from an episode's start to what is in sight, where a picture is taken."""
TURN = 0.5
"""[rad] off the way, at most."""


def calibration_feeds(runner: VLARunner, dataset: Path | None, count: int = COUNT) -> list[Feed]:
    """Inputs of a policy's graph: of a LeRobot dataset, evenly, or from generated buildings. Raises ConfigError."""
    feeds = _from_buildings(runner, count) if dataset is None else list(_from_dataset(runner.policy, dataset, count))
    return feeds[:count]


def _from_dataset(policy: Policy, folder: Path, count: int) -> Iterator[Feed]:
    with needed_for("reading a dataset", "data"):
        from threewe.data.lerobot import Dataset

    dataset = Dataset.open(folder)
    wanted = [image_input(camera.name) for camera in policy.cameras]
    wanted += [name for name, used in ((EMBEDDED, policy.language), (STATE, bool(policy.state))) if used]
    if missing := [name for name in wanted if name not in dataset.features]:
        raise ConfigError(f"{folder}: no '{missing[0]}', which the policy takes; without a dataset pictures are drawn")
    names = list(dataset.features[STATE].names or []) if policy.state else []
    if lost := [quantity.name for quantity in policy.state if quantity.name not in names]:
        raise ConfigError(f"{folder}: {STATE} is ({', '.join(map(str, names))}); the policy takes '{lost[0]}'")
    each = -(-count // len(dataset))
    for episode in dataset.episodes:
        columns = episode.columns()
        videos = [episode.video(image_input(camera.name)) for camera in policy.cameras]
        for row in np.unique(np.linspace(0, len(episode) - 1, each).astype(int)):
            feed = {
                image_input(camera.name): network_input(video.image(int(row))[:, :, ::-1], camera)
                for camera, video in zip(policy.cameras, videos, strict=True)
            }
            if policy.language:
                feed[EMBEDDED] = columns[EMBEDDED][row][None].astype(np.float32)
            if policy.state:
                values = [(columns[STATE][row][names.index(q.name)] - q.mean) / q.std for q in policy.state]
                feed[STATE] = np.array([values], np.float32)
            if policy.prefix:  # none is committed
                feed[PREFIX] = np.zeros(policy.inputs()[PREFIX], np.float32)
            yield feed


def _from_buildings(runner: VLARunner, count: int) -> list[Feed]:
    """Of a robot on its way to what an instruction names; each camera sees the same."""
    from threewe.benchmark.buildings import scene_asset
    from threewe.benchmark.sampling import generated_in_sight
    from threewe.robot import Robot

    policy, random = runner.policy, np.random.default_rng(1)
    size = policy.cameras[0].height, policy.cameras[0].width
    if any((camera.height, camera.width) != size for camera in policy.cameras):
        raise ConfigError("its cameras are of different sizes: name a dataset, whose pictures calibrate")

    async def look(scene: str, start: Pose2D, kind: str) -> list[Feed]:
        found = []
        async with Robot(scene=scene, image_size=size, localization="truth") as robot:
            assert robot.simulation is not None
            assert robot.profile.camera is not None
            things = [thing.pose for thing in robot.simulation.scene.objects if thing.category == kind]
            goal = min(things, key=lambda pose: np.hypot(pose.x - start.x, pose.y - start.y))
            ahead = np.arctan2(goal.y - start.y, goal.x - start.x)
            for way in WAYS:
                heading = float(ahead + random.uniform(-TURN, TURN))
                x, y = start.x + way * (goal.x - start.x), start.y + way * (goal.y - start.y)
                pose = Pose2D(x, y, heading) * robot.profile.camera.base_from_camera
                picture = robot.simulation.look(pose=pose, with_itself=False).color
                limits = robot.profile.operating_limits
                velocity = Velocity(random.uniform(0, limits.linear), 0.0, random.uniform(-1, 1) * limits.angular)
                pictures = {camera.name: picture for camera in policy.cameras}
                found.append(runner._feed(pictures, f"go to the {kind}" if policy.language else "", velocity))
        return found

    feeds: list[Feed] = []
    for episode in islice(generated_in_sight(SEED), -(-count // len(WAYS))):
        scene = scene_asset(episode.scene)
        feeds += asyncio.run(look(scene, Pose2D(*episode.start), str(episode.category)))
    return feeds
