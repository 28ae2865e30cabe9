"""The documentation site: its menu names pages that there are, and links lead somewhere.

Needs neither MkDocs nor the network; ``./build-docs`` builds the site.
"""

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[2]


def load(name: str) -> ModuleType:
    """A module of docs/site, which is no package."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / "site" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


pages = load("pages")
generate = load("generate")
check = load("check")


def named(menu: Any) -> Iterator[str]:
    if isinstance(menu, str):
        yield menu
    for entry in (
        menu.values() if isinstance(menu, dict) else menu if isinstance(menu, list) else ()
    ):
        yield from named(entry)


MENU = list(named(yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"]))


def test_the_menu_names_pages_that_there_are() -> None:
    there = [*pages.pages().values(), *pages.GENERATED]
    assert len(MENU) > 50
    assert [page for page in MENU if page not in there] == []
    assert len(set(MENU)) == len(MENU)


def test_every_page_is_in_the_menu() -> None:
    # Scenarios are reached by links; the hook adds the page of performance by itself.
    elsewhere = ("scenarios/", "performance.md")
    there = [*pages.pages().values(), *pages.GENERATED]
    assert [p for p in there if p not in MENU and not p.startswith(elsewhere)] == []


@pytest.mark.parametrize("page", [p for p in pages.pages() if not p.endswith(".toml")])
def test_links_lead_somewhere(page: str) -> None:
    missing = [link for link in pages.links(page) if not (ROOT / pages.target(link, page)).exists()]
    assert missing == []


def test_modules_of_the_package_have_a_page() -> None:
    public = {p.stem for p in (ROOT / "python" / "rsph").glob("*.py") if p.stem[0] != "_"}
    assert set(pages.PYTHON) == public


def test_links_are_fitted_to_the_site() -> None:
    said = (
        "[a](../../validation/README.md), [b](../equations.md#x), [c](../../crates/rsph-core),\n"
        "![d](../../validation/patch/figure.png), [e](https://a.org),\n"
        "[f](../../scenarios/liver_load.toml)\n"
        "```\n[a](../../validation/README.md)\n```\n"
    )
    assert pages.relinked(said, "docs/guide/results.md") == (
        "[a](../validation/README.md), [b](../equations.md#x), c,\n"
        "![d](../validation/patch/figure.png), [e](https://a.org),\n"
        "[f](../scenarios/liver_load.md)\n"
        "```\n[a](../../validation/README.md)\n```\n"
    )


def test_formulas_are_not_looked_for_in_code() -> None:
    assert pages.outside_code("a `a` a\n```\na\n```\na", str.upper) == "A `a` A\n```\na\n```\nA"


def test_keys_of_the_schema_become_tables() -> None:
    schema = {
        "properties": {"body": {"$ref": "#/$defs/Body", "description": "the body"}},
        "required": ["body"],
        "$defs": {
            "Body": {
                "properties": {
                    "spacing": {
                        "type": ["number", "null"],
                        "exclusiveMinimum": 0,
                        "description": "Distance (m). Default: from the number.",
                    },
                    "centre": {"type": "array", "items": {}, "minItems": 3, "maxItems": 3},
                }
            },
            "Side": {"oneOf": [{"const": "above", "description": "upward"}]},
        },
    }
    page = generate.keys(schema)
    assert "| `body` | [Body](#body) |  | required | The body |" in page
    assert "| `spacing` | number > 0 | m | from the number | Distance. |" in page
    assert "| `centre` | 3 numbers |  |  |  |" in page
    assert '| `"above"` | upward |' in page


def test_loads_from_the_network_are_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert check.main(tmp_path) == 1, "an empty folder is no site"
    page = tmp_path / "index.html"
    page.write_text('<a href="https://a.org">a</a><script src="a.js"></script>')
    assert check.main(tmp_path) == 0
    for load in (
        '<script src="https://a.org/a.js"></script>',
        '<link rel="stylesheet" href="//a.org/a.css">',
        '<p style="background: url(http://a.org/a.png)">',
    ):
        page.write_text(load)
        assert check.main(tmp_path) == 1
    page.write_text("<p>")
    (tmp_path / "a.css").write_text('@import "https://a.org/a.css";')
    assert check.main(tmp_path) == 1
    assert "a.css" in capsys.readouterr().err
