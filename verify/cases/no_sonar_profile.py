"""A robot that native environments have all sensors of."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import yaml

from verify.cases.trees import ROOT


@contextmanager
def no_sonar_profile() -> Iterator[Path]:
    """The file of a robot without ultrasonic sensors: the native form has none, and a robot slows down for an echo."""
    profile = yaml.safe_load((ROOT / "assets/robots/3we_standard_v2.yaml").read_text())
    del profile["sensors"]["ultrasonics"], profile["link"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "3we_no_sonar.yaml"
        file.write_text(yaml.safe_dump(profile))
        yield file
