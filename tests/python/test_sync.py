"""The robot without `async`."""

from __future__ import annotations

import functools
import gc
import inspect
import math
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
import threewe
from threewe import ConnectionError, ContractError, Progress, Reason
from threewe.backend import BackendOptions
from threewe.sync import Robot, World

from .toy_backend import QuietBackend


@pytest.fixture(scope="module")
def the_sync_robot() -> Robot:
    return Robot(scene="corridor_v1", noise="ideal")


@pytest.fixture
def robot(the_sync_robot: Robot) -> Iterator[Robot]:
    with the_sync_robot as robot:
        assert robot.simulation is not None
        robot.simulation.reset()
        yield robot


def test_a_script(robot: Robot) -> None:
    result = robot.move_to(1.5, 0.2)
    assert result.success
    assert math.hypot(robot.get_pose().x - 1.5, robot.get_pose().y - 0.2) < 0.3
    before = robot.now
    robot.set_velocity(omega=0.5, hold=1.0)
    robot.sleep(0.5)
    assert robot.now == pytest.approx(before + 0.5)
    assert robot.get_velocity().omega == pytest.approx(0.5, abs=0.1)


def test_it_has_all_that_the_other_robot_has() -> None:
    names = {name for name, _ in inspect.getmembers(threewe.Robot) if not name.startswith("_")}
    mine = {name for name, _ in inspect.getmembers(Robot) if not name.startswith("_")}
    assert names - mine == {"timeout"}  # motions have their own time limits


def test_its_truth_has_all_that_the_other_truth_has(robot: Robot) -> None:
    there, here = threewe.Robot(scene="corridor_v1", noise="ideal").simulation, robot.simulation
    assert {name for name in dir(there) if not name.startswith("_")} <= set(dir(here))
    assert here is not None
    assert here.scene_from_map.distance(here.start_pose()) == 0.0
    assert here.profile.name == robot.profile.name


def test_it_drives_as_the_other_robot_does(robot: Robot) -> None:
    import asyncio

    async def other() -> threewe.MoveResult:
        async with threewe.Robot(scene="corridor_v1", noise="ideal") as robot:
            return await robot.move_to(1.5, 0.2)

    there, here = asyncio.run(other()), robot.move_to(1.5, 0.2)
    assert (here.pose, here.duration) == (there.pose, there.duration)


def test_thinking(robot: Robot) -> None:
    before = robot.now
    with robot.thinking(seconds=0.4):
        assert robot.now == before
    assert robot.now == pytest.approx(before + 0.4)


def test_errors_come_out(robot: Robot) -> None:
    with pytest.raises(ContractError):
        robot.set_velocity(math.nan)
    with pytest.raises(ContractError):
        robot.move_to(math.nan, 0.0)
    robot.disconnect()
    with pytest.raises(ConnectionError):
        robot.get_pose()
    with pytest.raises(ConnectionError):
        robot.move_to(1.0, 0.0)


def test_ctrl_c_stops_the_robot(robot: Robot) -> None:
    assert robot.simulation is not None

    def press(progress: Progress) -> None:
        if progress.distance_driven > 0.2 and not pressed.is_set():
            pressed.set()
            os.kill(os.getpid(), signal.SIGINT)

    pressed = threading.Event()
    with pytest.raises(KeyboardInterrupt):
        robot.explore(on_progress=press)
    robot.sleep(1.0)
    before = robot.simulation.true_pose()
    robot.sleep(0.5)
    assert robot.simulation.true_pose().distance(before) < 1e-3
    assert robot.move_forward(-0.1).reason is Reason.reached


def test_callbacks_read_but_cannot_wait(robot: Robot) -> None:
    poses: list[threewe.Pose2D] = []
    robot.move_forward(0.3, on_progress=lambda _: poses.append(robot.get_pose()))
    assert len(poses) > 3
    with pytest.raises(ContractError, match="cannot wait"):
        robot.move_forward(0.3, on_progress=lambda _: robot.sleep(0.1))


def test_the_emergency_stop_from_another_thread(robot: Robot) -> None:
    moving = threading.Event()
    stopper = threading.Thread(target=lambda: (moving.wait(), robot.emergency_stop()))
    stopper.start()
    result = robot.explore(on_progress=lambda _: moving.set())
    stopper.join()
    assert result.reason is Reason.estop
    assert robot.emergency_stopped
    robot.release_emergency_stop()


def threads_of_robots() -> int:
    gc.collect()  # those of earlier tests that nobody has any more
    return sum(thread.name == "threewe.sync" for thread in threading.enumerate())


def test_the_thread_ends_with_the_robot() -> None:
    before = threads_of_robots()
    robot = Robot(scene="corridor_v1", noise="ideal")
    assert threads_of_robots() == before + 1
    del robot
    assert threads_of_robots() == before


