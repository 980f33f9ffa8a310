"""Geometry agrees with itself: the camera with the lidar, and with a ray tracer, in every scene."""

import subprocess

from verify.cases.generated import in_generated
from verify.cases.trees import PROGRAMS
from verify.harness import Case, Experiment, Row, counted_of, each, worst_of

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
    """The share of all cases' beams or pixels that are off; none may be where `at_most` is 0."""
    if at_most == 0.0:
        return worst_of(name, lambda case: case[off], at_most=0.0)
    return counted_of(name, lambda case: case[off], lambda case: case[of], form="{:.3%}", at_most=at_most)


def rows() -> list[Row]:
    return [
        share_off("beams more than 1 cm off the depth image", "beams_off", "beams", at_most=0.001),
        share_off("pixels of another id or depth than what their ray hits", "pixels_wrong", "pixels", at_most=0.0),
        # where two walls are flush with one another, the one or the other may show
        share_off("pixels of another colour alone", "pixels_of_another_colour", "pixels", at_most=0.02),
        share_off("pixels within 0.002 px of an edge, left out", "pixels_at_edges", "pixels", at_most=0.02),
    ]


EXPERIMENTS = [
    Experiment(
        "3we_depth_v2 in generated buildings",
        in_generated,
        {"run": look},
        cases=300,
        rows=rows(),
    ),
    Experiment(
        "3we_depth_v2 in the named scenes",
        look,
        variants=[{"scene": scene} for scene in SCENES],
        cases=700,
        rows=[*rows(), *(row for claim in rows() for row in each("scene", SCENES, lambda _, row=claim: row))],
    ),
]
