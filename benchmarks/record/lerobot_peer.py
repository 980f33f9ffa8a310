"""LeRobot's own writer at its defaults, in its own Python: seconds of its calls, as JSON."""

import json
import os
import sys
import time
from pathlib import Path

os.environ["HF_HUB_OFFLINE"] = "1"

import av
import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset


def main():
    """Writes the episodes that were packed for it."""
    request = json.loads(sys.argv[1])
    place, features = Path(request["place"]), request["features"]
    for feature in features.values():
        feature["shape"] = tuple(feature["shape"])
    began = time.perf_counter()
    options = {"root": place / "theirs", "robot_type": "3we_standard_v2"}
    dataset = LeRobotDataset.create("local/theirs", request["fps"], features, **options)
    adding, saving = time.perf_counter() - began, 0.0
    for i in range(request["episodes"]):
        with np.load(place / f"{i}.npz") as episode:
            given = dict(episode)
        for step, image in enumerate(images(given)):
            columns = {name: given[name][step] for name in features if name in given}
            began = time.perf_counter()
            dataset.add_frame({**columns, request["camera"]: image, "task": "look around"})
            adding += time.perf_counter() - began
        began = time.perf_counter()
        dataset.save_episode()
        saving += time.perf_counter() - began
    began = time.perf_counter()
    dataset.finalize()
    saving += time.perf_counter() - began
    print("\n" + json.dumps({"seconds": adding + saving, "saving": saving}))


def images(given):
    """The frames of an episode, decoded."""
    decoder = av.CodecContext.create("h264", "r")
    place = 0
    for length in given["lengths"]:
        packet = av.Packet(given["packets"][place : place + length].tobytes())
        place += length
        (frame,) = [*decoder.decode(packet), *decoder.decode(None)]
        decoder.flush_buffers()
        yield frame.to_ndarray(format="rgb24")


if __name__ == "__main__":
    main()
