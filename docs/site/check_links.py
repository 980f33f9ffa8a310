"""Checks the built site as its readers get it: every link leads somewhere, and nothing is fetched from elsewhere."""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

FETCHED = {"script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src", "link": "href"}
NOT_FETCHED = {"canonical", "prev", "next", "edit"}


class Page(HTMLParser):
    """What a page names, what it links to and what it fetches."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.names, self.links, self.fetched = {""}, [], []
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Notes what the tag names or leads to."""
        values = {key: value or "" for key, value in attributes}
        self.names |= {values[key] for key in ("id", "name") if key in values}
        target = values.get(FETCHED.get(tag, ""), "")
        if target and values.get("rel") not in NOT_FETCHED:
            self.fetched.append(target)
        if tag == "a" and "href" in values:
            self.links.append(values["href"])


def main(site: Path) -> int:
    """Prints every link that is wrong; 1 if there is one."""
    pages = {path: Page(path) for path in sorted(site.rglob("*.html"))}
    wrong = [
        f"{path.relative_to(site)}: {problem}"
        for path, page in pages.items()
        if path.name != "404.html"  # its links count from the server's root
        for problem in problems(site, path, page, pages)
    ]
    wrong += [
        f"{sheet.relative_to(site)}: fetches {address}"
        for sheet in sorted(site.rglob("*.css"))
        for address in re.findall(r"url\(\"?'?(https?:[^)\"']+)", sheet.read_text())
    ]
    links = sum(len(page.links) + len(page.fetched) for page in pages.values())
    print(*wrong, f"{len(pages)} pages, {links} links, {len(wrong)} wrong", sep="\n")
    return int(bool(wrong))


def problems(site: Path, path: Path, page: Page, pages: dict[Path, Page]) -> list[str]:
    """What is wrong with the links of one page."""
    found = [f"fetches {target}" for target in page.fetched if re.match(r"(https?:)?//", target)]
    for link in [*page.links, *page.fetched]:
        if re.match(r"[a-z]+:|//", link):
            continue
        name, _, anchor = link.partition("#")
        target = (path.parent / unquote(name.partition("?")[0])).resolve() if name else path
        if target.is_dir():
            target /= "index.html"
        if not target.is_file() or not target.is_relative_to(site):
            found.append(f"{link} leads nowhere")
        elif target in pages and unquote(anchor) not in pages[target].names:
            found.append(f"{link} has no such place on the page")
    return found


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
