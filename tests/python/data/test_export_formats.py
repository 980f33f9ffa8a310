"""HDF5, MCAP and TUM exports, read back by the formats' own libraries and compared with the recording."""

from __future__ import annotations

import asyncio
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import av
import h5py
import numpy as np
import pytest
from data.recorded import SIZE, Recorded, record
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray
from PIL import Image
from threewe import ConfigError, Pose2D, Robot, RobotProfile, World
from threewe.data import Recording, TrajectoryRecorder
from threewe.data.cli import app
from threewe.data.exporting import export
from threewe.data.lerobot import Dataset
from threewe.data.replaying import replay_all
from threewe.data.showing import contact_sheet
from typer.testing import CliRunner


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return record(tmp_path_factory.mktemp("formats") / "video")


@pytest.fixture(scope="module")
def raw(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return record(tmp_path_factory.mktemp("formats") / "raw", episodes=1, video=False)


def test_red_is_red_in_the_recording_and_as_png(recorded: Recorded, tmp_path: Path) -> None:
    rgb = recorded.recording[0].camera().color(0)[..., ::-1]
    Image.fromarray(np.ascontiguousarray(rgb)).save(tmp_path / "frame.png")
    with Image.open(tmp_path / "frame.png") as image:
        recorded.assert_red(np.asarray(image))


def test_red_is_red_in_the_video_of_a_lerobot_dataset(recorded: Recorded, tmp_path: Path) -> None:
    export(recorded.recording, tmp_path / "dataset", fps=10)
    (video,) = (tmp_path / "dataset").glob("videos/**/*.mp4")
    recorded.assert_red(first_frame(video))


def first_frame(video: Path) -> NDArray[np.uint8]:
    """(H, W, 3) RGB, by FFmpeg's own program where it is installed."""
    if program := shutil.which("ffmpeg"):
        words = [program, "-v", "error", "-i", video, "-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
        done = subprocess.run(words, capture_output=True, check=True)
        return np.frombuffer(done.stdout, np.uint8).reshape(*SIZE, 3)
    with av.open(str(video)) as file:
        return next(file.decode(video=0)).to_ndarray(format="rgb24")


# HDF5


@pytest.fixture(scope="module")
def hdf5(recorded: Recorded) -> Path:
    return export(recorded.recording, recorded.folder.parent / "drives.h5", "hdf5")


def test_hdf5_holds_every_tick(recorded: Recorded, hdf5: Path) -> None:
    with h5py.File(hdf5) as file:
        assert sorted(file) == ["episode_000000", "episode_000001"]
        for episode in recorded.recording:
            group = file[f"episode_{episode.index:06d}"]
            assert group.attrs["task"] == "go to the couch"
            assert bool(group.attrs["success"]) is (episode.index == 0)
            assert json.loads(group.attrs["metadata"]) == {"k": episode.index, "note": "x/y"}
            names = {"time", "pose", "odom_from_base", "true_pose", "velocity", "requested", "executed", "takeover"}
            assert set(group["ticks"]) == names
            for name in names:
                np.testing.assert_array_equal(group["ticks"][name], getattr(episode, name), err_msg=name)
            assert group["ticks/pose"].attrs["frame"] == "map"
            assert group["ticks/pose"].attrs["units"] == "m, m, rad"
            assert group["ticks/executed"][:, 0].max() > 0.2  # it drove


def test_hdf5_holds_every_sample_with_its_stamps(recorded: Recorded, hdf5: Path) -> None:
    episode = recorded.recording[0]
    lidar, imu, odometry, battery = episode.lidar(), episode.imu(), episode.odometry(), episode.battery()
    with h5py.File(hdf5) as file:
        sensors = file["episode_000000/sensors"]
        assert set(sensors) == set(episode.sensors)
        for name, track in {"lidar": lidar, "imu": imu, "odometry": odometry, "battery": battery}.items():
            np.testing.assert_array_equal(sensors[name]["measured"], track.measured)
            np.testing.assert_array_equal(sensors[name]["received"], track.received)
        np.testing.assert_array_equal(sensors["lidar/ranges"], lidar.ranges)
        np.testing.assert_array_equal(sensors["imu/angular_velocity"], imu.angular_velocity)
        np.testing.assert_array_equal(sensors["odometry/pose"], odometry.pose)
        assert sensors["lidar"].attrs["angle_increment"] == lidar.angle_increment
        mount = RobotProfile.load("3we_depth_v2").lidar.base_from_lidar
        np.testing.assert_allclose(sensors["lidar"].attrs["base_from_sensor"], [*mount])


def test_hdf5_holds_red_images_and_depth_without_loss(recorded: Recorded, hdf5: Path) -> None:
    camera = recorded.recording[0].camera()
    with h5py.File(hdf5) as file:
        group = file["episode_000000/sensors/camera"]
        assert group["color"].shape == (len(camera), *SIZE, 3)
        recorded.assert_red(group["color"][0])
        for i in range(len(camera)):
            np.testing.assert_array_equal(group["color"][i], camera.color(i)[..., ::-1])
            np.testing.assert_array_equal(group["depth"][i], camera.depth(i))
        assert group["depth"].attrs["units"] == "mm"


# MCAP


@pytest.fixture(scope="module")
def mcap(recorded: Recorded) -> dict[str, list[Any]]:
    export(recorded.recording, recorded.folder.parent / "mcap", "mcap")
    return topics(recorded.folder.parent / "mcap/episode_000000.mcap")


def topics(path: Path) -> dict[str, list[Any]]:
    """Topic -> (log time [ns], decoded message) in order of the file."""
    found: dict[str, list[Any]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if channel.message_encoding == "json":
                value = json.loads(message.data)
            else:
                assert schema is not None
                assert schema.name.startswith("foxglove.")
                value = DecoderFactory().decoder_for("protobuf", schema)(message.data)  # type: ignore[misc]
            found.setdefault(channel.topic, []).append((message.log_time, value))
    return found


def test_mcap_has_the_stamps_of_the_recording(recorded: Recorded, mcap: dict[str, list[Any]]) -> None:
    episode = recorded.recording[0]
    with (recorded.folder.parent / "mcap/episode_000000.mcap").open("rb") as file:
        reader = make_reader(file)
        about = {record.name: record.metadata for record in reader.iter_metadata()}["episode"]
        logged = [message.log_time for _, _, message in reader.iter_messages(log_time_order=False)]
    assert logged == sorted(logged)
    assert about["task"] == "go to the couch"
    assert json.loads(about["metadata"]) == {"k": 0, "note": "x/y"}
    offset = int(about["robot_time_offset_ns"])
    assert [time - offset for time, _ in mcap["/pose"]] == [round(t * 1e9) for t in episode.time]
    assert [time - offset for time, _ in mcap["/lidar"]] == [round(t * 1e9) for t in episode.lidar().received]
    measured = [scan.timestamp.ToNanoseconds() - offset for _, scan in mcap["/lidar"]]
    assert measured == [round(t * 1e9) for t in episode.lidar().measured]
    assert abs(mcap["/pose"][0][0] / 1e9 - episode.started) < 1e-3


def test_mcap_transforms_lead_from_the_map_to_the_sensors(recorded: Recorded, mcap: dict[str, list[Any]]) -> None:
    episode = recorded.recording[0]
    assert len(mcap["/tf"]) == len(episode.time)
    for i in (0, len(episode.time) - 1):
        map_from_odom, odom_from_base = mcap["/tf"][i][1].transforms
        assert [map_from_odom.parent_frame_id, map_from_odom.child_frame_id] == ["map", "odom"]
        assert [odom_from_base.parent_frame_id, odom_from_base.child_frame_id] == ["odom", "base"]
        np.testing.assert_allclose([*(flat(map_from_odom) * flat(odom_from_base))], episode.pose[i], atol=1e-9)
    fixed = {part.child_frame_id: part for part in mcap["/tf_static"][0][1].transforms}
    np.testing.assert_allclose([*flat(fixed["map"])], [*episode.scene_from_map], atol=1e-9)
    assert fixed.keys() >= {"lidar", "camera", "camera_optical"}
    assert fixed["camera_optical"].parent_frame_id == "camera"


def flat(part: Any) -> Pose2D:
    assert part.rotation.x == part.rotation.y == 0.0
    return Pose2D(part.translation.x, part.translation.y, 2 * np.arctan2(part.rotation.z, part.rotation.w))


def test_mcap_holds_scans_actions_and_readings(recorded: Recorded, mcap: dict[str, list[Any]]) -> None:
    episode = recorded.recording[0]
    lidar = episode.lidar()
    for (_, scan), ranges in zip(mcap["/lidar"], lidar.ranges, strict=True):
        hit = (ranges > 0) & (ranges < lidar.range_max)
        np.testing.assert_array_equal(np.asarray(scan.ranges, np.float32)[hit], ranges[hit])
        assert not np.isfinite(np.asarray(scan.ranges)[~hit]).any()
        assert scan.end_angle == pytest.approx(lidar.angle_min + (len(ranges) - 1) * lidar.angle_increment)
    for topic, values in (("/action/requested", episode.requested), ("/action/executed", episode.executed)):
        found = [[message[name] for name in ("vx", "vy", "omega")] for _, message in mcap[topic]]
        np.testing.assert_array_equal(found, values)
    assert len(mcap["/imu"]) == len(episode.imu())
    assert mcap["/battery"][0][1]["charge"] == episode.battery().charge[0]
    assert mcap["/instruction"][0][1] == {"instruction": "go to the couch"}
    assert len(mcap["/true_pose"]) == len(episode.time)


def test_mcap_video_is_the_recorded_one_and_red(recorded: Recorded, mcap: dict[str, list[Any]]) -> None:
    camera = recorded.recording[0].camera()
    assert [message.data for _, message in mcap["/camera/color"]] == [camera.packet(i) for i in range(len(camera))]
    decoder = av.CodecContext.create("h264", "r")
    frames = []
    for _, message in mcap["/camera/color"]:
        assert message.format == "h264"
        frames += decoder.decode(av.Packet(message.data))
    frames += decoder.decode(None)
    assert len(frames) == len(camera)
    recorded.assert_red(frames[0].to_ndarray(format="rgb24"))
    for i, (_, message) in enumerate(mcap["/camera/depth"]):
        assert message.encoding == "16UC1"
        shape = (message.height, message.step // 2)
        np.testing.assert_array_equal(np.frombuffer(message.data, "<u2").reshape(shape), camera.depth(i))


def test_images_that_were_kept_raw_stay_so(raw: Recorded, tmp_path: Path) -> None:
    found = topics(export(raw.recording, tmp_path / "one.mcap", "mcap"))
    camera = raw.recording[0].camera()
    assert "/camera/color" not in found
    for i, (_, message) in enumerate(found["/camera/color_raw"]):
        assert message.encoding == "bgr8"
        np.testing.assert_array_equal(np.frombuffer(message.data, np.uint8).reshape(*SIZE, 3), camera.color(i))


# TUM


def test_tum_trajectories_are_the_poses(recorded: Recorded, tmp_path: Path) -> None:
    export(recorded.recording, tmp_path / "tum", "tum", truth=True)
    names = [f"episode_00000{i}{kind}" for i in (0, 1) for kind in (".true.tum", ".tum")]
    assert sorted(path.name for path in (tmp_path / "tum").iterdir()) == names
    episode = recorded.recording[1]
    for name, poses in (("episode_000001.tum", episode.pose), ("episode_000001.true.tum", episode.true_pose)):
        t, x, y, z, qx, qy, qz, qw = np.loadtxt(tmp_path / "tum" / name).T
        np.testing.assert_allclose(t, episode.time, atol=1e-6)
        np.testing.assert_allclose(np.stack([x, y, 2 * np.arctan2(qz, qw)], axis=1), poses, atol=1e-6)
        assert not np.any([z, qx, qy])


# mistakes


@pytest.mark.parametrize(
    ("output", "format", "options", "message"),
    [
        ("there", "hdf5", {}, r"there: exists already"),
        ("there", "mcap", {}, r"there: exists already"),
        ("a", "hdf6", {}, r"did you mean 'hdf5'"),
        ("a", "tum", {"truht": True}, r"did you mean 'truth'"),
        ("a", "mcap", {"hardware": "3we_deep_v2"}, r"3we_depth_v2"),
        ("a", "hdf5", {"fps": 10}, r"fps is for 'lerobot'"),
        ("a.mcap", "mcap", {}, r"2 episodes, each of which gets a file"),
        ("a.tum", "tum", {"truth": True}, r"name a folder"),
        ("there/a", "hdf5", {}, r"there/a: cannot be written"),
    ],
)
def test_mistakes_are_one_error_and_leave_nothing(
    recorded: Recorded, tmp_path: Path, output: str, format: str, options: dict[str, Any], message: str
) -> None:
    (tmp_path / "there").write_text("mine")
    with pytest.raises(ConfigError, match=message) as found:
        export(recorded.recording, tmp_path / output, format, **options)
    assert "\n" not in str(found.value)
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
    assert (tmp_path / "there").read_text() == "mine"


@pytest.mark.parametrize(("format", "package"), [("hdf5", "h5py"), ("mcap", "mcap.writer")])
def test_a_missing_package_is_named(
    recorded: Recorded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, format: str, package: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.delitem(sys.modules, f"threewe.data.export_{format}", raising=False)
    with pytest.raises(ConfigError, match=r'pip install "threewe\[data\]"'):
        export(recorded.recording, tmp_path / "a", format)


@pytest.fixture(scope="module")
def orphan(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Of a robot whose lidar is mounted elsewhere than on any known one; its profile's file is gone."""
    folder = tmp_path_factory.mktemp("orphan")
    profile = folder / "mine.yaml"
    profile.write_text(re.sub(r"base_from_lidar: \[.*\]", "base_from_lidar: [0.05, -0.03, 0.4]", SHIPPED))

    async def main() -> None:
        start = {"start_pose": (2.0, 1.0, 0.3), "initial_pose": (1.0, 0.5, 0.1)}
        async with Robot(hardware=str(profile), scene="corridor_v1", **start) as robot:
            assert robot.simulation is not None
            with TrajectoryRecorder(robot, folder / "drive", sensors=["lidar", "odometry"]) as recorder:
                recorder.start_episode(metadata={"scene_from_map": str([*robot.simulation.scene_from_map])})
                robot.set_velocity(0.2, 0.0, 0.3)
                await robot.sleep(0.6)
                robot.stop()
                recorder.end_episode()

    asyncio.run(main())
    profile.unlink()
    return Recording(folder / "drive")


SHIPPED = RobotProfile.load("3we_standard_v2").yaml
MOUNT = [0.05, -0.03, 0.4]


def test_a_recording_knows_its_robot_and_where_the_map_lies(orphan: Recording) -> None:
    episode = orphan[0]
    assert episode.profile.name == episode.robot_type == "mine"
    assert episode.profile.lidar is not None
    assert [*episode.profile.lidar.base_from_lidar] == MOUNT
    assert [*episode.scene_from_map] == json.loads(episode.metadata["scene_from_map"])
    np.testing.assert_allclose(
        [*(episode.scene_from_map * Pose2D(*episode.pose[0]))], episode.true_pose[0], atol=0.02
    )  # which differ by what the robot's own localization is off
    assert RobotProfile.load("3we_depth_v2").with_image_size(48, 64).yaml == RobotProfile.load("3we_depth_v2").yaml


def test_every_format_has_the_mounts_of_a_robot_whose_profile_is_gone(orphan: Recording, tmp_path: Path) -> None:
    episode = orphan[0]
    fixed = topics(export(orphan, tmp_path / "a.mcap", "mcap"))["/tf_static"][0][1].transforms
    found = {part.child_frame_id: flat(part) for part in fixed}
    np.testing.assert_allclose([*found["lidar"]], MOUNT)
    np.testing.assert_allclose([*found["map"]], [*episode.scene_from_map])
    with (tmp_path / "a.mcap").open("rb") as file:
        (about,) = make_reader(file).iter_metadata()
    assert about.metadata["hardware"] == episode.hardware
    with h5py.File(export(orphan, tmp_path / "a.h5", "hdf5")) as file:
        group = file["episode_000000"]
        assert group["sensors/lidar"].attrs["base_from_sensor"].tolist() == MOUNT
        assert group.attrs["scene_from_map"].tolist() == [*episode.scene_from_map]
        assert group["hardware"].asstr()[()] == episode.hardware
    info = json.loads((export(orphan, tmp_path / "lerobot") / "meta" / "info.json").read_text())
    assert info["features"]["observation.lidar"]["info"]["base_from_sensor"] == MOUNT
    assert export(orphan, tmp_path / "rerun", "rerun").exists()
    assert contact_sheet(orphan).width > 0
    with pytest.raises(ConfigError, match="3we_base_v2"):
        export(orphan, tmp_path / "b.mcap", "mcap", hardware="3we_bas_v2")
    other = topics(export(orphan, tmp_path / "b.mcap", "mcap", hardware="3we_standard_v2"))["/tf_static"][0][1]
    assert [*flat(next(part for part in other.transforms if part.child_frame_id == "lidar"))] != MOUNT


@pytest.mark.parametrize("backend", [None, "mock"])
def test_a_robot_whose_profile_is_gone_is_replayed(orphan: Recording, backend: str | None) -> None:
    [(line, same)] = replay_all(orphan.path, backend, "corridor_v1", None)
    assert same
    assert ("the same to the bit" if backend is None else "from where it was recorded to end") in line


def test_actions_of_a_differential_base_have_no_vy(tmp_path: Path) -> None:
    """So that what LeRobot learns from them can drive it; they are replayed as they are."""

    async def main() -> None:
        async with Robot(hardware="turtlebot_like", scene="office_v2", noise="ideal") as robot:
            with TrajectoryRecorder(robot, tmp_path / "drive", sensors=["lidar"]) as recorder:
                recorder.start_episode()
                await robot.move_forward(0.3)
                await robot.rotate(0.5)
                recorder.end_episode(success=True)

    asyncio.run(main())
    dataset = Dataset.open(export(Recording(tmp_path / "drive"), tmp_path / "dataset", fps=10))
    assert dataset.features["action"].names == dataset.features["action.requested"].names == ["vx", "omega"]
    forward, turning = dataset.episodes[0].columns()["action"].sum(axis=0) / 10.0
    assert forward == pytest.approx(0.3, abs=0.02)
    assert turning == pytest.approx(0.5, abs=0.02)
    [(line, _)] = replay_all(dataset.root, None, "office_v2", None)
    found = re.search(r"ends (\S+) m from .* after (\S+) m", line)
    assert found is not None
    assert float(found[1]) < 0.02 < 0.25 < float(found[2])


def test_what_cannot_be_replayed_is_one_error(orphan: Recording, tmp_path: Path) -> None:
    dataset = export(orphan, tmp_path / "dataset", fps=10)
    for path in (orphan.path, dataset):
        with pytest.raises(ConfigError, match=r"has no episode 7$"):
            list(replay_all(path, None, "corridor_v1", 7))
    info = dataset / "meta" / "info.json"
    info.write_text(info.read_text().replace('"theta"', '"heading"'))
    with pytest.raises(ConfigError, match=r"has no `observation.state` of x, y \[m\] and theta"):
        list(replay_all(dataset, None, "corridor_v1", None))


def test_episodes_without_ticks_are_left_out_of_every_format(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        async with Robot(hardware="3we_standard_v2", scene="corridor_v1") as robot:
            with TrajectoryRecorder(robot, tmp_path / "some", sensors=["imu", "lidar"]) as recorder:
                for seconds in (0.0, 0.2, 0.0, 0.3):
                    recorder.start_episode()
                    await robot.sleep(seconds)
                    recorder.end_episode(success=True)
            with TrajectoryRecorder(robot, tmp_path / "none") as recorder:
                recorder.start_episode()
                recorder.end_episode()

    asyncio.run(main())
    recording = Recording(tmp_path / "some")
    lengths = [len(episode.time) for episode in recording]
    assert [length > 0 for length in lengths] == [False, True, False, True]
    for format, kept in (("lerobot", 2), ("hdf5", 2), ("mcap", 2), ("rerun", 2), ("tum", 2)):
        caplog.clear()
        told: list[tuple[int, int]] = []
        made = export(recording, tmp_path / format, format, on_progress=lambda *at, told=told: told.append(at))
        assert told[-1] == (kept, kept)
        assert [warning.levelname for warning in caplog.records] == ["WARNING"] * 2
        for number, warning in zip((0, 2), caplog.records, strict=True):
            assert f"episode_{number:06d}.journal" in warning.getMessage()
            assert "no ticks" in warning.getMessage()
        if format == "lerobot":
            assert [len(episode) for episode in Dataset.open(made).episodes] == [lengths[1], lengths[3]]
        elif format == "hdf5":
            with h5py.File(made) as file:
                assert sorted(file) == ["episode_000001", "episode_000003"]
        else:
            assert sorted(path.stem for path in made.iterdir()) == ["episode_000001", "episode_000003"]
        with pytest.raises(ConfigError, match="no episode has any ticks"):
            export(Recording(tmp_path / "none"), tmp_path / "empty", format)
    caplog.clear()
    assert contact_sheet(recording).height > 0
    assert len(caplog.records) == 2
    with pytest.raises(ConfigError, match="no episode has any ticks"):
        contact_sheet(Recording(tmp_path / "none"))
    done = CliRunner().invoke(app, ["export", str(tmp_path / "some"), "-o", str(tmp_path / "x"), "-f", "tum"])
    assert "x: 2 episodes as tum" in done.output.replace("\n", "")


def test_robots_of_one_episode_get_files_of_their_own(tmp_path: Path) -> None:
    async def main() -> None:
        async with World(scene="corridor_v1") as world:
            with TrajectoryRecorder(world, tmp_path / "drive", sensors=["odometry"]) as recorder:
                recorder.start_episode()
                await world.robots[0].sleep(0.1)
                recorder.end_episode()

    asyncio.run(main())
    export(Recording(tmp_path / "drive"), tmp_path / "tum", "tum")
    names = ["episode_000000.tum", "episode_000000_robot_1.tum"]
    assert sorted(path.name for path in (tmp_path / "tum").iterdir()) == names
    with h5py.File(export(Recording(tmp_path / "drive"), tmp_path / "a.h5", "hdf5")) as file:
        assert sorted(file) == ["episode_000000", "episode_000000_robot_1"]


def test_steps_instructions_takeovers_and_odd_texts_are_kept(tmp_path: Path) -> None:
    task = 'a "quoted"\ntask, \0 漢字 \U0001f600'

    async def main() -> None:
        async with Robot(hardware="3we_base_v2", scene="corridor_v1") as robot:
            with TrajectoryRecorder(robot, tmp_path / "odd", sensors=["imu"]) as recorder:
                recorder.start_episode(task=task, metadata={"a/b": "\0", "": True, "huge": 2**63 - 1})
                await robot.sleep(0.1)
                recorder.set_instruction("turn back")
                recorder.set_takeover(True)
                for k in range(2):
                    recorder.record_step(action=[k, 0.5])
                    await robot.sleep(0.1)
                recorder.end_episode()

    asyncio.run(main())
    recording = Recording(tmp_path / "odd")
    episode = recording[0]
    steps, actions = episode.steps
    with h5py.File(export(recording, tmp_path / "a.h5", "hdf5")) as file:
        group = file["episode_000000"]
        assert group.attrs["task"] == task.replace("\0", "\ufffd")
        assert json.loads(group.attrs["metadata"]) == {"a/b": "\0", "": True, "huge": 2**63 - 1}
        assert "success" not in group.attrs
        np.testing.assert_array_equal(group["steps/time"], steps)
        np.testing.assert_array_equal(group["steps/action"], actions)
        assert group["instructions/text"].asstr()[:].tolist() == ["turn back"]
        np.testing.assert_array_equal(group["ticks/takeover"], episode.takeover)
    found = topics(export(recording, tmp_path / "one.mcap", "mcap"))
    assert [message["instruction"] for _, message in found["/instruction"]] == [task, "turn back"]
    assert [message["action"] for _, message in found["/action/step"]] == actions.tolist()
    assert [message["takeover"] for _, message in found["/takeover"]] == episode.takeover.tolist()
    assert episode.takeover.any()
    assert not episode.takeover.all()
    assert export(recording, tmp_path / "one.rrd", "rerun").exists()
    assert contact_sheet(recording).width > 0
