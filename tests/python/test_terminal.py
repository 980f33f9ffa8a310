"""What `threewe drive` and `threewe explore` show in a terminal."""

from __future__ import annotations

import io
import math
import re
from pathlib import Path

import numpy as np
import pytest
import threewe
from rich.console import Console
from threewe import OccupancyGrid, Pose2D, Robot, cli, driving
from threewe.terminal import (
    ARROWS,
    FREE,
    GOAL,
    GROUND,
    NOTHING,
    OCCUPIED,
    PATH,
    TRAJECTORY,
    WALL,
    Canvas,
    Dashboard,
    picture,
)
from typer.testing import CliRunner

NOWHERE = np.empty((0, 2))


def slowly(grid: OccupancyGrid, canvas: Canvas) -> np.ndarray:
    """The map alone, cell by cell."""
    pixels = np.zeros_like(canvas.pixels)
    for row in range(grid.height):
        for column in range(grid.width):
            value = int(grid.data[row, column])
            what = WALL if value >= OCCUPIED else GROUND if 0 <= value <= FREE else NOTHING
            x = grid.origin[0] + (column + 0.5) * grid.resolution
            y = grid.origin[1] + (row + 0.5) * grid.resolution
            at = math.floor((canvas.top - y) / canvas.pixel), math.floor((x - canvas.left) / canvas.pixel)
            pixels[at] = max(pixels[at], what)
    return pixels


@pytest.mark.parametrize("seed", range(20))
def test_a_map_of_any_size_fits_and_is_drawn_cell_by_cell(seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = rng.choice([-1, 0, 20, 50, 80, 100], rng.integers(1, 120, 2)).astype(np.int8)
    grid = OccupancyGrid(data, float(rng.choice([0.05, 0.1])), tuple(rng.uniform(-5.0, 5.0, 2)))
    columns, lines = int(rng.integers(10, 120)), int(rng.integers(4, 50))
    middle = np.array(grid.origin) + 0.5 * grid.resolution
    canvas = picture(grid, middle[None], NOWHERE, NOWHERE, columns, lines)
    assert canvas.pixels.shape[0] <= 2 * lines
    assert canvas.pixels.shape[1] <= columns
    shown = np.where(canvas.pixels == TRAJECTORY, GROUND, canvas.pixels)
    np.testing.assert_array_equal(shown, slowly(grid, canvas), f"seed {seed}")


def test_what_matters_most_is_on_top() -> None:
    canvas = Canvas.around(np.array([0.0, 0.0]), np.array([10.0, 4.0]), columns=10, lines=2)
    canvas.line(np.array([[0.5, 0.5], [9.5, 0.5]]), PATH)
    canvas.line(np.array([[0.5, 0.5], [9.5, 0.5]]), TRAJECTORY)
    canvas.mark(np.array([[9.5, 0.5], [99.0, 99.0]]), GOAL)
    assert canvas.pixels[3].tolist() == [PATH] * 9 + [GOAL]
    assert not canvas.pixels[:3].any()


@pytest.mark.parametrize(
    ("theta", "arrow"), [(0.0, "→"), (math.pi / 2, "↑"), (-math.pi / 2, "↓"), (math.pi, "←"), (-2.4, "↙")]
)
def test_the_robot_is_an_arrow_where_it_is(theta: float, arrow: str) -> None:
    canvas = Canvas.around(np.array([0.0, 0.0]), np.array([10.0, 4.0]), columns=10, lines=2)
    rows = ["".join(segment.text for segment in row) for row in canvas.rows(Pose2D(2.5, 3.5, theta))]
    assert rows == [f"  {arrow}       ", " " * 10]


async def test_a_drive_in_a_terminal_and_where_nobody_looks() -> None:
    async def drive(console: Console) -> Pose2D:
        async with Robot(seed=5) as robot:
            with Dashboard(robot, console, "driving", (2.0, 1.0)) as look:
                result = await robot.move_to(2.0, 1.0, on_progress=look)
        return result.pose

    shown, silent = io.StringIO(), io.StringIO()
    seen = await drive(Console(file=shown, force_terminal=True, width=80, height=24))
    unseen = await drive(Console(file=silent, force_terminal=False))
    assert seen == unseen
    assert silent.getvalue() == ""
    last = shown.getvalue().split("driving")[-1]
    assert "m driven" in last
    assert any(arrow in shown.getvalue() for arrow in ARROWS)


STRANGE = "[m] :100: [/bold] [red]x"


def test_the_terminal_prints_text_as_it_is(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = tmp_path / "[m]:100:[red]"
    folder.mkdir()
    with pytest.raises(SystemExit):
        cli.fail(STRANGE)
    assert STRANGE in capsys.readouterr().err
    cli.generate_scene(3, output=folder / "a.yaml")
    driving.tell_of_map(folder / "b.yaml")
    shown = capsys.readouterr().out.replace("\n", "")
    assert f"{folder}/a.yaml" in shown
    assert f"{folder}/b.yaml" in shown


def test_help_texts_keep_their_units() -> None:
    shown = CliRunner().invoke(cli.app, ["slam", "replay", "--help"]).output
    assert shown.count("[m]") == 2


def test_nobody_prints_with_markup() -> None:
    package = Path(threewe.__file__).parent
    for file in package.rglob("*.py"):
        text = file.read_text()
        if file.name != "_console.py":
            assert "rich.markup" not in text, file
            assert not re.search(r"\b(?:Console|TextColumn)\(", text), file
