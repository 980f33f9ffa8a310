"""python -m verify.cases.attacked_robot

A robot on ROS 2 that drives in a circle until its input ends. It prints "drives" once it does, and in the end by how
much memory it has grown since [MiB], and what was wrong with it, as JSON.
"""

import json
import sys
import threading
from pathlib import Path

import threewe.sync
from threewe import ThreeweError

from verify.cases.real_robots import HARDWARE


def memory(name: str) -> float:
    """[MiB] of this process: what it has, VmRSS, or the most that it had, VmHWM."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(f"{name}:")) / 1024


def main() -> None:
    ended = threading.Event()
    said = ""
    with threewe.sync.Robot("real", HARDWARE) as robot:
        robot.set_velocity(0.1, 0.0, 0.3, hold=2.0)
        robot.sleep(1.0)
        before = memory("VmRSS")
        print("drives", flush=True)
        threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
        while not ended.is_set():
            try:
                robot.set_velocity(0.1, 0.0, 0.3, hold=1.0)
                robot.sleep(0.5)
            except ThreeweError as error:  # it stands then
                said = str(error)
                ended.wait(0.5)
        faults = [
            f"{name}: {sensor.fault.name} {sensor.detail}" for name, sensor in robot.health.items() if not sensor.ok
        ]
        print(json.dumps({"grown": memory("VmHWM") - before, "said": said or "; ".join(faults)}), flush=True)


if __name__ == "__main__":
    main()
