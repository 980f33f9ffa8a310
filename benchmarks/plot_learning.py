"""Learning curves of runs of examples/09_ppo.py: plot_learning.py PICTURE RUN.json ... ; needs matplotlib."""

import json
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

WINDOW = 5  # updates that a point of a curve is the mean of


def main(picture: str, *runs: str) -> None:
    """Left the episodes of training, in generated scenes; right the frozen episodes, in those with names."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for place, name in enumerate(runs):
        run = json.loads(Path(name).read_text())
        points = run["curve"]  # shares say little: episodes that fail end last
        won = [point["episodes"] * (point["success"] or 0.0) / points[0]["steps"] * 1000 for point in points]
        smooth = np.convolve(won, np.ones(WINDOW) / WINDOW, "valid")
        label = f"seed {run['settings']['seed']}, {points[-1]['cpu_s']:.0f} CPU s"
        left.plot([point["steps"] / 1000 for point in points[WINDOW - 1 :]], smooth, label=label)
        scenes = run["success"]["full"]
        right.bar(np.arange(len(scenes)) + 0.27 * (place - 1), scenes.values(), 0.25)
        right.set_xticks(range(len(scenes)), scenes, rotation=30, ha="right")
    left.set(xlabel="thousand steps", ylabel="episodes won in 1,000 steps", title="Training: generated scenes")
    right.set(title='Test: reactive_v1, gate="full"')
    left.set_ylim(bottom=0.0)
    right.set_ylim(0.0, 1.0)
    for axes in (left, right):
        axes.grid(alpha=0.3)
    left.legend()
    figure.savefig(picture, dpi=100)


if __name__ == "__main__":
    main(*sys.argv[1:])
