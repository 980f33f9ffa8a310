"""Ten minutes of driving about by the robot's own SLAM: how far off it was on the way, and whether it knew."""

import subprocess

import numpy as np
from numpy.typing import NDArray

from verify.cases.trees import PROGRAMS
from verify.harness import Case, Row, Verdict

PROGRAM = PROGRAMS / "verify_trajectory"
SECONDS = 600
FEATURELESS = ["corridor_v1", "outdoor_v1"]
"""Where a lidar that sees 12 m cannot tell how far along a bare wall it is."""
HARDER = 1.6
"""So much farther off may robots be that are worse than any should be."""


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


def limit(case: Case, scene: str, randomization: str) -> float:
    """[m] that a drive may be off."""
    most = max(0.10, 0.005 * float(case["driven"])) if scene in FEATURELESS else 0.05
    return most * (HARDER if randomization == "hard" else 1.0)


def absolute_error(scene: str, randomization: str) -> Row:
    """The error of all drives together, as a share of what is allowed; one drive alone may be twice that far off."""

    def judge(cases: list[Case], sample: bool) -> Verdict:
        if any("error" in case for case in cases):
            return Verdict("cases broke", "", "FAIL")
        shares = np.array([case["rmse"] / limit(case, scene, randomization) for case in cases])
        share = float(np.sqrt(np.square(shares).mean()))
        errors = np.array([case["rmse"] for case in cases])
        heading = np.array([case["rmse_heading"] for case in cases])
        figure = (
            f"{1e3 * rms(errors):.1f} mm, {1e3 * rms(heading):.1f} mrad; worst drive {1e3 * errors.max():.1f} mm, "
            f"moment {1e3 * max(case['worst'] for case in cases):.0f} mm; {share:.0%} of the limit"
        )
        most = 2.0 if sample else 1.0
        allowed = most * min(limit(case, scene, randomization) for case in cases)
        return Verdict(figure, f"<= {1e3 * allowed:.0f} mm", "pass" if share <= most else "FAIL")

    return Row("absolute trajectory error", judge)


def honest_covariance() -> Row:
    """The mean squared error, in deviations that the robot itself states: 3 where it knows how far off it is. The band
    holds 95 % of the means over as many drives, each counted as one draw, for its errors hardly change.
    """

    def judge(cases: list[Case], sample: bool) -> Verdict:
        z = 3.290527 if sample else 1.959964  # one drive is to fail once in a thousand times
        low, high = (chi_squared(3 * len(cases), side) / len(cases) for side in (-z, z))
        target = f"in [{low:.2f}, {high:.2f}]"
        if any("error" in case for case in cases):
            return Verdict("cases broke", target, "FAIL")
        mean = float(np.mean([case["nees"] for case in cases]))
        most = max(case["nees"] for case in cases)
        return Verdict(f"mean {mean:.2f}, worst drive {most:.2f}", target, "pass" if low <= mean <= high else "FAIL")

    return Row("squared error over covariance", judge)


def chi_squared(degrees: int, z: float) -> float:
    """A quantile, by that of the normal distribution (Wilson and Hilferty 1931)."""
    spread = 2.0 / (9.0 * degrees)
    return float(degrees * (1.0 - spread + z * np.sqrt(spread)) ** 3)


def rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.square(values).mean()))
