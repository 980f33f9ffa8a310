"""The recorder, as a program uses it: what is in a journal, what outlives the program, what is refused."""

import asyncio
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
import threewe
from threewe import ConfigError, ContractError, RecordingError, Robot, World, sync
from threewe.data import RecordedEpisode, Recording, TrajectoryRecorder, recover
from threewe.data.exporting import Rows, last_before
from threewe.data.video import KeyFrameDecoder, KeyFrameEncoder

SMALL = (48, 64)


async def record(folder: Path, **options: object) -> list[threewe.TickView]:
    """Two short episodes of a robot; what an observer saw in the first."""
    seen: list[threewe.TickView] = []
    async with Robot(hardware="3we_depth_v2", image_size=SMALL, **options) as robot:  # type: ignore[arg-type]
        with TrajectoryRecorder(robot, folder) as recorder:
            number = robot.observe(seen.append)
            recorder.start_episode(task="there", metadata={"floor": 2})
            await robot.move_to(1.0, 0.5)
            recorder.end_episode(success=True, metadata={"rating": 0.5})
            robot.unobserve(number)
            recorder.start_episode(task="back")
            await robot.sleep(0.5)
    return seen


def test_what_an_observer_sees_is_recorded(tmp_path: Path) -> None:
    seen = asyncio.run(record(tmp_path))
    recording = Recording(tmp_path)
    assert [episode.task for episode in recording] == ["there", "back"]
    assert [episode.success for episode in recording] == [True, None], "who left the `with` has judged nothing"
    episode = recording[0]
    assert episode.metadata == {"floor": 2, "rating": 0.5}
    assert episode.robot_type == "3we_depth_v2"
    assert episode.time.tolist() == [tick.now for tick in seen]
    assert episode.pose.tolist() == [list(tick.pose.map_from_base) for tick in seen]
    assert episode.requested.tolist() == [list(tick.requested) for tick in seen]
    assert episode.executed.tolist() == [list(tick.commanded) for tick in seen]
    scans = [s for tick in seen for s in tick.samples if isinstance(s.data, threewe.LaserScan)]
    lidar = episode.lidar()
    assert np.array_equal(lidar.ranges, [s.data.ranges for s in scans])
    assert lidar.measured.tolist() == [s.measured for s in scans]
    images = [s.data for tick in seen for s in tick.samples if isinstance(s.data, threewe.RGBDImage)]
    camera = episode.camera()
    assert len(camera) == len(images) > 20
    for i in (0, len(images) // 2, len(images) - 1):
        assert camera.packet(i) is not None
        assert np.abs(camera.color(i).astype(int) - images[i].color).mean() < 6.0, "H.264 and 4:2:0 lose a little"
        assert np.abs(camera.depth(i) * 1e-3 - images[i].depth).max() < 0.00051


def test_without_video_images_are_kept_to_the_bit(tmp_path: Path) -> None:
    with (
        sync.Robot(image_size=SMALL) as robot,
        TrajectoryRecorder(robot, tmp_path, sensors=["camera"], video=False) as recorder,
    ):
        recorder.start_episode()
        robot.sleep(0.5)
        image = robot.get_camera_image()
        recorder.end_episode()
    episode = Recording(tmp_path)[0]
    camera = episode.camera()
    assert camera.packet(len(camera) - 1) is None
    assert np.array_equal(camera.color(len(camera) - 1), image)
    assert not len(episode.lidar()), "sensors were chosen"


def test_several_robots_are_episodes_of_their_own(tmp_path: Path) -> None:
    async def run() -> None:
        async with World(robots=["3we_standard_v2", "turtlebot_like"], scene="office_v2") as world:
            with TrajectoryRecorder(world, tmp_path, sensors=["lidar", "imu"]) as recorder:
                recorder.start_episode("both")
                recorder.set_instruction("left", robot=1)
                await asyncio.gather(*(robot.move_forward(0.3) for robot in world.robots))
                recorder.end_episode(True)

    asyncio.run(run())
    recording = Recording(tmp_path)
    assert [(episode.index, episode.robot, episode.robot_type) for episode in recording] == [
        (0, 0, "3we_standard_v2"),
        (0, 1, "turtlebot_like"),
    ]
    assert recording[1].instructions[0][1] == "left"
    report = recording[0].replay()
    assert report.ticks == len(recording[0].time)
    assert report.first_difference is None
    assert report.max_deviation == 0.0


def test_steps_and_takeovers_are_marked(tmp_path: Path) -> None:
    async def run() -> None:
        async with Robot() as robot:
            with TrajectoryRecorder(robot, tmp_path, sensors=["lidar"]) as recorder:
                recorder.start_episode("loop")
                for number in range(10):
                    recorder.set_takeover(number >= 5)
                    recorder.record_step(action=[0.1 * number, 0.0])
                    await robot.execute_action([0.1 * number, 0.0, 0.0], period=0.1)
                with pytest.raises(ContractError, match="action has 3 numbers, had 2"):
                    recorder.record_step(action=[0.0, 0.0, 0.0])
                recorder.end_episode()

    asyncio.run(run())
    episode = Recording(tmp_path)[0]
    time, actions = episode.steps
    assert actions[:, 0].tolist() == pytest.approx(np.arange(10) * 0.1)
    assert episode.takeover.tolist() == [False] * 25 + [True] * 25
    rows = Rows.of(episode, 10.0)
    assert rows.time == pytest.approx(np.maximum(time, episode.time[0]))
    assert rows.following(episode.executed).shape == (10, 3)


def test_rows_show_what_was_at_hand_and_what_was_executed_next(tmp_path: Path) -> None:
    """The rows of an export, beside a loop over all of them."""
    asyncio.run(record(tmp_path, seed=4))
    episode: RecordedEpisode = Recording(tmp_path)[0]
    received = episode.lidar().received
    for fps in (50.0, 30.0, 10.0, 7.0):
        rows = Rows.of(episode, fps)
        executed = rows.following(episode.executed)
        for k, at in enumerate(rows.time):
            tick = max(i for i, t in enumerate(episode.time) if t <= at + 1e-9)
            assert rows.ticks[k] == tick
            scans = [i for i, t in enumerate(received) if t <= at + 1e-9]
            assert rows.samples(received)[k] == (scans[-1] if scans else 0)
            if k + 1 < len(rows.time):
                until = max(i for i, t in enumerate(episode.time) if t <= rows.time[k + 1] + 1e-9)
                assert executed[k] == pytest.approx(episode.executed[tick + 1 : until + 1].mean(axis=0), abs=1e-6)
    assert last_before(np.array([1.0, 2.0]), np.array([0.5, 1.0, 1.5, 2.5])).tolist() == [0, 0, 0, 1]


def test_a_killed_program_loses_less_than_a_second(tmp_path: Path) -> None:
    program = """
        import asyncio, sys
        from threewe import Robot
        from threewe.data import TrajectoryRecorder

        async def main():
            async with Robot(image_size=(48, 64)) as robot:
                recorder = TrajectoryRecorder(robot, sys.argv[1])
                recorder.start_episode("first")
                await robot.sleep(1.0)
                recorder.end_episode(success=True)
                recorder.start_episode("second")
                robot.observe(lambda tick: print(recorder.ticks, flush=True))
                await robot.sleep(1000.0)

        asyncio.run(main())
    """
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(program), tmp_path], stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout is not None
        for line in child.stdout:
            if int(line) == 150:
                os.kill(child.pid, signal.SIGKILL)
                break
        printed = [int(line) for line in child.stdout.read().split()]
    ticks = max([150, *printed])
    assert len(Recording(tmp_path)) == 1, "the second is not among them before it is recovered"
    [one] = recover(tmp_path)
    assert one.ticks >= ticks - 50
    first, second = Recording(tmp_path)
    assert (first.recovered, second.recovered) == (False, True)
    camera = second.camera()
    assert camera.color(len(camera) - 1).shape == (*SMALL, 3)
    assert recover(tmp_path) == []


