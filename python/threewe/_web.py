"""Files of pages: styles and scripts of the folder web."""

from __future__ import annotations

from pathlib import Path

from threewe.errors import ConfigError


def web_file(name: str) -> str:
    """A file of a page: of the package, or of the source tree."""
    here = Path(__file__).resolve()
    for folder in (here.parent / "web", here.parents[2] / "web"):
        if (folder / name).exists():
            return (folder / name).read_text(encoding="utf-8")
    raise ConfigError(f"web/{name} is missing from this installation of threewe")