def test_the_truth_keeps_its_robot() -> None:
    threads = threads_of_robots()
    robot = Robot(scene="corridor_v1", noise="ideal").connect()
    truth = robot.simulation
    assert truth is not None
    before = truth.true_pose()
    robot.set_velocity(0.3)
    robot.sleep(0.5)
    del robot
    gc.collect()
    assert truth.true_pose().distance(before) > 0.05
    truth.reset()
    assert truth.true_pose() == before
    del truth
    assert threads_of_robots() == threads


def test_a_robot_that_is_dropped_is_disconnected() -> None:
    made: list[QuietBackend] = []

    def make(options: BackendOptions) -> QuietBackend:
        made.append(QuietBackend(options))
        return made[-1]

    threewe.register_backend("quiet", make)
    robot = Robot(backend="quiet").connect()
    robot.set_velocity(0.3)
    robot.sleep(0.1)
    assert made[0].disconnected == 0
    del robot
    assert made[0].disconnected == 1


def test_a_robot_is_disconnected_when_python_ends_and_says_so_to_whoever_comes_late() -> None:
    program = f"""
import atexit, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
import threewe
from threewe.sync import Robot, World
from toy_backend import QuietBackend

class Noisy(QuietBackend):
    def disconnect(self):
        print("disconnected", flush=True)

@atexit.register
def come_late():
    try:
        robot.get_pose()
    except threewe.ConnectionError as error:
        print(error)

threewe.register_backend("noisy", Noisy)
robot = Robot(backend="noisy").connect()
"""
    done = subprocess.run([sys.executable, "-W", "error", "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "disconnected\nPython is ending, and has disconnected this robot\n"


@pytest.mark.parametrize("seconds", ["long", -1.0, math.nan])
def test_thinking_for_impossible_times(seconds: float, robot: Robot) -> None:
    thought = False
    with pytest.raises(ContractError, match=r"^seconds must"), robot.thinking(seconds):
        thought = True
    assert not thought


@pytest.mark.parametrize("error", [SystemExit, KeyboardInterrupt])
def test_a_callback_that_ends_the_program_reaches_the_caller(robot: Robot, error: type[BaseException]) -> None:
    def end(_: object) -> None:
        raise error

    with pytest.raises(error):
        robot.move_forward(1.0, on_progress=end)
    robot.observe(end)
    with pytest.raises(error):
        robot.move_forward(1.0)
    before = robot.now
    robot.sleep(0.5)
    assert robot.now == pytest.approx(before + 0.5)
    assert robot.move_forward(0.1).reason is Reason.reached


def test_an_observer_that_ends_the_program_in_real_time() -> None:
    def end(_: object) -> None:
        raise SystemExit(3)

    with Robot(scene="corridor_v1", noise="ideal", realtime=True) as robot:
        robot.observe(end)
        with pytest.raises(SystemExit):
            robot.sleep(60.0)
        robot.sleep(0.1)


FORKED = """
import os, sys
from threewe import ContractError
from threewe.sync import Robot, World

with Robot(scene="corridor_v1", noise="ideal") as robot:
    if (child := os.fork()) == 0:
        for call in (robot.get_pose, lambda: robot.move_forward(0.1), lambda: robot.now, robot.disconnect):
            try:
                call()
            except ContractError as error:
                print(error, flush=True)
        del robot
        os._exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    robot.move_forward(0.1).raise_for_failure()
"""


def test_a_forked_process_is_refused_by_name() -> None:
    done = subprocess.run([sys.executable, "-c", FORKED], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("of the process that made it: after a fork make a new one") == 4


def test_a_world_of_several_robots() -> None:
    threads = threads_of_robots()
    with World(scene="warehouse_v1", noise="ideal") as world:
        first, second = world.robots
        before = world.now
        drives = [functools.partial(robot.move_forward, 0.4) for robot in world.robots]
        results = world.together(*drives)
        assert [result.reason for result in results] == [Reason.reached] * 2
        assert world.now - before < 1.2 * max(result.duration for result in results)
        first.set_velocity(0.2)
        world.sleep(0.3)
        assert first.get_velocity().vx > 0.1
        assert repr(world).startswith("sync.World(3we_standard_v2, 3we_standard_v2; robot time")
        with pytest.raises(ContractError, match="waits for robot time"):
            world.together(first.get_pose)
        with pytest.raises(ContractError, match="goal x must be finite"):
            world.together(functools.partial(first.move_to, math.inf, first.get_pose().y), second.explore)
        assert second.move_forward(0.1).success
    assert not first.connected
    del world
    assert threads_of_robots() == threads + 1  # its robots keep it
    assert first.profile.name == "3we_standard_v2"
    del first, second, drives, results
    assert threads_of_robots() == threads


def test_a_world_has_all_that_the_other_world_has() -> None:
    assert {name for name in dir(threewe.World) if not name.startswith("_")} - set(dir(World)) == {"timeout"}
