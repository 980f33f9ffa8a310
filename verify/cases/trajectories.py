"""Ten minutes of driving about by the robot's own SLAM: how far off it was on the way, and whether it knew."""

import subprocess

import numpy as np
from numpy.typing import NDArray

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Row, info, known_miss, mean_of, share_of, worst_of

PROGRAM = PROGRAMS / "verify_trajectory"
SECONDS = 600
FEATURELESS = ["corridor_v1", "outdoor_v1"]
"""Where a lidar that sees 12 m cannot tell how far along a bare wall it is."""
HARDER = 1.6
"""So much farther off may robots be that are worse than any should be."""
LEAST, MOST = 1.68, 4.7
"""95 % of means of a normalised squared error (chi squared, three degrees of freedom) over ten independent poses."""


def kept_track(seed: int, scene: str, randomization: str) -> Case:
    """The error of what the robot believed as it drove, at each correction, and how well that fits its covariance.

    Truth and belief share the frame that begins at the start pose; nothing else is aligned.
    """
    command = [PROGRAM, scene, str(seed), randomization, str(SECONDS)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    track = np.array([line.split() for line in lines[:-1]], dtype=np.float64)
    driven, motions, reached, cpu, tick, longest = (float(word) for word in lines[-1].split()[1:])
    off = track[:, 5:8] - track[:, 2:5]
    off[:, 2] = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    xx, xy, xt, yy, yt, tt = track[:, 8:].T
    covariance = np.stack([xx, xy, xt, xy, yy, yt, xt, yt, tt], axis=-1).reshape(-1, 3, 3)
    nees = np.einsum("ij,ij->i", off, np.linalg.solve(covariance, off[:, :, None])[:, :, 0])
    distances = np.linalg.norm(off[:, :2], axis=1)
    return {
        "rmse": float(np.sqrt(np.square(distances).mean())),
        "rmse_heading": float(np.sqrt(np.square(off[:, 2]).mean())),
        "worst": float(distances.max()),
        "nees": float(nees.mean()),
        "lost": int(track[:, 1].sum()),
        "driven": driven,
        "motions": motions,
        "reached": reached,
        "cpu": cpu,
        "tick": tick,
        "longest_tick": longest,
    }


def limit(case: Case) -> float:
    """[m] that a drive may be off."""
    most = max(0.10, 0.005 * float(case["driven"])) if case.get("scene") in FEATURELESS else 0.05
    return most * (HARDER if case["randomization"] == "hard" else 1.0)


def share_of_limit(case: Case) -> float:
    """The error of a drive over what is allowed."""
    return float(case["rmse"]) / limit(case)


def is_consistent(case: Case) -> bool:
    """The mean of a drive, whose errors are seen at some ten poses that do not depend on each other."""
    return bool(LEAST <= case["nees"] <= MOST)


def trajectory_rows(consistent: float | None = None) -> list[Row]:
    """The error of all drives together, of the worst, and whether robots know how far off they are: the mean squared
    error in standard deviations that the robot itself states is 3 where it does. `consistent`: the share known to be.
    """
    return [
        mean_of("absolute trajectory error, over what is allowed", share_of_limit, at_most=1.0),
        worst_of("the same of the worst drive", share_of_limit, at_most=2.0),
        mean_of("squared error over covariance, not overconfident", lambda case: case["nees"], at_most=MOST),
        mean_of("squared error over covariance, not timid", lambda case: case["nees"], at_least=LEAST),
        known_miss(
            share_of("drives whose squared error over covariance is consistent", is_consistent, at_least=0.9),
            consistent,
            "errors of a drive go together as if they were 16, not 30: a perfect covariance would make 84 %",
        ),
    ]


def errors(cases: list[Case]) -> str:
    """Of all corrections."""
    errors = np.array([case["rmse"] for case in cases])
    heading = np.array([case["rmse_heading"] for case in cases])
    return (
        f"{1e3 * rms(errors):.1f} mm, {1e3 * rms(heading):.1f} mrad; worst drive {1e3 * errors.max():.1f} mm, "
        f"moment {1e3 * max(case['worst'] for case in cases):.0f} mm"
    )


def errors_row() -> Row:
    return info("root mean square of errors", errors)


def rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.square(values).mean()))
