"""A complete backend in Python, an ideal robot in an empty room: it passes the checks, so every program runs on it.

Since it tells the truth about its robot, learning environments run on it, too.
"""

import argparse
import asyncio
import math
import pickle
from collections.abc import Iterator
from dataclasses import dataclass

import gymnasium
import numpy as np
import threewe
from numpy.typing import NDArray
from threewe import Features, Pose2D, Robot, Scene, SensorInfo, SensorType, Velocity
from threewe.backend import (
    Backend,
    BackendOptions,
    BatteryReading,
    IMUReading,
    LidarReading,
    OdometryReading,
    Reading,
    Truth,
)
from threewe.testing import check_backend

LEFT, RIGHT, BOTTOM, TOP = -2.0, 4.0, -2.0, 3.0
"""The room's walls [m]; the robot starts at the origin and looks towards the right one."""
ROOM = f"""
name: toy_room
description: An empty room
starts: [[0, 0, 0]]
rooms:
  - {{name: room, min: [{LEFT}, {BOTTOM}], max: [{RIGHT}, {TOP}], floor: wood, anchor: [0, 0]}}
walls:
  - {{a: [{LEFT}, {BOTTOM}], b: [{RIGHT}, {BOTTOM}], thickness: 0.02}}
  - {{a: [{RIGHT}, {BOTTOM}], b: [{RIGHT}, {TOP}], thickness: 0.02}}
  - {{a: [{RIGHT}, {TOP}], b: [{LEFT}, {TOP}], thickness: 0.02}}
  - {{a: [{LEFT}, {TOP}], b: [{LEFT}, {BOTTOM}], thickness: 0.02}}
"""
TICK = 0.01
"""[s] of simulation."""


@dataclass
class State:
    """All that the future depends on."""

    ticks: int
    pose: Pose2D
    velocity: Velocity
    driven: float
    noise: np.random.Generator


class ToyBackend(Backend):
    """A robot that does at once what is commanded, and goes through walls."""

    def __init__(self, options: BackendOptions) -> None:
        super().__init__(options)
        self.state = self.new_state(options.seed, options.start_pose)

    def new_state(self, seed: int, pose: Pose2D | None) -> State:
        self.start = pose or Pose2D()
        return State(0, self.start, Velocity(), 0.0, np.random.default_rng(seed))

    @property
    def features(self) -> Features:
        return Features(
            [
                SensorInfo("lidar", SensorType.lidar, 10.0),
                SensorInfo("imu", SensorType.imu, 100.0),
                SensorInfo("odometry", SensorType.odometry, 50.0),
                SensorInfo("battery", SensorType.battery, 1.0),
            ],
            self.profile.kinematics,
            lockstep=True,
            deterministic=True,
            can_reset=True,
            can_save=True,
        )

    def connect(self) -> None:
        """There is nothing to reach."""

    def disconnect(self) -> None:
        self.state.velocity = Velocity()

    def step(self, t: float, velocity: Velocity) -> Iterator[Reading]:
        state = self.state
        state.velocity = velocity
        while (state.ticks + 1) * TICK <= t + 1e-9:
            state.ticks += 1
            state.pose = state.pose * Pose2D(velocity.vx * TICK, velocity.vy * TICK, velocity.omega * TICK)
            state.driven += math.hypot(velocity.vx, velocity.vy) * TICK
            yield from self.readings(state)

    def readings(self, state: State) -> Iterator[Reading]:
        now = state.ticks / 100  # not `state.ticks * TICK`: 0.07 and not 0.07000000000000001, which would be too late
        yield IMUReading(
            measured=now, angular_velocity=(0.0, 0.0, state.velocity.omega), linear_acceleration=(0.0, 0.0, 9.81)
        )
        if state.ticks % 2 == 0:
            yield OdometryReading(measured=now, pose=self.start.inverse() * state.pose, velocity=state.velocity)
        if state.ticks % 10 == 0:
            yield LidarReading(measured=now, ranges=self.scan(state), angle_min=-math.pi)
        if state.ticks % 100 == 0:
            yield BatteryReading(measured=now, voltage=8.0, current=1.0, charge=max(0.0, 1.0 - now / 7200.0))

    def scan(self, state: State) -> NDArray[np.float32]:
        lidar = self.profile.lidar
        assert lidar is not None
        mount = state.pose * lidar.base_from_lidar
        angles = mount.theta - math.pi + np.arange(lidar.beams) * (2.0 * math.pi / lidar.beams)
        cos, sin = np.cos(angles), np.sin(angles)
        with np.errstate(divide="ignore"):
            to_wall = np.minimum(
                (np.where(cos > 0, RIGHT, LEFT) - mount.x) / cos, (np.where(sin > 0, TOP, BOTTOM) - mount.y) / sin
            )
        if self.options.noise == "realistic":
            to_wall += state.noise.normal(0.0, 0.01, lidar.beams)
        return np.asarray(np.clip(to_wall, lidar.range_min, lidar.range_max), np.float32)

    def reset(self, seed: int, pose: Pose2D | None) -> None:
        self.state = self.new_state(seed, pose)

    @property
    def scene(self) -> Scene:
        return Scene.parse(ROOM, "toy_room")

    def truth(self) -> Truth:
        state = self.state
        return Truth(start=self.start, pose=state.pose, velocity=state.velocity, distance_driven=state.driven)

    def save(self) -> bytes:
        state = self.state
        return pickle.dumps((state.ticks, tuple(state.pose), tuple(state.velocity), state.driven, state.noise))

    def restore(self, state: bytes) -> None:
        ticks, pose, velocity, driven, noise = pickle.loads(state)
        self.state = State(ticks, Pose2D(*pose), Velocity(*velocity), driven, noise)


def learn() -> None:
    env = gymnasium.make("3we/Navigation-v1", backend="toy", observations=("lidar", "goal"))
    _, info = env.reset(seed=1)
    reward, steps = 0.0, 0
    while not (info["success"] or steps == 10):
        _, gained, _, _, info = env.step(env.action_space.sample())
        reward, steps = reward + float(gained), steps + 1
    print(f"a policy that knows nothing earns {reward:.2f} in {steps} steps")


async def drive() -> None:
    async with Robot(backend="toy") as robot:
        result = await robot.move_to(x=2.0, y=1.0)
        print(f"{result} in {robot.now:.1f} s of robot time")
        result.raise_for_failure()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="run some of the checks only")
    quick = parser.parse_args().quick

    threewe.register_backend("toy", ToyBackend)
    some = ["a_metre_driven_is_a_metre_in_odometry", "lidar_sees_the_robot_turn_left", "the_same_seed_repeats"]
    check_backend("toy", checks=some if quick else None, raise_failures=True)
    asyncio.run(drive())
    learn()
