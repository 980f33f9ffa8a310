"""HDF5, MCAP and TUM exports, read back by the formats' own libraries and compared with the recording."""

from __future__ import annotations

import asyncio
import json
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
from threewe import ConfigError, Pose2D, Robot, RobotProfile, World, asset_directories
from threewe.data import Recording, TrajectoryRecorder
from threewe.data.exporting import export
from threewe.data.showing import contact_sheet


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
    np.testing.assert_allclose([*(flat(fixed["map"]) * Pose2D(*episode.pose[0]))], episode.true_pose[0], atol=1e-9)
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


def test_a_profile_that_is_gone_can_be_named(tmp_path: Path) -> None:
    (shipped,) = (path for folder in asset_directories() for path in Path(folder).glob("robots/3we_base_v2.yaml"))
    profile = tmp_path / "mine.yaml"
    shutil.copy(shipped, profile)

    async def main() -> None:
        async with Robot(hardware=str(profile), scene="corridor_v1") as robot:
            with TrajectoryRecorder(robot, tmp_path / "drive", sensors=["imu", "odometry"]) as recorder:
                recorder.start_episode()
                await robot.sleep(0.1)
                recorder.end_episode()

    asyncio.run(main())
    profile.unlink()
    recording = Recording(tmp_path / "drive")
    for format in ("mcap", "hdf5", "rerun"):
        with pytest.raises(ConfigError, match=r"mine.yaml.*`hardware`"):
            export(recording, tmp_path / "out", format)
        export(recording, tmp_path / format, format, hardware="3we_base_v2")
    assert export(recording, tmp_path / "tum", "tum").exists()


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
