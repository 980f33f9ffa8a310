"""Draws the `reactive` set, assets/episodes/reactive_v1.json: python benchmarks/make_episodes.py.

What is frozen never changes: a set with other episodes is another version. In each scene they are the first ones of
`SceneTables.sample_episode` that satisfy the bounds, so that anyone can draw them again.
"""

import json
from itertools import count
from pathlib import Path

from threewe import RobotProfile, Scene, SceneTables

FILE = Path(__file__).resolve().parent.parent / "assets/episodes/reactive_v1.json"
SCENES = ["office_v2", "apartment_v1", "corridor_v1", "warehouse_v1", "cluttered_v1", "outdoor_v1", "dynamic_v1"]
EPISODES = 100  # in each
DEFINITION = {
    "name": "reactive_v1",
    "hardware": "3we_standard_v2",
    "seed": 20_261_121,
    "shortest": 2.0,
    "longest": 8.0,
    "straightness": 1.3,
}


def draw(scene: str) -> list[list]:
    """The episodes of one scene, as index, seed, start, goal, geodesic."""
    tables = SceneTables(Scene.load(scene), RobotProfile.load(DEFINITION["hardware"]))
    listed = []
    for index in count():
        if len(listed) == EPISODES:
            break
        episode = tables.sample_episode(DEFINITION["seed"], index)
        (x, y, theta), goal = episode.start, episode.goal
        straight = ((goal[0] - x) ** 2 + (goal[1] - y) ** 2) ** 0.5
        if not DEFINITION["shortest"] <= episode.geodesic <= DEFINITION["longest"]:
            continue
        if episode.geodesic > DEFINITION["straightness"] * straight:
            continue
        listed.append([index, episode.seed, [x, y, theta], [goal[0], goal[1]], episode.geodesic])
    return listed


def main() -> None:
    """Writes the file, one line for each episode."""
    parts = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in DEFINITION.items()]
    scenes = []
    for scene in SCENES:
        lines = ",\n".join(f"      {json.dumps(line)}" for line in draw(scene))
        scenes.append(f"    {json.dumps(scene)}: [\n{lines}\n    ]")
    parts.append('  "episodes": {\n' + ",\n".join(scenes) + "\n  }")
    FILE.write_text("{\n" + ",\n".join(parts) + "\n}\n")


if __name__ == "__main__":
    main()
