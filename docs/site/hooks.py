"""What MkDocs does not do by itself: pages made of files outside docs/, executed examples, and links between them.

README.md, CONTRIBUTING.md and the like are pages where they are, so that GitHub shows them; here they become pages of
the site. A link that is right in the repository is right on the site, too; one to a file that is no page becomes its
name.
"""

import posixpath
import re
import sys
from collections.abc import Callable
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

sys.path.insert(0, str(Path(__file__).parent))
import command_line
import cpp_reference
import notebooks

ROOT = Path(__file__).resolve().parents[2]
PAGES = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "benchmarks/README.md": "benchmarks.md",
    "verify/README.md": "verify.md",
}
"""Files of the repository that are pages of the site."""
LINK = re.compile(r"(?P<before>!?\[(?P<text>[^\]]*)\])\((?P<target>[^)\s]+)\)")
FENCED = re.compile(r"^```.*?^```$", re.M | re.S)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Lists every decision and every C++ module in the navigation."""
    for section in config.nav or []:
        if decisions := section.get("Decisions"):
            decisions += [f"decisions/{path.name}" for path in sorted((ROOT / "docs/decisions").glob("0*.md"))]
        if reference := section.get("Reference"):
            reference.append({"C++": [{module: f"reference/cpp/{module}.md"} for module in cpp_reference.modules()]})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages that are not in docs/."""
    for source, page in PAGES.items():
        files.append(File.generated(config, page, content=(ROOT / source).read_text()))
    files.append(File.generated(config, "reference/cli.md", content=command_line.page()))
    for name, content in [*cpp_reference.pages().items(), *notebooks.pages().items()]:
        files.append(File.generated(config, name, content=content))
    for notebook in sorted(notebooks.FOLDER.glob("*.ipynb")):
        files.append(File.generated(config, f"examples/{notebook.name}", abs_src_path=str(notebook)))
    return files


def on_page_markdown(markdown: str, page: Page, files: Files, **_: object) -> str:
    """Lets links lead to the site's pages instead of the repository's files."""
    here = page.file.src_uri
    source = next((source for source, name in PAGES.items() if name == here), f"docs/{here}")

    def lead(match: re.Match[str]) -> str:
        target, _, anchor = match["target"].partition("#")
        if not target or ":" in target or here.startswith(("reference/cpp/", "examples/")):
            return match[0]
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        to = page_of(path)
        if files.get_file_from_path(to) is None:
            return f"`{path}`" if (ROOT / path).exists() else match[0]
        relative = posixpath.relpath(to, posixpath.dirname(here) or ".")
        return f"{match['before']}({relative}{'#' + anchor if anchor else ''})"

    return outside_of_fences(markdown, lambda text: LINK.sub(lead, text))


def page_of(path: str) -> str:
    """The page of the site that a file of the repository is."""
    if path in PAGES:
        return PAGES[path]
    if path.startswith("examples/"):
        return path.removesuffix(".py") + ".md"
    return path.removeprefix("docs/")


def outside_of_fences(markdown: str, change: Callable[[str], str]) -> str:
    """Changes everything but code blocks."""
    parts, end = [], 0
    for fence in FENCED.finditer(markdown):
        parts += [change(markdown[end : fence.start()]), fence[0]]
        end = fence.end()
    return "".join([*parts, change(markdown[end:])])
