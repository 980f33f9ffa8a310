"""Every code block of the README and docs/ runs.

`python` blocks of a page run in order in one namespace, as a reader would paste them into a notebook; the lines of a
`console` block that begin with "$ " run in a shell (but for ./dev, which is running); `cpp` blocks are programs, built
against the library of `./dev build`, and run. A `yaml` or `python` block that begins with a path, as a comment, is a
file that all of them find. Other commands and programs are left out only if the line before the block says why:
<!-- not run: needs a robot -->. A `python` block after <!-- needs: torch --> runs where that package is installed.
"""

import ast
import asyncio
import contextlib
import importlib.util
import inspect
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest
import typer
from threewe.cli import app

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = ROOT / "build/dev/libthreewe.a"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
REMARK = r"(?:<!-- not run: (?P<reason>.+?) -->\n+|<!-- needs: (?P<needs>\w+) -->\n+)?"
FILE = re.compile(r"# [\w./-]+\.(yaml|py)$", re.M)
BY_NIGHT = {
    *(f"docs/how-to-{what}.md" for what in ("benchmark", "export", "scenes", "share", "view")),
    "docs/transfer.md",
}
"""Pages whose commands other tests run as well: by day their options are parsed."""
BLOCK = re.compile(REMARK + r"^```(?P<language>\w*)\n(?P<code>.*?)^```$", re.M | re.S)


def blocks(page: Path, language: str) -> list[tuple[str, str]]:
    """(where, code) of the page's blocks in a language."""
    text = page.read_text()
    return [
        (f"{page.relative_to(ROOT)}:{text.count(chr(10), 0, match.start('code'))}", match["code"])
        for match in BLOCK.finditer(text)
        if match["language"] == language and not match["reason"] and not is_missing(match["needs"])
    ]


def is_missing(package: str | None) -> bool:
    return package is not None and importlib.util.find_spec(package) is None


def pages_with(language: str) -> list[str]:
    return [str(page.relative_to(ROOT)) for page in PAGES if blocks(page, language)]


def write_files(page: str, folder: Path) -> None:
    for _, text in [*blocks(ROOT / page, "yaml"), *blocks(ROOT / page, "python")]:
        if FILE.match(text):
            path = folder / text.splitlines()[0].removeprefix("# ")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)


@pytest.mark.parametrize("page", pages_with("python"))
def test_python(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_files(page, tmp_path)

    async def paste() -> None:
        namespace = {"__name__": "__main__"}
        for where, code in blocks(ROOT / page, "python"):
            compiled = compile(code, where, "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
            result = eval(compiled, namespace)
            if inspect.isawaitable(result):
                await result

    asyncio.run(paste())
    needed = {match["needs"] for match in BLOCK.finditer((ROOT / page).read_text())}
    if missing := sorted(filter(is_missing, needed - {None})):
        pytest.skip(f"not shown: what needs {', '.join(missing)}; the rest of {page} ran")


def commands_of(code: str) -> list[str]:
    """Those of a `console` block, without ./dev, which is running."""
    commands = [line.removeprefix("$ ") for line in code.splitlines() if line.startswith("$ ")]
    return [command for command in commands if not command.startswith("./dev")]


def by_night(page: str) -> object:
    return pytest.param(page, marks=pytest.mark.nightly) if page in BY_NIGHT else page


@pytest.mark.parametrize("page", [by_night(page) for page in pages_with("console")])
def test_console(page: str, tmp_path: Path) -> None:
    write_files(page, tmp_path)
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    for where, code in blocks(ROOT / page, "console"):
        script = "\n".join(commands_of(code))
        done = subprocess.run(["bash", "-euc", script], cwd=tmp_path, env={**os.environ, "PATH": path})
        assert done.returncode == 0, where


@pytest.mark.parametrize("page", sorted(BY_NIGHT))
def test_commands_that_run_by_night_have_their_options(page: str) -> None:
    found = [command for _, code in blocks(ROOT / page, "console") for command in commands_of(code)]
    found = [command for command in found if command.startswith("threewe ")]
    assert found, page
    for command in found:
        _, *words = shlex.split(command)
        group = typer.main.get_command(app)
        with contextlib.suppress(typer.Exit):  # of --help
            while isinstance(group, click.Group):
                _, chosen, words = group.resolve_command(group.make_context("threewe", words[:1]), words)
                assert chosen is not None, command
                group = chosen
            group.make_context("threewe", words)


@pytest.mark.parametrize("page", pages_with("cpp"))
def test_cpp(page: str, tmp_path: Path) -> None:
    for number, (where, code) in enumerate(blocks(ROOT / page, "cpp")):
        source = tmp_path / f"snippet_{number}.cpp"
        source.write_text(f'#line 1 "{where}"\n{code}')
        program = tmp_path / f"snippet_{number}"
        flags = [
            "-std=c++20",
            "-Wall",
            "-Wextra",
            "-Werror",
            f"-I{ROOT / 'include'}",
            "-isystem",
            "/usr/include/eigen3",
        ]
        libraries = [LIBRARY, *(f"-l{name}" for name in ("yaml-cpp", "fmt", "hwy", "pugixml"))]
        assert subprocess.run(["c++", *flags, source, "-o", program, *libraries]).returncode == 0, where
        assert subprocess.run([program], cwd=tmp_path).returncode == 0, where


def test_every_block_is_of_a_kind_that_runs() -> None:
    wrong = [where for page in PAGES for kind in ("bash", "sh", "shell", "c", "py") for where, _ in blocks(page, kind)]
    assert not wrong, "write ```console with $ before each command, ```cpp or ```python"


def test_every_dev_command_shown_exists() -> None:
    commands = subprocess.run([ROOT / "dev", "help"], capture_output=True, text=True).stdout
    for page in PAGES:
        for command in re.findall(r"\./dev (\w+)", page.read_text()):
            assert f"./dev {command}" in commands or command == "help", f"{page}: ./dev {command}"
