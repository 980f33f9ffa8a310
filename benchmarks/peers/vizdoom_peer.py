"""ViZDoom: pictures with depth from its own maze, by its software renderer, one tic of the game for each."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import vizdoom
from world import PICTURES, report

FRAMES = 500


def main() -> None:
    """At the sizes that it has."""
    for width, height in PICTURES:
        resolution = getattr(vizdoom.ScreenResolution, f"RES_{width}X{height}", None)
        if resolution is not None:
            time_pictures(resolution, width, height)


def time_pictures(resolution: vizdoom.ScreenResolution, width: int, height: int) -> None:
    """Its own time and the engine's, which is a process of its own."""
    game = vizdoom.DoomGame()
    game.load_config(str(Path(vizdoom.scenarios_path) / "my_way_home.cfg"))
    game.set_screen_resolution(resolution)
    game.set_screen_format(vizdoom.ScreenFormat.BGR24)
    game.set_depth_buffer_enabled(True)
    game.set_labels_buffer_enabled(False)
    game.set_automap_buffer_enabled(False)
    game.set_render_hud(False)
    game.set_window_visible(False)
    game.set_mode(vizdoom.Mode.PLAYER)
    game.set_seed(1)
    game.init()
    buttons = game.get_available_buttons_size()

    def play() -> None:
        for frame in range(FRAMES):
            if game.is_episode_finished():
                game.new_episode()
            game.make_action([int(i == frame // 20 % buttons) for i in range(buttons)])

    def seconds() -> float:
        ticks = 0
        for children in Path("/proc/self/task").glob("*/children"):
            for child in children.read_text().split():
                _, _, fields = Path(f"/proc/{child}/stat").read_text().rpartition(") ")
                ticks += sum(int(value) for value in fields.split()[11:13])  # as a user and in the kernel
        return time.process_time() + ticks / os.sysconf("SC_CLK_TCK")

    play()
    if seconds() < time.process_time() + 0.1:
        sys.exit("the time of its engine is not to be seen")
    state = game.get_state()
    if state is None or state.screen_buffer.std() < 1.0 or state.depth_buffer.std() < 1.0:
        sys.exit("its picture is empty")
    row = {
        "kind": "picture",
        "who": f"ViZDoom {vizdoom.__version__}",
        "scene": "my_way_home",
        "differs": "its own maze, textured, 8 bits of depth; with a tic of the game",
    }
    report(row, f"{width}x{height}", FRAMES, play, clock=seconds)
    game.close()


if __name__ == "__main__":
    main()
