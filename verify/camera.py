"""Geometry agrees with itself: the camera with the lidar, and with a ray tracer, in every scene."""

import subprocess

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, Row, Verdict

PROGRAM = PROGRAMS / "verify_camera"
SCENES = [
    "apartment_v1",
    "cluttered_v1",
    "corridor_v1",
    "dynamic_v1",
    "office_v2",
    "outdoor_v1",
    "warehouse_v1",
]


def look(seed: int, scene: str) -> Case:
    """Beams of a scan and pixels of a picture from one place, and how many are off."""
    output = subprocess.run([PROGRAM, scene, str(seed)], capture_output=True, text=True, check=True).stdout
    return {name: int(value) for name, value in (line.split() for line in output.splitlines())}


def share_off(name: str, off: str, of: str, at_most: float) -> Row:
    """The share of all cases' beams or pixels that are off."""

    def judge(cases: list[Case], _sample: bool) -> Verdict:
        wrong, total = (sum(case.get(key, 0) for case in cases) for key in (off, of))
        complete = total > 0 and all(of in case for case in cases)
        share = wrong / total if total else 1.0
        ok = complete and share <= at_most
        return Verdict(f"{wrong} of {total}", f"<= {100 * at_most:g} %", "pass" if ok else "FAIL")

    return Row(name, judge)


EXPERIMENTS = [
    Experiment(
        f"3we_depth_v2 in {scene}",
        look,
        {"scene": scene},
        cases=100,
        sample=4,
        rows=[
            share_off("beams more than 1 cm off the depth image", "beams_off", "beams", at_most=0.001),
            share_off("pixels of another id or depth than their ray meets", "pixels_wrong", "pixels", at_most=0.0),
            # where two walls are flush with one another, the one or the other may show
            share_off("pixels of another colour alone", "pixels_of_another_colour", "pixels", at_most=0.02),
            share_off("pixels within 0.002 px of an edge, left out", "pixels_at_edges", "pixels", at_most=0.02),
        ],
    )
    for scene in SCENES
]
