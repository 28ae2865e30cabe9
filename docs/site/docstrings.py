"""Docstrings as Markdown: examples in blocks of their own, references of Sphinx as plain code."""

from __future__ import annotations

import re
from typing import Any

from griffe import Extension, Object

EXAMPLE = re.compile(r"^>>> .*?(?=\n\s*\n|\Z)", re.DOTALL | re.MULTILINE)
ROLE = re.compile(r":(?:class|meth|mod|func|attr|data|exc):`[~.]*")
DOUBLE = re.compile(r"``([^`]+)``")


class Docstrings(Extension):
    """Changes every docstring before it is read for arguments and results."""

    def on_instance(self, *, obj: Object, **kwargs: Any) -> None:
        """Called for each module, class, function and attribute."""
        if obj.docstring is None:
            return
        said = ROLE.sub("`", DOUBLE.sub(r"`\1`", obj.docstring.value))
        obj.docstring.value = EXAMPLE.sub(lambda m: f"```pycon\n{m.group()}\n```", said)
