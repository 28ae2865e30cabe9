"""What happens to pages while MkDocs builds the site.

Pages from outside docs/ are brought in, links between them fitted, formulas turned into MathML.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

sys.path.insert(0, str(Path(__file__).parent))

import generate
import pages

SOURCES = {there: here for here, there in pages.pages().items()}
FORMULA = re.compile(r"\$\$(.+?)\$\$|\$([^\s$](?:[^$\n]*[^\s$])?)\$", re.DOTALL)
PLACE = re.compile(r"<p>FORMULA(\d+)X</p>|FORMULA(\d+)X")

_formulas: list[str] = []


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Adds the page of performance to the menu if there is one."""
    if (pages.ROOT / "docs" / "performance.md").is_file():
        validation = next(entry for entry in config.nav or [] if "Validation" in entry)
        validation["Validation"].append({"Performance": "performance.md"})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages and pictures that live outside docs/, and the generated ones."""
    for here, there in (pages.pages() | pages.pictures()).items():
        if files.get_file_from_path(there) is not None:
            continue
        if there.endswith(".md"):
            files.append(File.generated(config, there, content=pages.text(here)))
        else:
            path = str(pages.ROOT / here)
            files.append(File.generated(config, there, abs_src_path=path))
    for there in pages.GENERATED:
        files.append(File.generated(config, there, content=generate.page(there)))
    for name, there in generate.extra_files().items():
        files.append(File.generated(config, there, abs_src_path=name))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Fits the links, and puts formulas aside so that Markdown leaves them alone."""
    source = SOURCES.get(page.file.src_uri)
    if source is not None:
        markdown = pages.relinked(markdown, source)

    def aside(match: re.Match[str]) -> str:
        block, inline = match.groups()
        formula = convert(block or inline, display="block" if block else "inline")
        _formulas.append(f"<span data-search-exclude>{formula}</span>")
        return f"FORMULA{len(_formulas) - 1}X"

    return pages.outside_code(markdown, lambda part: FORMULA.sub(aside, part))


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Puts the formulas back."""

    def back(match: re.Match[str]) -> str:
        alone, inside = match.groups()
        if alone is None:
            return _formulas[int(inside)]
        return f'<div class="formula">{_formulas[int(alone)]}</div>'

    return PLACE.sub(back, html)
