"""Stamps count milliseconds where seconds are meant: 1.5 s becomes 0.0015.

fails: samples_are_recent, rates_are_as_listed, odometry_velocity_fits_its_pose, gyro_agrees_with_odometry,
lidar_sees_the_robot_drive_forward, lidar_sees_the_robot_turn_left, imu_and_odometry_are_of_one_time,
lidar_and_odometry_are_of_one_time, the_lidar_does_not_hit_the_robot, the_lidar_is_where_the_profile_says,
the_robot_starts_at_the_commanded_pose, reset_puts_the_robot_at_its_pose, truth_is_in_the_frame_of_the_scene
"""

from collections.abc import Iterator
from dataclasses import replace

from threewe.backend import Reading
from toy import State, ToyBackend


class Wrong(ToyBackend):
    def readings(self, state: State) -> Iterator[Reading]:
        for reading in super().readings(state):
            yield replace(reading, measured=reading.measured / 1000)
