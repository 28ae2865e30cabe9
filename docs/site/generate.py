"""Pages made from data: the scenario's keys, the Python API, the last run of the validation."""

from __future__ import annotations

import json
import os
import re
from typing import Any

import pages

TARGET = pages.ROOT / "target"
SCHEMA = TARGET / "schema.json"
VALIDATION = TARGET / "validate.json"
REPORT = pages.ROOT / "validation" / "report.html"

Schema = dict[str, Any]
#: A unit as descriptions have it, `Pressure (Pa), ...`.
UNIT = re.compile(r"\s\(((?:kg|m|s|Pa|Hz|rad|1)(?:[/^][a-z0-9^]+)?)\)")


def page(uri: str) -> str:
    """The Markdown of a generated page."""
    if uri == "reference/keys.md":
        return keys(json.loads(SCHEMA.read_text())) if SCHEMA.is_file() else NO_SCHEMA
    if uri == "reference/rust.md":
        return RUST_PAGE if "RSPH_RUST_DOC" in os.environ else NO_RUST
    if uri == "validation/last-run.md":
        return last_run()
    module = uri.removeprefix("reference/python/").removesuffix(".md")
    return f"# rsph.{module}\n\n::: rsph.{module}\n"


def extra_files() -> dict[str, str]:
    """Files that are copied as they are: path -> path in the site."""
    return {str(REPORT): "validation/report.html"} if REPORT.is_file() else {}


NO_SCHEMA = """# Every key

This page is made from `rsph schema`, and the program was not there when the site was built. The
[scenario file](../guide/scenario.md) describes every key.
"""

RUST_PAGE = """# Rust

<a href="../rust/rsph_core/index.html">The crate `rsph_core`</a>: the numerics, as `cargo doc` shows
them. [Architecture](../architecture.md) says what is where.
"""

NO_RUST = """# Rust

The site was built without it: `./build-docs` with cargo at hand, and without `--no-rust`, adds it.
`cargo doc --no-deps -p rsph-core --open` shows it by itself.
"""


def last_run() -> str:
    """The table of the last run of the validation."""
    lines = ["# The last run", ""]
    if not VALIDATION.is_file():
        return "\n".join(
            [
                *lines,
                "There was none when this site was built.",
                "`rsph validate --json target/validate.json` runs it, and the next",
                "`./build-docs` shows its table here.",
            ]
        )
    rows = json.loads(VALIDATION.read_text())
    missed = sum(not row["pass"] for row in rows)
    lines.append(f"{len(rows)} checks, {missed} of them missed. What each compares is said")
    lines.append("on the page of its case.")
    if extra_files():
        lines.append('<a href="report.html">The same with all figures on one page</a>.')
    case = None
    for row in rows:
        of, _, check = row["name"].partition(": ")
        if of != case:
            case = of
            there = (pages.ROOT / "validation" / of / "README.md").is_file()
            lines += ["", f"## {of}", ""]
            lines += [f"[What it compares]({of}/README.md)", ""] if there else []
            lines += [
                "| check | measured | reference | paper | bound | |",
                "|---|---|---|---|---|---|",
            ]
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        cells = [
            check,
            number(row["measured"]) + unit,
            number(row["reference"]),
            row["paper"] or "",
            row["bound"],
            "good" if row["pass"] else "**missed**",
        ]
        lines.append(table_row(cells))
    return "\n".join(lines) + "\n"


