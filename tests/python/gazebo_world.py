"""The stand-in for Gazebo: another process, on Debian's library of its transport, with an exported world."""

from __future__ import annotations

import itertools
import os
import re
import subprocess
from pathlib import Path

from threewe.gazebo import write_world

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/dev/tests/gazebo/gazebo_simulator"

# Out of the way of other workers that run tests, and of what people use.
PARTITION = f"threewe_{os.getppid()}_{os.environ.get('PYTEST_XDIST_WORKER', 'gw0')}"


COUNT = itertools.count()


class GazeboWorld:
    """One that runs inside `with`, where this process finds it alone; options are those of the program."""

    def __init__(
        self,
        folder: Path,
        *options: str,
        scene: str = "office_v2",
        robot: str = "3we_standard_v2",
        partition: str = "",
        noise: bool = True,
        paused: bool = False,
        odometries_share: str = "",
    ) -> None:
        self.partition = partition or f"{PARTITION}_{next(COUNT)}"
        world = write_world(scene, robot, folder)
        model = folder / "models" / robot / "model.sdf"
        if odometries_share:
            model.write_text(re.sub(r"(<odom_topic>).*?<", rf"\1{odometries_share}<", model.read_text()))
        if not noise:
            model.write_text(re.sub(r"<noise.*?</noise>", "", model.read_text(), flags=re.DOTALL))
        self.command = [str(PROGRAM), str(world), *([] if paused else ["-r"]), *options]
        self.environment = os.environ | {"IGN_PARTITION": self.partition}

    def __enter__(self) -> GazeboWorld:
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, text=True, env=self.environment)
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"
        self.before = os.environ.get("GZ_PARTITION", "")
        os.environ["GZ_PARTITION"] = self.partition
        return self

    def __exit__(self, *exception: object) -> None:
        os.environ["GZ_PARTITION"] = self.before
        self.process.terminate()
        self.process.wait(30)
        assert self.process.stdout is not None
        self.process.stdout.close()
