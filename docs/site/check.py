"""Fails if a page of the built site would load something from the network.

    python docs/site/check.py target/site

Links that a reader may click are fine; scripts, styles, pictures and frames from elsewhere are not.
"""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path

AWAY = re.compile(r"\s*(https?:)?//")
#: Elements that load what their attribute names.
LOADS = {"src", "srcset", "data", "poster"}
#: Kinds of <link> that only say where something is.
SAYS = {"canonical", "prev", "next", "edit", "alternate", "license"}
IN_CSS = re.compile(r"""(?:url\(\s*["']?|@import\s+["'])((?:https?:)?//[^"')\s]+)""")


class Page(HTMLParser):
    """Collects what a page loads from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        of = dict(attrs)
        for name, link in attrs:
            loads = name in LOADS or (
                tag == "link" and name == "href" and (of.get("rel") or "") not in SAYS
            )
            if loads and AWAY.match(link or ""):
                self.found.append(f"<{tag} {name}={link}>")
            if name == "style":
                self.found += IN_CSS.findall(link or "")


def main(site: Path) -> int:
    pages = found = 0
    for path in sorted(site.rglob("*")):
        if path.suffix == ".html":
            page = Page()
            page.feed(path.read_text())
            loads = page.found
            pages += 1
        elif path.suffix == ".css":
            loads = IN_CSS.findall(path.read_text())
        else:
            continue
        for load in loads:
            print(f"{path.relative_to(site)}: loads {load}", file=sys.stderr)
        found += len(loads)
    if not pages:
        print(f"{site} holds no page", file=sys.stderr)
        return 1
    print(f"{pages} pages, {found} loads from the network")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
