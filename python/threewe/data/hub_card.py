"""Card and preview picture of a dataset on the Hub."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from threewe._files import read_text
from threewe.data.lerobot.dataset import Dataset
from threewe.data.lerobot.features import Feature
from threewe.errors import ConfigError

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

T = TypeVar("T")

PREVIEW = "preview.jpg"
COLUMNS, ROWS = 4, 3
CELL = (240, 180)  # [px]
MARK = "<!-- written by threewe data push; without this line it stays as it is -->"
LONGEST_TASK = 200  # characters
MOST_TASKS = 50


def card(dataset: Dataset, repo_id: str, license: str | None, *, preview: bool) -> str:
    """The README.md of a dataset: YAML for the Hub, figures, tasks and features."""
    title, frames = repo_id.partition("/")[2], dataset.info.total_frames
    parts = [
        _front_matter(dataset, license),
        f"# {title}",
        "Recorded with 3we, in the format [LeRobot](https://github.com/huggingface/lerobot) v3.0.",
        f"![Frames of the episodes]({PREVIEW})" if preview else "",
        _table(
            ("robot", "episodes", "frames", "frames a second", "duration"),
            [
                (
                    _cell(dataset.info.robot_type or "unknown"),
                    f"{len(dataset):,}",
                    f"{frames:,}",
                    f"{dataset.fps}",
                    _duration(frames / dataset.fps),
                )
            ],
        ),
        "## Tasks",
        _task_list(dataset.tasks),
        "## Features",
        _table(
            ("feature", "type", "shape", "names"),
            [
                (f"`{_code(name)}`", _cell(f.dtype), " x ".join(map(str, f.shape)), _cell(_names(f)))
                for name, f in dataset.features.items()
            ],
        ),
        "## Use it",
        "```python\nfrom lerobot.datasets.lerobot_dataset import LeRobotDataset\n\n"
        f'dataset = LeRobotDataset("{repo_id}")\n```',
        f"```\nthreewe data pull {repo_id} {title}\n```",
        MARK,
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def contact_sheet(dataset: Dataset) -> bytes | None:
    """A JPEG with a frame from the middle of up to twelve episodes; None where there is no image that can be read."""
    from PIL import Image

    frames = list(_frames(dataset))
    if not frames:
        return None
    columns = min(COLUMNS, len(frames))
    rows = -(-len(frames) // columns)
    sheet = Image.new("RGB", (columns * CELL[0], rows * CELL[1]), (24, 26, 31))
    for i, frame in enumerate(frames):
        frame.thumbnail((CELL[0] - 4, CELL[1] - 4))
        left = i % columns * CELL[0] + (CELL[0] - frame.width) // 2
        sheet.paste(frame, (left, i // columns * CELL[1] + (CELL[1] - frame.height) // 2))
    file = io.BytesIO()
    sheet.save(file, "JPEG", quality=85)
    return file.getvalue()


def _frames(dataset: Dataset) -> Iterator[Picture]:
    """Of the first camera, be it video or images in the data."""
    from PIL import Image

    cameras = [name for name, feature in dataset.features.items() if feature.is_camera and not feature.is_depth]
    for episode in _evenly(dataset.episodes) if cameras else ():
        with suppress(ConfigError):  # the card does without what validation will find
            yield Image.fromarray(np.ascontiguousarray(episode.video(cameras[0]).image(episode.length // 2)))


def _evenly(items: Sequence[T]) -> list[T]:
    """At most twelve of them, evenly spread."""
    count = min(len(items), COLUMNS * ROWS)
    return [items[i * len(items) // count] for i in range(count)]


def _front_matter(dataset: Dataset, license: str | None) -> str:
    lines = ["---"]
    if license is not None:
        lines.append(f"license: {license}")
    lines += ["task_categories:", "- robotics", "tags:", "- LeRobot", "- 3we", "configs:", "- config_name: default"]
    return "\n".join(
        [*lines, "  data_files: data/*/*.parquet", f"size_categories:\n- {_category(dataset.info.total_frames)}", "---"]
    )


def _category(frames: int) -> str:
    """As the Hub counts."""
    bounds = [(10**3, "n<1K"), (10**4, "1K<n<10K"), (10**5, "10K<n<100K"), (10**6, "100K<n<1M"), (10**7, "1M<n<10M")]
    return next((name for bound, name in bounds if frames < bound), "10M<n<100M" if frames < 10**8 else "100M<n<1B")


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s" if minutes else f"{rest} s"


def _task_list(tasks: Sequence[str]) -> str:
    if not tasks:
        return "None is named."
    lines = [f"- {_cell(task)}" for task in tasks[:MOST_TASKS]]
    if len(tasks) > MOST_TASKS:
        lines.append(f"- and {len(tasks) - MOST_TASKS} more")
    return "\n".join(lines)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _cell(text: str) -> str:
    """Text of a file as text: no Markdown, no HTML, no line break of it reaches the page."""
    line = " ".join(text.split())
    line = line if len(line) <= LONGEST_TASK else line[:LONGEST_TASK] + "..."
    return re.sub(r"([\\`*_{}\[\]()#+!|~:-])", r"\\\1", html.escape(line, quote=False))


def _names(feature: Feature) -> str:
    return ", ".join(map(str, feature.names)) if isinstance(feature.names, list) else ""


def _code(text: str) -> str:
    return re.sub(r"[`|\r\n]", " ", text)


def write_card(dataset: Dataset, repo_id: str, license: str | None, folder: Path) -> None:
    """Leaves README.md, and a preview picture where there is video, in a folder.

    The dataset's own README.md is taken where it has one that was not written here.
    """
    picture = contact_sheet(dataset)
    if picture is not None:
        (folder / PREVIEW).write_bytes(picture)
    own = dataset.root / "README.md"
    text = read_text(own) if own.is_file() and not own.is_symlink() else MARK
    if MARK in text:
        text = card(dataset, repo_id, license, preview=picture is not None)
    (folder / "README.md").write_text(text, encoding="utf-8")