def test_an_error_in_the_program_ends_the_episode_by_its_name(tmp_path: Path) -> None:
    def program() -> None:
        with sync.Robot() as robot, TrajectoryRecorder(robot, tmp_path, sensors=["lidar"]) as recorder:
            recorder.start_episode()
            robot.sleep(0.2)
            raise KeyError("no such thing")

    with pytest.raises(KeyError):
        program()
    assert Recording(tmp_path)[0].metadata == {"ended_by": "KeyError"}


def test_a_folder_has_one_recorder_and_goes_on(tmp_path: Path) -> None:
    with sync.Robot() as robot:
        with TrajectoryRecorder(robot, tmp_path, sensors=["imu"]) as recorder:
            with pytest.raises(RecordingError, match="another recorder writes into it"):
                TrajectoryRecorder(robot, tmp_path)
            assert recorder.start_episode() == 0
            with pytest.raises(ContractError, match="an episode has begun already"):
                recorder.start_episode()
            recorder.discard_episode()
            with pytest.raises(ContractError, match="no episode has begun"):
                recorder.end_episode()
            recorder.start_episode()
        with TrajectoryRecorder(robot, tmp_path, sensors=["imu"]) as recorder:
            assert recorder.start_episode() == 1
        with pytest.raises(ContractError, match="closed"):
            recorder.start_episode()
    assert len(Recording(tmp_path)) == 2


