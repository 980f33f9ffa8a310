"""A film of a run: the true scene from above, the map that the robot draws of it, and what its camera sees."""

from __future__ import annotations

import io
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from threewe import OccupancyGrid, Pose2D, Robot, TickView, _sight
from threewe import drawing as d

VIDEO_FRAMES = 600
GIF_FRAMES = 150
FRAMES_PER_SECOND = 25
GIF_SIZE = 6 * 1024 * 1024  # [bytes]


@dataclass
class FilmState:
    """What one frame shows."""

    time: float
    true_pose: Pose2D
    pose: Pose2D
    hits: NDArray[np.float64]  # (K, 2), relative to the sensor, turned into the map's axes
    plan: NDArray[np.float64]  # (N, 2), map frame
    grid: bytes  # the map's cells, compressed
    shape: tuple[int, int]
    origin: tuple[float, float]
    status: str
    coverage: float
    sight: bytes  # what the camera sees, compressed; empty without one


class Film:
    """Watches a simulated robot through an observer and draws what it saw afterwards."""

    def __init__(self, robot: Robot, period: float = 0.5) -> None:
        if robot.simulation is None:
            raise ValueError("a film shows the true scene, which only simulated robots have")
        self.status = ""
        self.coverage = 0.0
        self.states: list[FilmState] = []
        self._robot = robot
        self._truth = robot.simulation
        self._period = period
        self._next = 0.0
        self._most_things = 0
        self._still: Image.Image | None = None
        self._observer = robot.observe(self._look)

    def close(self) -> None:
        """Stops filming."""
        self._robot.unobserve(self._observer)

    def _look(self, tick: TickView) -> None:
        if tick.now + 1e-9 < self._next:
            return
        self._next = tick.now + self._period
        grid = self._robot.get_map()
        pose = self._robot.get_pose()
        self.states.append(
            FilmState(
                time=tick.now,
                true_pose=self._truth.true_pose(),
                pose=pose,
                hits=self._hits(pose),
                plan=np.asarray(self._robot.get_path(), np.float64).reshape(-1, 2),
                grid=zlib.compress(np.asarray(grid.data).tobytes(), 1),
                shape=(grid.height, grid.width),
                origin=grid.origin,
                status=self.status,
                coverage=self.coverage,
                sight=self._look_ahead(),
            )
        )

    def _look_ahead(self) -> bytes:
        """What the camera sees, small; the view with the most things in it is kept as it is."""
        camera = self._robot.profile.camera
        if camera is None:
            return b""
        sight = self._truth.look(_sight.scaled(camera.intrinsics, _Studio.SIGHT_WIDTH))
        things = _sight.things_in_sight(sight)
        if things > self._most_things:
            self._most_things = things
            self._still = _sight.strip(self._truth.look(), self._truth.scene)
        return _sight.as_jpeg(_sight.strip(sight, self._truth.scene))

    def _hits(self, pose: Pose2D) -> NDArray[np.float64]:
        scan = self._robot.get_lidar_scan()
        ranges = np.asarray(scan.ranges, np.float64)
        mount = self._robot.get_transform("base", "lidar")
        angles = pose.theta + mount.theta + scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        seen = ranges > 0.0
        return np.stack([ranges[seen] * np.cos(angles[seen]), ranges[seen] * np.sin(angles[seen])], axis=1)

    def save(self, folder: Path, on_progress: Callable[[float], None] = lambda _: None) -> None:
        """Writes `run.mp4`, `run.gif`, `map.png` and, with a camera, `camera.png` into a folder.

        `on_progress` gets the share done, 0 to 1.
        """
        if not self.states:
            raise ValueError("nothing was filmed: the robot has not moved in time")
        studio = _Studio(self._robot, self.states)
        chosen = _spread(len(self.states), VIDEO_FRAMES)
        for_gif = {chosen[i] for i in _spread(len(chosen), GIF_FRAMES)}
        stills: list[Image.Image] = []
        with _Video(folder / "run.mp4", studio.size) as video:
            for done, index in enumerate(chosen):
                frame = studio.frame(index)
                video.add(frame)
                if index in for_gif:
                    stills.append(frame)
                on_progress((done + 1) / len(chosen))
        _save_gif(stills, folder / "run.gif")
        studio.map_picture().save(folder / "map.png")
        if self._still is not None:
            self._still.save(folder / "camera.png")


