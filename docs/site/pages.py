"""Which files of the project become pages of the site, and where links between them lead.

Nothing here needs more than the standard library: ``tests/python/test_docs.py`` checks the links
without building the site.
"""

from __future__ import annotations

import json
import posixpath
import re
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

#: Pages at the root of the project, and where they are in the site.
TOP = {
    "ARCHITECTURE.md": "architecture.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
#: What a link to a folder means.
FOLDERS = {
    "": "index.md",
    "docs": "index.md",
    "docs/notebooks": "guide/python.md",
    "scenarios": "guide/scenario.md",
    "validation": "validation/README.md",
}
#: Modules of the Python package with a page of their own.
PYTHON = [
    "simulation",
    "scenario",
    "shapes",
    "materials",
    "boundaries",
    "loads",
    "regions",
    "fields",
    "probes",
    "results",
    "sampling",
    "sweeps",
    "plot",
    "errors",
]
#: Pages made from the schema, from docstrings and from the last run of `rsph validate`.
GENERATED = [
    "reference/keys.md",
    "reference/rust.md",
    "validation/last-run.md",
    *(f"reference/python/{module}.md" for module in PYTHON),
]

FENCE = re.compile(r"^(```+|~~~+).*?^\1\s*$", re.DOTALL | re.MULTILINE)
CODE = re.compile(r"(`+)[^`](?:.*?[^`])??\1(?!`)", re.DOTALL)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
OUTSIDE = re.compile(r"[a-z]+:|#")


def pages() -> dict[str, str]:
    """Path in the project of every page -> its path in the site."""
    found = dict(TOP)
    for path in sorted((ROOT / "docs").rglob("*.md")):
        if "site" not in path.relative_to(ROOT / "docs").parts[:1]:
            found[path.relative_to(ROOT).as_posix()] = path.relative_to(ROOT / "docs").as_posix()
    for path in sorted((ROOT / "validation").rglob("README.md")):
        found[path.relative_to(ROOT).as_posix()] = path.relative_to(ROOT).as_posix()
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        found[path.relative_to(ROOT).as_posix()] = f"notebooks/{path.stem}.md"
    for path in sorted((ROOT / "scenarios").glob("*.toml")):
        found[path.relative_to(ROOT).as_posix()] = f"scenarios/{path.stem}.md"
    return found


def pictures() -> dict[str, str]:
    """Path in the project of every picture, and of the style sheet -> its path in the site."""
    found = {"docs/site/style.css": "style.css"}
    for folder in ("docs", "validation", "benches"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".png", ".svg"):
                name = path.relative_to(ROOT).as_posix()
                found[name] = name.removeprefix("docs/")
    return found


def text(source: str) -> str:
    """A file of the project as Markdown; scenarios and notebooks are turned into it."""
    path = ROOT / source
    if path.suffix == ".toml":
        name, scenario = path.stem, path.read_text()
        # Those of a mesh that is not in the repository are no templates.
        printed = "" if "/shared/" in scenario else f"; `rsph new {name}` prints it"
        return (
            f"# {name}\n\n`{source}`{printed}. "
            "[Every key](../docs/guide/scenario.md).\n\n"
            f"```toml\n{scenario.rstrip()}\n```\n"
        )
    if path.suffix == ".ipynb":
        parts = []
        for cell in json.loads(path.read_text())["cells"]:
            body = "".join(cell["source"])
            parts.append(body if cell["cell_type"] == "markdown" else f"```python\n{body}\n```")
        return "\n\n".join(parts) + f"\n\n*This page is the notebook `{source}`, not executed.*\n"
    return path.read_text()


def outside_code(markdown: str, change: Callable[[str], str]) -> str:
    """Changes what is neither in a fenced block nor between backticks."""

    def between(whole: str, code: re.Pattern[str], inner: Callable[[str], str]) -> str:
        done, end = [], 0
        for match in code.finditer(whole):
            done += [inner(whole[end : match.start()]), match.group()]
            end = match.end()
        return "".join([*done, inner(whole[end:])])

    return between(markdown, FENCE, lambda part: between(part, CODE, change))


def target(link: str, source: str) -> str:
    """Where a relative link of a page leads, as a path in the project."""
    path = posixpath.normpath(posixpath.join(posixpath.dirname(source), link.split("#")[0]))
    return "" if path == "." else path


def links(source: str) -> list[str]:
    """The relative links of a page."""
    found: list[str] = []

    def collect(part: str) -> str:
        found.extend(m[3] for m in LINK.finditer(part) if not OUTSIDE.match(m[3]))
        return part

    # A link may have code in its text, so only blocks are left out.
    collect(FENCE.sub("", text(source)))
    return found


def relinked(markdown: str, source: str) -> str:
    """The page with links that fit the site; of one to a file that is no page the text stays."""
    known = pages() | pictures()
    here = posixpath.dirname(known[source])

    def turn(match: re.Match[str]) -> str:
        picture, said, link = match.groups()
        if OUTSIDE.match(link):
            return match.group()
        where = target(link, source)
        there = known.get(where) or FOLDERS.get(where)
        if there is None:
            return said
        anchor = f"#{link.split('#', 1)[1]}" if "#" in link else ""
        return f"{picture}[{said}]({posixpath.relpath(there, here or '.')}{anchor})"

    done, end = [], 0
    for block in FENCE.finditer(markdown):
        done += [LINK.sub(turn, markdown[end : block.start()]), block.group()]
        end = block.end()
    return "".join([*done, LINK.sub(turn, markdown[end:])])
