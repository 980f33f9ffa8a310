"""A LeRobot v3.0 dataset of a few frames, written without LeRobot."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import av
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

CAMERA = "observation.images.front"
HUES = [(220, 40, 40), (40, 200, 60), (50, 80, 220)]  # RGB, one an episode


def write_tiny_dataset(folder: Path, episodes: int = 3, frames: int = 8, *, fps: int = 10) -> Path:
    """`episodes` of `frames` each, in one data file and one video, each episode of one colour."""
    for name in ("meta/episodes/chunk-000", "data/chunk-000", f"videos/{CAMERA}/chunk-000"):
        (folder / name).mkdir(parents=True)
    count = episodes * frames
    feature = {"dtype": "float32", "shape": [3], "names": ["vx", "vy", "omega"]}
    scalar = {"shape": [1], "names": None}
    info: dict[str, Any] = {
        "codebase_version": "v3.0",
        "fps": fps,
        "features": {
            "action": feature,
            CAMERA: {"dtype": "video", "shape": [48, 64, 3], "names": ["height", "width", "channels"], "info": {}},
            "timestamp": {"dtype": "float32", **scalar},
            "frame_index": {"dtype": "int64", **scalar},
            "episode_index": {"dtype": "int64", **scalar},
            "index": {"dtype": "int64", **scalar},
            "task_index": {"dtype": "int64", **scalar},
        },
        "total_episodes": episodes,
        "total_frames": count,
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
        "robot_type": "3we_standard_v2",
        "splits": {"train": f"0:{episodes}"},
    }
    (folder / "meta/info.json").write_text(json.dumps(info))
    (folder / "meta/stats.json").write_text("{}")
    pq.write_table(pa.table({"task_index": [0], "task": ["go to the kitchen"]}), folder / "meta/tasks.parquet")
    number = np.arange(count)
    actions = pa.FixedSizeListArray.from_arrays(pa.array(np.zeros(3 * count, np.float32)), 3)
    data = {"action": actions, "frame_index": number % frames, "episode_index": number // frames, "index": number}
    data |= {"timestamp": np.float32(number % frames / fps), "task_index": np.zeros(count, np.int64)}
    pq.write_table(pa.table(data), folder / "data/chunk-000/file-000.parquet")
    zeros = [0] * episodes
    table = {
        "episode_index": list(range(episodes)),
        "tasks": [["go to the kitchen"]] * episodes,
        "length": [frames] * episodes,
        "dataset_from_index": [i * frames for i in range(episodes)],
        "dataset_to_index": [(i + 1) * frames for i in range(episodes)],
        "data/chunk_index": zeros,
        "data/file_index": zeros,
        f"videos/{CAMERA}/chunk_index": zeros,
        f"videos/{CAMERA}/file_index": zeros,
        f"videos/{CAMERA}/from_timestamp": [i * frames / fps for i in range(episodes)],
        f"videos/{CAMERA}/to_timestamp": [(i + 1) * frames / fps for i in range(episodes)],
    }
    pq.write_table(pa.table(table), folder / "meta/episodes/chunk-000/file-000.parquet")
    _write_video(folder / f"videos/{CAMERA}/chunk-000/file-000.mp4", episodes, frames, fps)
    return folder


def _write_video(path: Path, episodes: int, frames: int, fps: int) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=fps, options={"g": "2", "preset": "ultrafast"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for i in range(episodes * frames):
            picture = np.full((48, 64, 3), HUES[i // frames % len(HUES)], np.uint8)
            for packet in stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)
