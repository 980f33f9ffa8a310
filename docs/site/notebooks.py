"""The examples as executed notebooks: a page with what each cell prints, and the notebook to download.

A notebook has an event loop that runs already, so `asyncio.run(main())` becomes `await main()`; nothing else changes.
Examples that train for minutes are shown and not executed, nor is one whose pictures are in docs/.
"""

import ast
import os
import re
import tempfile
from pathlib import Path

import jupytext
import nbformat
from nbclient import NotebookClient
from nbconvert import MarkdownExporter
from nbconvert.preprocessors import CoalesceStreamsPreprocessor
from traitlets.config import Config

ROOT = Path(__file__).resolve().parents[2]
NOT_EXECUTED = {
    "09_ppo": "It trains for minutes, so this page does not show what it prints.",
    "10_sb3": "It trains for minutes, so this page does not show what it prints.",
    "12_end_to_end": "It trains for minutes, so this page does not show what it prints.",
    "11_autonomy": "Its pictures are explained in [how the autonomy stack works](../autonomy.md).",
}
FOLDER = ROOT / "build" / "notebooks"
SECONDS = 300


def pages() -> dict[str, str]:
    """The pages by their names, and the notebooks beside them in build/notebooks."""
    return {f"examples/{path.stem}.md": page(path) for path in sorted((ROOT / "examples").glob("*.py"))}


def page(example: Path) -> str:
    """One example: its notebook's cells and their outputs, then the same program in C++ where there is one."""
    notebook = as_notebook(example)
    note = NOT_EXECUTED.get(example.stem)
    FOLDER.mkdir(parents=True, exist_ok=True)
    if note is None:
        execute(notebook)
    nbformat.write(notebook, FOLDER / f"{example.stem}.ipynb")
    exporter = MarkdownExporter(preprocessors=[CoalesceStreamsPreprocessor])  # else each print is a block of its own
    text, _ = exporter.from_notebook_node(notebook)
    parts = [without_styles(text), f"[This page as a notebook]({example.stem}.ipynb)"]
    if note:
        parts.append(note)
    twin = example.with_suffix(".cpp")
    if twin.exists():
        parts.append(f"## The same in C++\n\n```cpp\n{twin.read_text()}```")
    return "\n\n".join(parts) + "\n"


def execute(notebook: nbformat.NotebookNode) -> None:
    """Runs all cells, in build/notebooks, and keeps what they print; over sockets in a folder, so without a network."""
    with tempfile.TemporaryDirectory() as sockets:
        config = Config({"KernelManager": {"transport": "ipc", "ip": f"{sockets}/kernel"}})
        client = NotebookClient(notebook, timeout=SECONDS, resources={"metadata": {"path": FOLDER}}, config=config)
        client.execute(env={**os.environ, "PYTHONWARNINGS": "ignore:install"})  # ipywidgets, for progress bars


def as_notebook(example: Path) -> nbformat.NotebookNode:
    """The example in cells: its docstring as text, then its code."""
    source = example.read_text()
    tree = ast.parse(source)
    code = "".join(source.splitlines(keepends=True)[tree.body[1].lineno - 1 :])
    code = re.sub(r"^(\s*)asyncio\.run\((.*)\)$", r"\1await \2", code, flags=re.M)
    notebook = jupytext.reads(code, fmt="py:light")
    arguments = nbformat.v4.new_code_cell(f'import sys\n\nsys.argv = ["{example.name}"]  # as from a command line')
    notebook.cells = [nbformat.v4.new_markdown_cell(f"# {example.name}\n\n{ast.get_docstring(tree)}"), *notebook.cells]
    if "sys.argv" in code or "argparse" in code:
        notebook.cells.insert(1, arguments)
    return notebook


def without_styles(text: str) -> str:
    """Output without what terminals colour it by."""
    return re.sub(r"\x1b\[[0-9;]*m", "", text)
