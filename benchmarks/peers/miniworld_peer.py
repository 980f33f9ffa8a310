"""MiniWorld: pictures with depth from its own four rooms, by OpenGL without a window, one step of the game for each."""

from __future__ import annotations

import os
import sys
from importlib.metadata import version

os.environ.setdefault("PYGLET_HEADLESS", "1")
import gymnasium
import miniworld  # noqa: F401 (registers its environments)
from world import PICTURES, report

FRAMES = 100


def main() -> None:
    """At all sizes."""
    for width, height in PICTURES:
        env = gymnasium.make("MiniWorld-FourRooms-v0", obs_width=width, obs_height=height, max_episode_steps=10**9)
        colour, _ = env.reset(seed=0)
        if colour.std() < 1.0:
            sys.exit("its picture is empty")
        scene = env.unwrapped

        def play(env: gymnasium.Env = env, scene: gymnasium.Env = scene) -> None:
            for frame in range(FRAMES):
                _, _, terminated, truncated, _ = env.step(2 if frame % 5 else 0)
                scene.render_depth(scene.obs_fb)
                if terminated or truncated:
                    env.reset()

        row = {
            "kind": "picture",
            "who": f"MiniWorld {version('miniworld')}, OpenGL",
            "scene": "FourRooms",
            "differs": "its own four rooms, textured, two passes; with a step of the game",
        }
        report(row, f"{width}x{height}", FRAMES, play)
        env.close()


if __name__ == "__main__":
    main()
