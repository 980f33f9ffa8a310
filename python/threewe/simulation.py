"""The truth about a robot in a simulated world."""

from __future__ import annotations

from threewe import _core
from threewe._arguments import PoseLike, as_number, as_point, as_pose, as_seed, as_switch
from threewe._core import CameraIntrinsics, OccupancyGrid, Pose2D, RobotProfile, SemanticImage, Snapshot
from threewe._options import known_options
from threewe._time import RobotTime
from threewe.errors import ContractError, HardwareError


class Simulation(_core.Simulation):
    """The truth about a robot in a simulated world, for metrics, drawings and training.

    All poses are in the scene's frame. The robot itself never sees it.
    """

    def __init__(self, world: _core.World, robot: int, robot_time: RobotTime) -> None:
        super().__init__(world, robot)
        self.profile: RobotProfile = world.robot(robot).profile
        self._time = robot_time

    @known_options
    def reset(self, *, seed: int | None = None, pose: PoseLike | None = None, episode: int = 0) -> None:
        """Begins anew at time 0, and waits until every sensor has delivered.

        Motions end as `cancelled`, sleeps end, timeouts go on with what they have left.
        All noise is drawn from `seed`, the one that the robot was made with where left out, anew for each `episode` of
        it. The robot starts at `pose`, or at the scene's own start pose without it. Raises ConfigError when that is
        inside an obstacle.
        """
        super().reset(
            seed=None if seed is None else as_seed("seed", seed),
            pose=None if pose is None else as_pose("pose", pose),
            episode=as_seed("episode", episode, 32),
        )
        self._time.wake()

    def teleport(self, pose: PoseLike) -> None:
        """Teleports the robot to `pose` without its noticing, as a kidnapped robot.

        Raises ConfigError when something stands there.
        """
        super().teleport(as_pose("pose", pose))

    def sample_free_pose(self, seed: int) -> Pose2D:
        """A pose where the robot fits with 5 cm to spare: a pure function of the seed."""
        return super().sample_free_pose(as_seed("seed", seed))

    def geodesic(self, a: PoseLike, b: PoseLike) -> float:
        """Length [m] of the shortest path for the robot's footprint, (x, y) or Pose2D each; infinity without one."""
        return super().geodesic(as_point("a", a), as_point("b", b))

    @known_options
    def look(  # type: ignore[override]
        self,
        intrinsics: CameraIntrinsics | None = None,
        pose: PoseLike | None = None,
        height: float | None = None,
        *,
        with_itself: bool | None = None,
    ) -> SemanticImage:
        """What a level camera would truly show now: colour and depth without noise, and what each pixel shows.

        Args:
            intrinsics: of the camera; the robot's own where left out.
            pose: where it is and looks, in the scene's frame [m, m, rad]; that of the robot's own where left out.
            height: [m] of its axis above the floor; that of the robot's own where left out.
            with_itself: whether the robot itself is in sight; where left out, only of another `pose`.

        Raises:
            HardwareError: something was left out, and the robot has no camera.
            ConfigError: a camera that is not above the floor.
        """
        own = self.profile.camera
        itself = pose is not None if with_itself is None else as_switch("with_itself", with_itself)
        if own is None and (intrinsics is None or pose is None or height is None):
            raise HardwareError(f"robot '{self.profile.name}' has no camera: look() needs intrinsics, pose and height")
        if own is not None:
            intrinsics = own.intrinsics if intrinsics is None else intrinsics
            pose = self.true_pose() * own.base_from_camera if pose is None else pose
            height = own.mount_height if height is None else height
        if not isinstance(intrinsics, CameraIntrinsics):
            raise ContractError(f"intrinsics must be CameraIntrinsics, got {intrinsics!r}")
        assert pose is not None
        assert height is not None
        return super().look(intrinsics, as_pose("pose", pose), as_number("height", height), itself)

    def save(self) -> Snapshot:
        """Everything the future depends on. Raises ContractError while a motion is in progress or in an observer."""
        return super().save()

    def restore(self, snapshot: Snapshot) -> None:
        """Goes on from where `save` was called. Sleeps end."""
        if not isinstance(snapshot, Snapshot):
            raise ContractError(f"snapshot must be what `save` returned, got {snapshot!r}")
        super().restore(snapshot)
        self._time.wake()


class CoverageMeter(_core.CoverageMeter):
    """Measures an exploration.

    Coverage is the share of reachable 5 cm cells that a noise-free ray from the true pose crossed within 8 m and that
    the robot's own map marks free within 10 cm.
    """

    def __init__(self, simulation: Simulation) -> None:
        super().__init__(simulation.scene, simulation.profile)
        self._simulation = simulation

    def coverage(self, grid: OccupancyGrid) -> float:  # type: ignore[override]
        """The share, 0 to 1, that was seen and that the robot's own map marks free."""
        return super().coverage(grid, self._simulation.scene_from_map)