def test_to_list_a_recording_only_its_headers_are_read(tmp_path: Path) -> None:
    async def main() -> None:
        async with World(robots=["3we_depth_v2", "3we_base_v2"], scene="corridor_v1") as world:
            with TrajectoryRecorder(world, tmp_path, video=False) as recorder:
                for _ in range(3):
                    recorder.start_episode()
                    await world.robots[0].sleep(1.0)
                    recorder.end_episode()

    def bytes_read() -> int:
        return int(Path("/proc/self/io").read_text().split()[1])

    asyncio.run(main())
    files = list(tmp_path.glob("*.journal"))
    assert all(file.stat().st_size > 3_000_000 for file in files)
    before = bytes_read()
    recording = Recording(tmp_path)
    assert bytes_read() - before < 100_000 * len(files)
    assert len(recording) == 6
    assert recording.numbers == [0, 0, 1, 1, 2, 2]
    assert [episode.robot_type for episode in recording] == ["3we_depth_v2", "3we_base_v2"] * 3
    files[0].write_bytes(files[0].read_bytes()[:1000])
    with pytest.raises(ConfigError, match=rf"{files[0].name}: at byte 0: no 3we journal"):
        Recording(tmp_path)


def test_what_no_recorder_takes_is_refused(tmp_path: Path) -> None:
    with sync.Robot() as robot:
        with pytest.raises(threewe.ConfigError, match="no recorded robot has a sensor 'nose'"):
            TrajectoryRecorder(robot, tmp_path, sensors=["nose"])
        with pytest.raises(ContractError, match="robot must be a Robot, a World, or a list"):
            TrajectoryRecorder([1], tmp_path)  # type: ignore[list-item]
        with TrajectoryRecorder(robot, tmp_path) as recorder:
            for metadata in ({"x": float("nan")}, {"x": [1]}, {"x": 2**64}, {1: "x"}):
                with pytest.raises(ContractError, match="metadata"):
                    recorder.start_episode(metadata=metadata)  # type: ignore[arg-type]
    with pytest.raises(threewe.ConfigError, match="no finished journals"):
        Recording(tmp_path)


def test_each_intra_frame_stands_alone() -> None:
    encoder, decoder = KeyFrameEncoder(SMALL, "bgr24"), KeyFrameDecoder((*SMALL, 3), "bgr24")
    colors = [(0, 0, 220), (0, 200, 0), (210, 0, 0), (128, 128, 128)]
    packets = [encoder.encode(np.full((*SMALL, 3), color, np.uint8)) for color in colors]
    for number in (3, 0, 2, 2, 1, 0):
        assert np.abs(decoder.decode(packets[number]).mean(axis=(0, 1)) - colors[number]).max() < 0.05 * 255