def number(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"


def table_row(cells: list[str]) -> str:
    return "| " + " | ".join(" ".join(c.split()).replace("|", "\\|") for c in cells) + " |"


def keys(schema: Schema) -> str:
    """Every key of a scenario, from its JSON Schema."""
    lines = [
        "# Every key",
        "",
        "Made from `rsph schema`. The guide to it, with examples, is",
        "[the scenario file](../guide/scenario.md).",
        "",
    ]
    lines += ["## Top level", "", *table(schema)]
    for name, part in sorted(schema["$defs"].items()):
        lines += ["", f"## {name}", "", sentence(part.get("description", "")), ""]
        if "enum" in part:
            lines.append(
                "One of " + ", ".join(f"`{json.dumps(word)}`" for word in part["enum"]) + "."
            )
        elif "properties" in part:
            lines += table(part)
        elif any("const" in form and "properties" not in form for form in forms(part)):
            lines += ["| value | what |", "|---|---|"]
            lines += [table_row([value(form), form.get("description", "")]) for form in forms(part)]
        else:
            for form in forms(part):
                lines += alternative(form)
    return "\n".join(lines) + "\n"


def forms(part: Schema) -> list[Schema]:
    return list(part.get("oneOf") or part.get("anyOf") or [])


def value(form: Schema) -> str:
    if "const" in form:
        return f"`{json.dumps(form['const'])}`"
    return ", ".join(
        f"`{key}` = {kind(inner)}" for key, inner in form.get("properties", {}).items()
    )


def alternative(form: Schema) -> list[str]:
    """One of several forms of a table."""
    said = sentence(form.get("description", ""))
    properties = form.get("properties", {})
    inner = next(iter(properties.values()), {})
    if len(properties) == 1 and "properties" in inner:
        name = next(iter(properties))
        return [f"`{name} = {{ ... }}`: {said}", "", *table(inner), ""]
    if "const" in next(iter(properties.values()), {}):
        name, first = next(iter(properties.items()))
        rest = {key: entry for key, entry in properties.items() if key != name}
        return [
            f"`{name} = {json.dumps(first['const'])}`: {said}",
            "",
            *table({**form, "properties": rest}),
            "",
        ]
    if properties:
        return [f"{value(form)}: {said}", ""]
    return [f"{kind(form)} {said}".rstrip(), ""]


def table(part: Schema) -> list[str]:
    """Key, type, unit, default and meaning of the entries of a table."""
    lines = ["| key | type | unit | default | what |", "|---|---|---|---|---|"]
    required = part.get("required", [])
    for key, entry in part["properties"].items():
        said = entry.get("description", "")
        before, mark, default = said.partition("Default: ")
        if mark:
            said = before
        if key in required:
            default = "required"
        elif not mark and entry.get("default") not in (None, ""):
            default = f"`{json.dumps(entry['default'])}`"
        units = UNIT.findall(said)
        if len(units) == 1:
            said = UNIT.sub("", said)
        unit = units[0] if len(units) == 1 else ""
        lines.append(
            table_row([f"`{key}`", kind(entry), unit, default.rstrip(".\n "), sentence(said)])
        )
    return lines


def sentence(said: str) -> str:
    said = " ".join(said.split())
    return said[:1].upper() + said[1:]


def kind(entry: Schema) -> str:
    """The type of an entry, in words, with what limits it."""
    if "$ref" in entry:
        name = entry["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "const" in entry:
        return f"`{json.dumps(entry['const'])}`"
    if entry.get("enum"):
        return " or ".join(f"`{json.dumps(word)}`" for word in entry["enum"])
    several = [form for form in forms(entry) if form.get("type") != "null"]
    if several:
        return " or ".join(kind(form) for form in several)
    of = entry.get("type", "")
    of = next((t for t in of if t != "null"), "") if isinstance(of, list) else of
    if of == "array":
        items = entry.get("items", {})
        count = entry.get("minItems")
        if count is not None and count == entry.get("maxItems"):
            return (
                f"{count} times {kind(items)}"
                if items.get("type") == "array"
                else f"{count} numbers"
            )
        return f"list of {kind(items)}"
    words = {"integer": "whole number", "boolean": "true or false", "string": "text"}
    limits = [
        f"{sign} {entry[key]:g}"
        for key, sign in {
            "exclusiveMinimum": ">",
            "minimum": "≥",
            "exclusiveMaximum": "<",
            "maximum": "≤",
        }.items()
        if key in entry
    ]
    return " ".join([words.get(of, of), ", ".join(limits)]).strip()
