"""The robot as a Python program sees it."""

from __future__ import annotations

import asyncio
import inspect
import itertools
import logging
import math
from collections.abc import Callable

import numpy as np
import pytest
import threewe
from threewe import (
    ConfigError,
    MoveResult,
    OccupancyGrid,
    Pose2D,
    Progress,
    Reason,
    RecoveryState,
    Robot,
    SampledPlan,
    SensorFault,
    TickView,
    TimeoutError,
    Velocity,
    World,
    Zone,
    _core,
)


@pytest.mark.parametrize("scene", threewe.scene_names())
async def test_the_five_lines_of_the_readme(scene: str) -> None:
    async with Robot(backend="mock", scene=scene) as robot:
        image = robot.get_camera_image()
        assert (image.shape, image.dtype) == ((480, 640, 3), np.uint8)
        result = await robot.move_to(x=2.0, y=1.0)
        assert result.success
        assert robot.simulation is not None
        true_pose = robot.simulation.true_pose()
        assert math.hypot(true_pose.x - 2.0, true_pose.y - 1.0) <= 0.25
    assert not robot.connected


async def test_notebooks_connect_with_a_bare_await(robot: Robot) -> None:
    await robot.disconnect()
    assert await robot.connect() is robot
    assert robot.connected
    await robot.connect()  # twice is as good as once
    assert robot.connected


async def test_every_sensor_has_a_name_and_its_health(robot: Robot) -> None:
    assert set(robot.health) == {sensor.name for sensor in robot.features.sensors}
    assert robot.health["lidar"].fault is SensorFault.none
    assert robot.health["lidar"].needed
    assert not robot.health["camera"].needed
    await robot.move_forward(0.5)
    assert all(sensor.ok for sensor in robot.health.values()), robot.health


async def test_reading_takes_no_robot_time(robot: Robot) -> None:
    before = robot.now
    for _ in range(10):
        robot.get_pose(), robot.get_lidar_scan(), robot.get_map(), robot.get_velocity()
        await asyncio.sleep(0.001)
    assert robot.now == before


@pytest.fixture
def new_robot() -> Robot:
    """One that has said nothing yet: some warnings come once in a robot's life."""
    return Robot(scene="corridor_v1", noise="ideal")


