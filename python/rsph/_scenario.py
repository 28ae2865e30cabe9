"""From Python values to the tables of a scenario file, which the compiled half understands.

Whatever is built in Python is checked by the same code, with the same defaults and messages, as a
scenario file.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from rsph import _rsph
from rsph.errors import InputError

Vector: TypeAlias = Sequence[float] | npt.NDArray[Any]
"""Three numbers along x, y, z."""

Table: TypeAlias = dict[str, Any]

# Stands where a scenario needs something that the thing being checked does not have.
_PLACEHOLDER: Table = {
    "body": {"shape": {"box": {"size": [1.0, 1.0, 1.0]}}, "spacing": 0.5},
    "material": {
        "model": "kelvin-voigt",
        "density": 1.0,
        "young_modulus": 1.0,
        "poisson_ratio": 0.0,
        "relaxation_time": 0.0,
    },
    "time": {"until": 1.0},
}


def scenario(**tables: Any) -> str:
    """A scenario as TOML; what is left out has harmless placeholders."""
    return "\n".join(
        f"{key} = {toml(value, key)}" for key, value in (_PLACEHOLDER | tables).items()
    )


def check(name: str, **tables: Any) -> None:
    """Raises InputError if ``tables`` cannot be understood.

    Keys of a list's first entry, such as ``load[0].radius``, are shown as those of ``name``.
    """
    try:
        _rsph.check(scenario(**tables))
    except InputError as e:
        start = next((f"{table}[0]" for table in tables if e.key.startswith(f"{table}[0]")), None)
        if start is None:
            raise
        key = (name + e.key.removeprefix(start)).removeprefix(".")
        message = str(e).split("\n  help: ", maxsplit=1)[0].replace(e.key, key)
        raise InputError(message, key=key, value=e.value, remedy=e.remedy) from None


def vector(key: str, value: object) -> list[float]:
    """Three numbers, or InputError."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3,):
        raise InputError(
            f"`{key}` = {value!r}: needs three numbers",
            key=key,
            value=repr(value),
            remedy="give the components along x, y and z, for example (0.0, 0.0, 1.0)",
        )
    numbers: list[float] = array.tolist()
    return numbers


def matrix(key: str, value: object) -> list[list[float]]:
    """Three rows of three numbers, or InputError."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3, 3):
        raise InputError(
            f"`{key}` = {value!r}: needs three rows of three numbers",
            key=key,
            value=repr(value),
            remedy="row i is the gradient of component i",
        )
    numbers: list[list[float]] = array.tolist()
    return numbers


def ramp(key: str, value: object) -> Table:
    """The table of a ramp from a pair (from, to) of times."""
    try:
        start, end = (float(t) for t in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        raise InputError(
            f"`{key}` = {value!r}: needs two times",
            key=key,
            value=repr(value),
            remedy="give (from, to): the load grows from 0 at `from` to all of it at `to`",
        ) from None
    return {"from": start, "to": end}


def curve(
    key: str,
    time: object,
    value: object,
    kind: str,
    periodic: bool,
) -> Table:
    """The table of a curve through points."""
    lists: Table = {}
    for name, numbers in (("time", time), ("value", value)):
        try:
            array = np.asarray(numbers, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.empty((0, 0))
        if array.ndim != 1:
            raise InputError(
                f"`{key}.{name}` = {numbers!r}: needs a list of numbers",
                key=f"{key}.{name}",
                value=repr(numbers),
                remedy="give as many times as values",
            )
        lists[name] = array.tolist()
    return lists | {"kind": kind, "periodic": periodic}


def without_none(**table: Any) -> Table:
    """The entries that are given."""
    return {key: value for key, value in table.items() if value is not None}


def plain(value: object) -> object:
    """A value in which the objects of this package are the tables that they stand for."""
    table = getattr(value, "_as_table", None)
    if callable(table):
        return plain(table())
    match value:
        case Mapping():
            return {key: plain(v) for key, v in value.items()}
        case list() | tuple():
            return [plain(v) for v in value]
        case _:
            return value


def toml(value: object, key: str) -> str:
    """A value as TOML; ``key`` names it in messages."""
    match value:
        case bool() | np.bool_():
            return "true" if value else "false"
        case int() | np.integer():
            return str(int(value))
        case float() | np.floating():
            number = float(value)
            return repr(number) if math.isfinite(number) else str(number)
        case str():
            return _text(value)
        case Mapping():
            entries = (f"{_text(str(k))} = {toml(v, f'{key}.{k}')}" for k, v in value.items())
            return "{" + ", ".join(entries) + "}"
        case np.ndarray():
            return toml(value.tolist(), key)
        case list() | tuple():
            return "[" + ", ".join(toml(v, f"{key}[{i}]") for i, v in enumerate(value)) + "]"
        case _:
            raise InputError(
                f"`{key}` = {value!r}: a {type(value).__name__} means nothing here",
                key=key,
                value=repr(value),
                remedy="give a number, a text, or a sequence of numbers",
            )


def _text(text: str) -> str:
    plain = "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in _escaped(text))
    return f'"{plain}"'


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')
