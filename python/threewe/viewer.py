"""What a robot sees, knows and does, streamed to Rerun while it happens."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from threewe._colors import NOTHING, map_colors
from threewe._core import (
    BatteryState,
    Intervention,
    LaserScan,
    OccupancyGrid,
    Pose2D,
    RangeData,
    RGBDImage,
    Sample,
    SensorType,
    TickView,
)
from threewe._extras import needed_for

with needed_for("viewer", "viz"):
    import rerun as rr

    from threewe import _viewer_layout as layout
    from threewe import _viewer_scene as solids
    from threewe import _viewer_sinks as sinks
    from threewe import drawing as d

if TYPE_CHECKING:
    from threewe.robot import Robot

POSES_EVERY = 0.1  # [s] of robot time between two poses, and so on
PLAN_EVERY = 0.2
PICTURES_EVERY = 0.2
DEPTH_EVERY = 0.6  # it is large, and packing it would keep the robot waiting
MAP_EVERY = 1.0
POSES_KEPT = 64  # of the last ticks: longer ago than that, no sample was measured

TRUE_COLOR = d.BODY
ESTIMATED_COLOR = d.TRAJECTORY
PATH_STEP = 0.05  # [m]
PATHS = {  # colour, radius and height [m]: the estimated path is a thin line upon the broad true one
    "scene/true": (TRUE_COLOR, 0.045, 0.03),
    "map/estimated": (ESTIMATED_COLOR, 0.018, 0.08),
}


class Viewer:
    """Streams a robot to the Rerun viewer. It observes: what the robot does stays the same, to the bit.

    A recording begins when the robot connects and ends when it disconnects. Everything below `scene` is the truth,
    which only simulated robots have; everything below `map` is what the robot knows. A reading is drawn where the
    robot believed to be when it was measured.

    Args:
        robot: which.
        where: `rerun` opens a window of the viewer, `web` serves it to browsers until Python ends, a file that ends in
            .rrd is recorded.

    Raises:
        ConfigError: an unknown viewer (with the nearest right name), or no display to open a window on.
    """

    def __init__(self, robot: Robot, where: str) -> None:
        sinks.check_sink(where)
        self._robot = robot
        self._where = where
        self._observer: int | None = None

    def begin(self) -> None:
        """Opens the viewer and begins a recording; twice is as good as once."""
        if self._observer is not None:
            return
        robot = self._robot
        scene = robot.simulation.scene if robot.simulation else None
        camera = robot.profile.camera if self._has(SensorType.camera) else None
        blueprint = layout.layout(
            scene, camera=camera is not None, depth=camera is not None and camera.depth is not None
        )
        self._recording = sinks.open_recording(self._where, blueprint)
        self._map: OccupancyGrid | None = None
        self._plan: NDArray[np.float64] = np.empty((0, 2))
        self._sensors = [sensor.name for sensor in robot.features.sensors]
        self._draws_maps = self._has(SensorType.lidar)
        self._intervention = Intervention.none
        self._past = self._now = 0.0
        self._draw_what_stays()
        self._begin_anew()
        self._observer = robot.observe(self._look)

    def end(self) -> None:
        """Ends the recording; a file is complete then."""
        if self._observer is None:
            return
        self._robot.unobserve(self._observer)
        self._observer = None
        if self._draws_maps and self._robot.connected:
            self._draw_map()  # as it was at last
        self._recording.flush()
        if self._where not in sinks.LISTENS_ON:
            self._recording.disconnect()

    def _look(self, tick: TickView) -> None:
        """Sends what is new."""
        self._set_time(tick)
        pose = tick.pose.map_from_base
        self._poses.append((tick.now, *pose))
        for sample in tick.samples:
            self._draw_sample(sample)
        if self._is_due("poses", POSES_EVERY):
            self._draw_poses(pose)
            self._draw_signals(tick)
        if self._is_due("plan", PLAN_EVERY):
            self._draw_plan()
        if self._draws_maps and self._is_due("map", MAP_EVERY):
            self._draw_map()
        self._draw_intervention(tick.intervention)

    # Time

    def _begin_anew(self) -> None:
        self._poses: deque[tuple[float, float, float, float]] = deque(maxlen=POSES_KEPT)
        self._trails: dict[str, tuple[float, float]] = {}
        self._next: dict[str, float] = {}

    def _set_time(self, tick: TickView) -> None:
        """The recording's time goes on when a simulation begins anew at 0."""
        if tick.now < self._now:
            self._past += self._now
            self._begin_anew()
        self._now = tick.now
        self._recording.set_time(layout.TIMELINE, duration=self._past + tick.now)

    def _is_due(self, what: str, period: float) -> bool:
        if self._now + 1e-9 < self._next.get(what, 0.0):
            return False
        self._next[what] = self._now + period
        return True

    def _has(self, kind: SensorType) -> bool:
        return any(sensor.type is kind for sensor in self._robot.features.sensors)

    # The truth, which only simulated robots have

    def _draw_what_stays(self) -> None:
        log, truth, profile = self._recording.log, self._robot.simulation, self._robot.profile
        log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        log("map/estimated_robot", solids.body_outline(profile, ESTIMATED_COLOR), static=True)
        log("signals/velocity/estimated", series(["vx", "vy", "omega"], 2.0), static=True)
        log("signals/velocity/commanded", series(["vx commanded", "vy commanded", "omega commanded"], 1.0), static=True)
        if profile.camera is not None:
            log("map/camera", solids.frustum(profile.camera.intrinsics), static=True)
        if truth:
            for person in truth.people():
                log(f"scene/people/{person.name}", solids.figure(person.radius), static=True)
            log("scene/true_robot", solids.body_mesh(profile, TRUE_COLOR), static=True)
            for entity, solid in solids.scene_solids(truth.scene):
                log(f"scene/{entity}", solid, static=True)

    def _draw_poses(self, pose: Pose2D) -> None:
        self._draw_robot("map/estimated", pose)
        if truth := self._robot.simulation:
            if self._is_due("map frame", math.inf):  # once an episode
                self._recording.log("map", solids.transform(truth.scene_from_map))
            for person in truth.people():
                self._recording.log(f"scene/people/{person.name}", solids.transform(person.pose))
            true_pose = truth.true_pose()
            self._draw_robot("scene/true", true_pose)
            error = true_pose.distance(truth.scene_from_map * pose)
            self._recording.log("signals/error", rr.Scalars(error))

    def _draw_robot(self, name: str, pose: Pose2D) -> None:
        """Where it is, and one more piece of its path."""
        self._recording.log(f"{name}_robot", solids.transform(pose))
        here, before = (pose.x, pose.y), self._trails.get(name)
        if before is not None and math.dist(before, here) < PATH_STEP:
            return
        if before is not None:
            color, radius, z = PATHS[name]
            strip = [(*before, z), (*here, z)]
            self._recording.log(f"{name}_path", rr.LineStrips3D([strip], colors=[color], radii=radius))
        self._trails[name] = here

    # What the robot sees

    def _draw_sample(self, sample: Sample) -> None:
        name = self._sensors[sample.sensor]
        match sample.data:
            case LaserScan() as scan:
                self._draw_scan(name, scan, sample.measured)
            case RangeData() as sonar:
                self._draw_sonar(name, sonar, sample.measured)
            case RGBDImage() as image if self._is_due("pictures", PICTURES_EVERY):  # others are never drawn
                self._draw_image(name, image, sample.measured)
            case BatteryState() as battery:
                self._recording.log("signals/battery/charge", rr.Scalars(100.0 * battery.charge))

    def _draw_scan(self, name: str, scan: LaserScan, measured: float) -> None:
        """Every beam from where the robot was when it was measured."""
        ranges = np.asarray(scan.ranges, np.float64)
        beams = solids.hits(ranges, scan.range_max)
        base = self._poses_at(measured + beams * scan.time_increment)
        mount, height = self._robot.get_transform("base", name), self._height(name)
        drawn = ranges, beams, scan.angle_min, scan.angle_increment
        self._recording.log(f"map/{name}", solids.scan_points(drawn, base, mount, height))

    def _draw_sonar(self, name: str, sonar: RangeData, measured: float) -> None:
        """An arc: unknown is where in its cone the surface is."""
        returned = 0.0 < sonar.range < sonar.range_max
        sensor = self._pose_at(measured) * self._robot.get_transform("base", name)
        arc = solids.sonar_arc(sensor, self._height(name), sonar.range, sonar.field_of_view)
        self._recording.log(f"map/{name}", rr.LineStrips3D([arc] if returned else [], colors=[d.PLAN], radii=0.015))

    def _draw_image(self, name: str, image: RGBDImage, measured: float) -> None:
        """What a camera sees, from where it was when it saw it."""
        camera = self._robot.profile.camera
        assert camera is not None
        pose = self._pose_at(measured) * camera.base_from_camera
        self._recording.log(f"map/{name}", solids.transform(pose, camera.mount_height))
        self._recording.log(f"map/{name}/color", color_image(image.color))
        if image.depth is not None and self._is_due("depth", DEPTH_EVERY):
            farthest = camera.depth.range_max if camera.depth else float(image.depth.max())
            self._recording.log(f"map/{name}/depth", depth_image(image.depth, farthest))

    def _pose_at(self, time: float) -> Pose2D:
        return Pose2D(*(float(values[0]) for values in self._poses_at(np.array([time]))))

    def _poses_at(self, times: NDArray[np.floating]) -> tuple[NDArray[np.float64], ...]:
        """x, y [m] and heading [rad] of the base in `map` at some times, between the ticks that are known."""
        t, x, y, theta = np.array(self._poses).T
        return tuple(np.interp(times, t, values) for values in (x, y, np.unwrap(theta)))

    def _height(self, sensor: str) -> float:
        profile = self._robot.profile
        if profile.lidar and sensor == "lidar":
            return profile.lidar.height
        return profile.ultrasonics.height if profile.ultrasonics else 0.0

    # What the robot knows and does

    def _draw_map(self) -> None:
        grid = self._robot.get_map()
        if grid is self._map or not grid.data.size:
            return
        self._map = grid
        self._recording.log(
            "map/grid",
            rr.GridMap(
                data=map_colors(grid, unknown=NOTHING).tobytes(),
                format=rr.components.ImageFormat(
                    width=grid.width, height=grid.height, color_model="RGBA", channel_datatype="U8"
                ),
                cell_size=grid.resolution,
                translation=(*grid.origin, 0.01),
                opacity=0.8,
            ),
        )

    def _draw_plan(self) -> None:
        plan = self._robot.get_path()
        if np.array_equal(plan, self._plan):
            return
        self._plan = plan
        line = np.column_stack([plan, np.full(len(plan), 0.05)])
        self._recording.log("map/plan", rr.LineStrips3D([line] if len(line) else [], colors=[d.PLAN], radii=0.03))

    def _draw_signals(self, tick: TickView) -> None:
        self._recording.log("signals/velocity/estimated", rr.Scalars([*tick.pose.velocity]))
        self._recording.log("signals/velocity/commanded", rr.Scalars([*tick.commanded]))

    def _draw_intervention(self, intervention: Intervention) -> None:
        """A line in the log whenever the safety gate begins or ends to interfere."""
        if intervention is self._intervention:
            return
        self._intervention = intervention
        level = rr.TextLogLevel.INFO if intervention is Intervention.none else rr.TextLogLevel.WARN
        self._recording.log("gate", rr.TextLog(intervention.name.replace("_", " "), level=level))


def color_image(bgr: NDArray[np.uint8]) -> rr.EncodedImage | rr.Image:
    """Rerun wants RGB: here BGR becomes it."""
    return rr.Image(bgr[..., ::-1], "RGB").compress(jpeg_quality=85)


def depth_image(depth: NDArray[np.float32], farthest: float) -> rr.DepthImage:
    """In whole millimetres, which no camera measures any finer; its colours reach to `farthest` [m]."""
    millimeters = np.minimum(1000.0 * depth, 65535.0).round().astype(np.uint16)
    return rr.DepthImage(millimeters, meter=1000.0, depth_range=(0.0, 1000.0 * farthest))


def series(names: list[str], width: float) -> rr.SeriesLines:
    """Three lines over time."""
    colors = [d.BODY, (80, 190, 120, 255), d.TRAJECTORY]
    return rr.SeriesLines(names=names, colors=colors, widths=[width] * len(names))