async def test_reading_without_end_at_one_stamp_is_reported_once(
    new_robot: Robot, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(3000):
        new_robot.get_pose()
    [message] = caplog.messages
    assert "robot.sleep" in message


async def test_a_velocity_is_held_no_longer_than_asked(new_robot: Robot, caplog: pytest.LogCaptureFixture) -> None:
    new_robot.set_velocity(0.3, hold=0.5)
    await new_robot.sleep(0.4)
    assert new_robot.get_velocity().vx > 0.2
    assert not caplog.messages
    await new_robot.sleep(0.6)
    assert abs(new_robot.get_velocity().vx) < 0.01
    [message] = caplog.messages
    assert "hold" in message


async def test_stop_and_a_new_velocity(robot: Robot) -> None:
    robot.set_velocity(0.3, 0.0, 0.0, hold=10.0)
    await robot.sleep(1.0)
    robot.stop()
    await robot.sleep(0.5)
    assert abs(robot.get_velocity().vx) < 0.01
    robot.set_velocity(omega=0.5)
    await robot.sleep(0.4)
    assert robot.get_velocity().omega > 0.3


async def test_motions_say_where_they_ended(robot: Robot) -> None:
    result = await robot.move_forward(0.5)
    assert result.success
    assert result.reason is Reason.reached
    assert result.pose.x == pytest.approx(0.5, abs=0.05)
    result.raise_for_failure()
    result = await robot.rotate(math.pi / 2)
    assert result.pose.theta == pytest.approx(math.pi / 2, abs=0.1)
    assert isinstance(result, MoveResult)
    assert "reached" in repr(result)


async def test_goals_in_other_frames(robot: Robot) -> None:
    await robot.rotate(math.pi / 2)
    start = robot.get_pose()
    result = await robot.move_to(0.5, 0.0, 0.0, frame="base", tolerance=0.05)
    assert result.success
    goal = start.transform((0.5, 0.0))
    assert math.dist((result.pose.x, result.pose.y), goal) < 0.1
    assert result.pose.theta == pytest.approx(start.theta, abs=0.15)


async def test_following_a_path_given_as_an_array(robot: Robot) -> None:
    path = np.array([[0.4, 0.0], [0.8, 0.1], [1.2, 0.0]])
    result = await robot.follow_path(path, tolerance=0.1)
    assert result.success
    assert math.dist((result.pose.x, result.pose.y), path[-1]) < 0.15


async def test_waypoints_are_visited_in_turn(robot: Robot) -> None:
    seen: list[Progress] = []
    waypoints = [(0.5, 0.0), (0.5, 0.4, math.pi), Pose2D(0.0, 0.4, math.pi)]
    result = await robot.follow_waypoints(waypoints, tolerance=0.1, on_progress=seen.append)
    assert result.success, result
    assert math.dist((result.pose.x, result.pose.y), (0.0, 0.4)) < 0.1
    for x, y in ((0.5, 0.0), (0.5, 0.4)):
        assert min(math.dist((one.pose.x, one.pose.y), (x, y)) for one in seen) < 0.1
    left = [one.distance_left for one in seen]
    assert left[0] == pytest.approx(1.4, abs=0.1)
    assert all(later < earlier + 0.15 for earlier, later in itertools.pairwise(left))
    turned = [one for one in seen if math.dist((one.pose.x, one.pose.y), (0.5, 0.4)) < 0.1]
    assert any(abs(one.pose.theta) > math.pi - 0.15 for one in turned)


async def test_progress_and_the_path(robot: Robot) -> None:
    seen: list[tuple[Progress, np.ndarray]] = []
    result = await robot.move_to(2.0, 0.0, on_progress=lambda progress: seen.append((progress, robot.get_path())))
    assert result.success
    left = [progress.distance_left for progress, _ in seen]
    assert len(seen) == pytest.approx(result.duration / 0.1, abs=2)
    assert left[1] > left[-2]
    seconds = [progress.time_left for progress, _ in seen]
    assert 0.4 * result.duration < seconds[1] < 1.6 * result.duration
    assert seconds[-1] < 1.0
    assert all(math.hypot(progress.pose.x, progress.pose.y) <= 2.1 for progress, _ in seen)
    assert any(len(path) for _, path in seen)
    assert all(path.shape[1] == 2 for _, path in seen)
    assert robot.get_path().shape == (0, 2)


@pytest.mark.parametrize("hardware", ["3we_standard_v2", "turtlebot_like", "3we_base_v2"])
async def test_plans_and_their_samples(hardware: str) -> None:
    async def drive(looks: bool) -> tuple[list[SampledPlan], list[Velocity], set[RecoveryState]]:
        plans: list[SampledPlan] = []
        commands: list[Velocity] = []
        states: set[RecoveryState] = set()

        def look(progress: Progress) -> None:
            states.add(progress.recovery)
            plan = robot.get_plan() if looks else None
            if plan is not None:
                assert robot.now - 0.12 < plan.made < robot.now
                plans.append(plan)

        async with Robot(hardware=hardware) as robot:
            robot.observe(lambda tick: commands.append(tick.commanded))
            assert (await robot.move_to(1.0, 0.5, on_progress=look)).success
            assert robot.get_plan() is None
        return plans, commands, states

    plans, commands, states = await drive(True)
    assert commands == (await drive(False))[1]
    assert states == {RecoveryState.driving}
    assert (len(plans) > 10) == (hardware != "3we_base_v2")
    for plan in plans:
        samples, steps = len(plan.weights), len(plan.poses)
        assert plan.poses.shape == plan.velocities.shape == (steps, 3)
        assert plan.trajectories.shape == plan.controls.shape == (samples, steps, 3)
        assert plan.weights.sum() == pytest.approx(1.0)
        np.testing.assert_allclose(np.tensordot(plan.weights, plan.controls, 1), plan.velocities, atol=1e-5)
        assert repr(plan).startswith(f"SampledPlan({samples} samples of {steps} steps of 0.05 s")
    ways = [plan.trajectories for plan in plans]
    kept = [way.copy() for way in ways]
    plans.clear()
    for way, before in zip(ways, kept, strict=True):  # an array outlives its plan
        np.testing.assert_array_equal(way, before)


@pytest.mark.parametrize("hardware", ["3we_standard_v2", "turtlebot_like"])
async def test_motions_end_standing_within_two_centimetres_of_their_goal(hardware: str) -> None:
    async with Robot(hardware=hardware, seed=3) as robot:
        for goal in [(2.0, 1.0), (0.5, 0.3), (0.0, 0.0)]:
            result = await robot.move_to(*goal)
            assert result.success
            assert result.distance_to_goal <= 0.02
            assert result.distance_to_goal + result.position_uncertainty <= 0.25
            velocity = robot.get_velocity()
            assert math.hypot(velocity.vx, velocity.vy) < 0.02
            assert abs(velocity.omega) < 0.03


async def test_the_covariance_of_the_pose_is_that_of_a_good_estimate(robot: Robot) -> None:
    await robot.move_to(2.0, 1.0)
    covariance = robot.get_pose_covariance()
    assert (covariance.shape, covariance.dtype) == ((3, 3), np.float64)
    np.testing.assert_allclose(covariance, covariance.T)
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    assert np.sqrt(np.diag(covariance))[:2].max() < 0.05
    covariance[:] = 0.0  # a copy
    assert robot.get_pose_covariance().any()


async def test_tolerances_are_how_far_off_a_motion_may_end(robot: Robot) -> None:
    result = await robot.move_to(0.5, 0.0, 1.0, tolerance=0.02, angle_tolerance=0.01)
    assert result.success
    assert result.distance_to_goal <= 0.02
    assert abs(result.pose.theta - 1.0) <= 0.01
    assert (await robot.rotate(-1.0, angle_tolerance=0.01)).success
    assert (await robot.move_forward(0.3, tolerance=0.02)).success


async def test_zones_are_kept_out_of_or_driven_through_slowly(robot: Robot) -> None:
    closed = Zone([(0.6, -0.3), (1.0, -0.3), (1.0, 0.3), (0.6, 0.3)])
    slow = Zone([(1.3, -9.0), (1.7, -9.0), (1.7, 9.0), (1.3, 9.0)], speed_limit=0.1)
    robot.set_zones([closed, slow])
    seen: list[tuple[Pose2D, Velocity]] = []
    robot.observe(lambda tick: seen.append((tick.pose.map_from_base, tick.pose.velocity)))
    assert (await robot.move_to(2.0, 0.0)).success
    assert not any(closed.contains((pose.x, pose.y)) for pose, _ in seen)
    assert max(math.hypot(v.vx, v.vy) for pose, v in seen if slow.contains((pose.x, pose.y))) < 0.13
    robot.set_zones([])
    assert (await robot.move_to(0.8, 0.0)).success
    assert repr(slow) == "Zone(4 corners, 0.10 m/s)"
    assert repr(closed) == "Zone(4 corners, keep out)"


async def test_what_on_progress_raises_comes_out_and_stops_the_robot(robot: Robot) -> None:
    def fail(progress: Progress) -> None:
        if progress.distance_driven > 0.2:
            raise LookupError("on purpose")

    with pytest.raises(LookupError):
        await robot.move_to(2.0, 0.0, on_progress=fail)
    await robot.sleep(0.5)
    assert abs(robot.get_velocity().vx) < 0.01
    assert (await robot.move_forward(0.2)).success


async def test_cancelling_commands_zero_within_one_period_and_stands_within_a_quarter_second(robot: Robot) -> None:
    assert robot.simulation is not None
    ticks: list[TickView] = []
    moving = asyncio.create_task(robot.move_to(3.0, 0.0))
    while robot.get_velocity().vx < 0.45:
        await robot.sleep(0.02)
    number = robot.observe(ticks.append)
    moving.cancel()
    with pytest.raises(asyncio.CancelledError):
        await moving
    await robot.sleep(0.25 + 0.12)  # a command takes 40 ms to the motors, which lag
    robot.unobserve(number)
    assert ticks[0].requested == Velocity()
    assert ticks[0].commanded.vx < 0.45
    commanded = [tick.commanded.vx for tick in ticks]
    assert all(later <= earlier for earlier, later in itertools.pairwise(commanded))
    assert commanded[math.ceil(0.25 / 0.02)] == 0.0
    assert abs(robot.simulation.true_velocity().vx) < 0.05


async def test_a_time_limit_over_several_motions(robot: Robot) -> None:
    began = robot.now

    async def to_and_fro() -> None:
        async with robot.timeout(2.0):
            for _ in range(100):
                await robot.move_forward(0.2)
                await robot.move_forward(-0.2)

    with pytest.raises(TimeoutError):
        await to_and_fro()
    assert robot.now == pytest.approx(began + 2.0)
    assert (await robot.move_forward(0.1)).success  # nobody owns the robot any more


async def test_thinking_takes_the_time_that_it_says(robot: Robot) -> None:
    robot.set_velocity(0.2, hold=10.0)
    began, x = robot.now, robot.get_pose().x
    async with robot.thinking(seconds=0.5):
        await asyncio.to_thread(math.factorial, 3000)
        assert robot.now == began
    assert robot.now == pytest.approx(began + 0.5)
    assert robot.get_pose().x > x + 0.02


async def test_actions(robot: Robot) -> None:
    began = robot.now
    limits = robot.profile.operating_limits
    for _ in range(50):
        executed = await robot.execute_action([0.5, 0.0, -2.0])  # clamped to [-1, 1]
    assert robot.now == pytest.approx(began + 50 * 0.02)
    assert executed.vx == pytest.approx(0.5 * limits.linear, rel=0.05)
    assert executed.omega == pytest.approx(-limits.angular, rel=0.05)
    await robot.execute_action(np.zeros(3, np.float32), period=0.1)
    crept = await robot.execute_action([1.0, 0.0, 0.0], period=0.1, creep_mode=True)
    assert abs(crept.vx) <= 0.05
    assert robot.now == pytest.approx(began + 1.2)


async def test_observers_see_every_tick(robot: Robot) -> None:
    ticks: list[TickView] = []
    number = robot.observe(ticks.append)
    robot.set_velocity(0.2)
    await robot.sleep(0.5)
    robot.unobserve(number)
    await robot.sleep(0.5)
    assert len(ticks) == 25
    assert np.allclose(np.diff([tick.now for tick in ticks]), 0.02)
    assert ticks[0].requested == Velocity(0.2)
    assert 0.0 < ticks[0].commanded.vx < 0.2
    kinds = {type(sample.data).__name__ for tick in ticks for sample in tick.samples}
    assert kinds >= {"LaserScan", "IMUData", "Odometry"}
    for tick in ticks:
        assert all(sample.received == tick.now for sample in tick.samples)


async def test_an_observer_that_fails_is_reported_once_and_disturbs_nobody(robot: Robot) -> None:
    heard: list[dict[str, object]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: heard.append(context))

    def fail(_: TickView) -> None:
        raise LookupError("on purpose")

    bad, seen = robot.observe(fail), list[float]()
    good = robot.observe(lambda tick: seen.append(tick.now))
    await robot.sleep(0.1)
    robot.unobserve(good)
    assert len(seen) == 5
    [report] = heard
    assert isinstance(report["exception"], LookupError)
    assert "is not called any more" in str(report["message"])

    # numbers are not given twice: what is gone cannot be mistaken for another
    again = robot.observe(lambda tick: seen.append(tick.now))
    robot.unobserve(bad)
    robot.unobserve(good)
    await robot.sleep(0.1)
    robot.unobserve(again)
    assert len(seen) == 10


async def test_an_observer_that_another_one_removes_is_not_called_any_more(robot: Robot) -> None:
    calls: list[str] = []
    first = robot.observe(lambda _: (calls.append("first"), robot.unobserve(second)))
    second = robot.observe(lambda _: calls.append("second"))
    await robot.sleep(0.04)
    robot.unobserve(first)
    assert calls == ["first", "first"]


async def test_observers_may_read_the_robot(robot: Robot) -> None:
    poses: list[tuple[float, threewe.Pose2D]] = []
    number = robot.observe(lambda tick: poses.append((tick.now, robot.get_pose())))
    await robot.move_forward(0.3)
    robot.unobserve(number)
    assert poses[-1][1].x > 0.2


async def test_exploring(robot: Robot) -> None:
    assert robot.simulation is not None
    meter = threewe.CoverageMeter(robot.simulation)
    meter.observe(robot.simulation.true_pose())
    first = meter.coverage(robot.get_map())
    result = await robot.explore(timeout=20.0, on_progress=lambda _: meter.observe(robot.simulation.true_pose()))  # type: ignore[union-attr]
    assert result.reason in (Reason.reached, Reason.timeout)
    assert result.explored_area > 10.0
    assert meter.coverage(robot.get_map()) > first + 0.05


async def test_the_map_frame_begins_at_the_start() -> None:
    scene = threewe.Scene.load("corridor_v1")
    x, y = scene.rooms[-1].anchor
    async with Robot(scene="corridor_v1", noise="ideal", start_pose=(x, y, 0.7)) as robot:
        assert robot.simulation is not None
        assert robot.get_pose().distance(threewe.Pose2D()) < 0.01
        assert robot.simulation.true_pose().distance(threewe.Pose2D(x, y)) < 1e-9
        assert robot.simulation.scene_from_map == robot.simulation.start_pose()
    async with Robot(scene="corridor_v1", noise="ideal", initial_pose=(5.0, -3.0, 1.0)) as robot:
        assert robot.simulation is not None
        assert robot.get_pose().distance(threewe.Pose2D(5.0, -3.0)) < 0.01
        moved = robot.simulation.scene_from_map * robot.get_pose()
        assert moved.distance(robot.simulation.true_pose()) < 0.01


async def test_a_saved_moment_can_be_lived_again(robot: Robot) -> None:
    assert robot.simulation is not None
    await robot.move_forward(0.3)
    snapshot = robot.simulation.save()

    async def live() -> list[object]:
        robot.set_velocity(0.2, 0.1, 0.5, hold=1.0)
        await robot.sleep(1.0)
        return [robot.now, robot.get_pose(), robot.simulation.true_pose(), robot.get_lidar_scan().ranges.tobytes()]  # type: ignore[union-attr]

    first = await live()
    robot.simulation.restore(snapshot)
    assert await live() == first


async def test_a_reset_repeats_the_robots_own_run_unless_it_is_given_another_seed() -> None:
    async with Robot(scene="corridor_v1", seed=7) as robot:
        assert robot.simulation is not None

        async def live() -> list[object]:
            robot.set_velocity(0.2, 0.1, 0.5, hold=1.0)
            await robot.sleep(1.0)
            return [robot.now, robot.get_pose(), robot.get_lidar_scan().ranges.tobytes()]

        runs = []
        for options in [{}, {"seed": 7}, {"seed": 0}, {}]:
            robot.simulation.reset(**options)
            runs.append(await live())
        assert runs[0] == runs[1] == runs[3] != runs[2]
    async with Robot(scene="corridor_v1", seed=7) as robot:
        assert await live() == runs[0]


async def test_time_limits_go_on_with_what_they_have_left_when_time_jumps(robot: Robot) -> None:
    truth = robot.simulation
    assert truth is not None
    snapshot, saved_at = truth.save(), robot.now

    async def live_through(jump: Callable[[], None]) -> None:
        async with robot.timeout(10.0), robot.timeout(3.0):
            await robot.sleep(1.0)
            jump()
            await robot.sleep(10.0)

    for jump, landing in ((truth.reset, 0.0), (lambda: truth.restore(snapshot), saved_at)):
        await robot.sleep(2.0)
        with pytest.raises(TimeoutError, match="3 s"):
            await live_through(jump)
        assert robot.now == pytest.approx(landing + 2.0)


async def test_the_same_seed_is_the_same_run_and_another_is_another() -> None:
    async def run(seed: int) -> list[object]:
        async with Robot(scene="corridor_v1", seed=seed) as robot:
            result = await robot.move_to(1.5, 0.2)
            return [result.pose, result.duration, robot.now, robot.get_map().data.tobytes()]

    first, again, other = await run(1), await run(1), await run(2)
    assert first == again
    assert first != other


async def test_two_robots_share_a_world() -> None:
    async with World(scene="corridor_v1", robots=["3we_standard_v2", "turtlebot_like"], noise="ideal") as world:
        a, b = world.robots
        assert (a.profile.name, b.profile.name) == ("3we_standard_v2", "turtlebot_like")
        results = await asyncio.gather(a.move_forward(0.3), b.rotate(0.5))
        assert all(results)
        assert a.now == b.now == world.now
        await b.disconnect()
        assert (await a.move_forward(0.1)).success  # goes on alone
    assert not a.connected


async def test_a_robot_can_be_used_again_on_another_loop(robot: Robot) -> None:
    await robot.disconnect()

    def elsewhere() -> bool:
        async def drive() -> bool:
            async with robot:
                return (await robot.move_forward(0.2)).success

        return asyncio.run(drive())

    assert await asyncio.to_thread(elsewhere)


async def test_real_time_goes_at_the_pace_of_the_wall_clock() -> None:
    async with Robot(scene="corridor_v1", noise="ideal", realtime=True) as robot:
        loop = asyncio.get_running_loop()
        began, robot_began = loop.time(), robot.now
        await robot.sleep(0.3)
        assert loop.time() - began >= 0.25
        assert robot.now >= robot_began + 0.3
        before = robot.now
        await asyncio.sleep(0.1)  # time goes by, whoever waits for what
        assert robot.now > before


def test_what_a_robot_is_can_be_read_before_connecting(robot: Robot, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.DEBUG):
        assert robot.features.lockstep
        sensors = {sensor.name for sensor in robot.features.sensors}
        ultrasonics = {f"ultrasonic_{place}" for place in ("front_left", "left", "front_right", "right")}
        assert sensors == {"lidar", "imu", "odometry", "battery", "camera"} | ultrasonics
        assert robot.profile.kinematics is threewe.Kinematics.holonomic
        assert "not connected" in repr(robot)
    assert not caplog.messages


async def test_in_real_time_a_robot_can_think_be_limited_and_begin_anew() -> None:
    async with Robot(scene="corridor_v1", noise="ideal", realtime=True) as robot:
        before = robot.now
        async with robot.thinking(seconds=0.3):
            held_at = robot.now
            await asyncio.sleep(0.1)
            assert robot.now == held_at
        assert robot.now >= before + 0.3
        with pytest.raises(TimeoutError):
            async with robot.timeout(0.1):
                await robot.sleep(10.0)
        assert robot.simulation is not None
        robot.simulation.reset()
        anew = robot.now
        assert anew <= before
        await robot.sleep(0.1)
        assert robot.now >= anew + 0.1


def test_options_are_those_of_cpp() -> None:
    defaults = _core.RobotOptions()
    parameters = inspect.signature(Robot.__init__).parameters
    ours = {name: it.default for name, it in parameters.items() if name not in ("self", "viewer", "detector")}
    assert set(ours) == {name for name in dir(defaults) if not name.startswith("_")}
    assert ours == {name: getattr(defaults, name) for name in ours}


def test_options_come_back_as_given() -> None:
    grid = OccupancyGrid(np.zeros((4, 6), np.int8))
    given = {"scene": "corridor_v1", "noise": "ideal", "seed": 7, "localization": "truth", "image_size": (48, 64)}
    options = _core.RobotOptions(**given, map=grid, start_pose=Pose2D(1.0, 0.0, 0.5))  # type: ignore[arg-type]
    assert {name: getattr(options, name) for name in given} == given
    assert (options.map, options.start_pose, options.initial_pose) == (grid, Pose2D(1.0, 0.0, 0.5), None)
    with pytest.raises(ConfigError, match="unknown localization 'slum'; did you mean 'slam'"):
        _core.RobotOptions(localization="slum")