class _Studio:
    """Draws single frames."""

    PANEL_WIDTH = 640
    HEADER = 44
    GAP = 12
    SIGHT_WIDTH = (2 * PANEL_WIDTH + GAP - 2 * _sight.GAP) // 3

    def __init__(self, robot: Robot, states: list[FilmState]) -> None:
        assert robot.simulation is not None
        self.profile = robot.profile
        self.states = states
        self.scene = robot.simulation.scene
        self.view = d.View.of(self.scene, self.PANEL_WIDTH)
        self.stage = d.draw_scene(self.scene, self.view)
        panel = self.stage.width // d.SUPERSAMPLING, self.stage.height // d.SUPERSAMPLING
        width, height = 2 * panel[0] + 3 * self.GAP, panel[1] + self.HEADER + self.GAP
        self.sight_top = height + self.HEADER - self.GAP
        if states[0].sight:
            height = self.sight_top + Image.open(io.BytesIO(states[0].sight)).height + self.GAP
        self.size = width + width % 2, height + height % 2
        self.true_trajectory = np.array([(m.true_pose.x, m.true_pose.y) for m in states])
        self.own_trajectory = np.array([(m.pose.x, m.pose.y) for m in states])

    def frame(self, index: int) -> Image.Image:
        state = self.states[index]
        left = d.finish(self._truth(state, index))
        right = d.finish(self._own(state, index))
        frame = Image.new("RGB", self.size, d.PAPER[:3])
        frame.paste(left, (self.GAP, self.HEADER))
        frame.paste(right, (left.width + 2 * self.GAP, self.HEADER))
        self._header(frame, state, left.width + 2 * self.GAP)
        if state.sight:
            frame.paste(Image.open(io.BytesIO(state.sight)), (self.GAP, self.sight_top))
            self._sight_header(frame)
        return frame

    def map_picture(self) -> Image.Image:
        """The final map, larger, with the way the robot took."""
        view = d.View.of(self.scene, 2 * self.PANEL_WIDTH)
        picture = d.draw_map(_grid(self.states[-1]), view)
        d.draw_path(picture, view, self.own_trajectory, d.TRAJECTORY, 0.04)
        d.draw_robot(picture, view, self.states[-1].pose, self.profile)
        return d.finish(picture)

    def _truth(self, state: FilmState, index: int) -> Image.Image:
        picture = self.stage.copy()
        pose = state.true_pose
        turn = pose.theta - state.pose.theta
        c, s = np.cos(turn), np.sin(turn)
        origin = (pose.x, pose.y)
        d.draw_rays(picture, self.view, origin, state.hits @ np.array([[c, s], [-s, c]]) + np.array(origin))
        d.draw_path(picture, self.view, self.true_trajectory[: index + 1], d.TRAJECTORY, 0.05)
        d.draw_path(picture, self.view, state.plan, d.PLAN, 0.07, dashed=True)
        d.draw_robot(picture, self.view, pose, self.profile)
        return picture

    def _own(self, state: FilmState, index: int) -> Image.Image:
        picture = d.draw_map(_grid(state), self.view)
        d.draw_path(picture, self.view, self.own_trajectory[: index + 1], d.TRAJECTORY, 0.05)
        d.draw_path(picture, self.view, state.plan, d.PLAN, 0.07, dashed=True)
        d.draw_robot(picture, self.view, state.pose, self.profile)
        return picture

    def _header(self, frame: Image.Image, state: FilmState, second: int) -> None:
        draw = ImageDraw.Draw(frame)
        middle = self.HEADER / 2
        title, small = d.text_font(19), d.text_font(16)
        draw.text((self.GAP, middle), "the world", d.INK, title, anchor="lm")
        draw.text((second, middle), "what the robot knows", d.INK, title, anchor="lm")
        draw.text((second - 2 * self.GAP, middle), state.status, (96, 104, 120), small, anchor="rm")
        figures = f"{state.time:5.0f} s    {100 * state.coverage:3.0f} % seen"
        draw.text((frame.width - self.GAP, middle), figures, (96, 104, 120), small, anchor="rm")

    def _sight_header(self, frame: Image.Image) -> None:
        draw = ImageDraw.Draw(frame)
        for i, title in enumerate(("its camera", "depth", "what each pixel shows")):
            left = self.GAP + i * (self.SIGHT_WIDTH + _sight.GAP)
            draw.text((left, self.sight_top - self.HEADER / 2), title, d.INK, d.text_font(19), anchor="lm")


class _Video:
    """An H.264 file that every player shows."""

    def __init__(self, path: Path, size: tuple[int, int]) -> None:
        import av

        self._container = av.open(str(path), "w")
        self._stream = self._container.add_stream("libx264", rate=Fraction(FRAMES_PER_SECOND))
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        self._stream.options = {"crf": "23", "preset": "veryfast"}
        self._stream.thread_count = 1
        self._frame_type = av.VideoFrame

    def __enter__(self) -> _Video:
        return self

    def __exit__(self, *error: object) -> None:
        for packet in self._stream.encode():
            self._container.mux(packet)
        self._container.close()

    def add(self, frame: Image.Image) -> None:
        for packet in self._stream.encode(self._frame_type.from_ndarray(np.asarray(frame), format="rgb24")):
            self._container.mux(packet)


def _save_gif(frames: list[Image.Image], path: Path) -> None:
    """One palette for all frames, so that unchanged pixels cost nothing; smaller when it would be too large."""
    for width in (960, 800, 640, 480):
        small = [f.resize((width, round(f.height * width / f.width)), Image.Resampling.BILINEAR) for f in frames]
        palette = _collage(small).quantize(240, Image.Quantize.MEDIANCUT)
        indexed = [f.quantize(palette=palette, dither=Image.Dither.NONE) for f in small]
        indexed[0].save(path, save_all=True, append_images=indexed[1:], duration=100, loop=0, optimize=True)
        if path.stat().st_size <= GIF_SIZE:
            return


def _collage(frames: list[Image.Image]) -> Image.Image:
    """A few frames below each other: what a palette for all of them is made of."""
    chosen = [frames[i] for i in _spread(len(frames), 4)]
    picture = Image.new("RGB", (chosen[0].width, len(chosen) * chosen[0].height))
    for row, frame in enumerate(chosen):
        picture.paste(frame, (0, row * frame.height))
    return picture


def _spread(count: int, most: int) -> list[int]:
    """At most `most` of `count` indices, evenly, the last one always."""
    if count <= most:
        return list(range(count))
    return [round(i * (count - 1) / (most - 1)) for i in range(most)]


def _grid(state: FilmState) -> OccupancyGrid:
    cells = np.frombuffer(zlib.decompress(state.grid), np.int8).reshape(state.shape)
    return OccupancyGrid(cells, 0.05, state.origin)
