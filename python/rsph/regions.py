"""Where boundaries, loads and probes apply: parts of space, never particle indices.

Regions combine: ``a & b`` is in both, ``a | b`` in any, ``~a`` outside. Lengths are in the units of
the body (m in SI).
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rsph._scenario import Vector, check, vector

__all__ = [
    "Region",
    "ball",
    "box",
    "everywhere",
    "half_space",
    "part",
    "plane",
    "point",
    "surface_patch",
]


@dataclass(frozen=True, repr=False)
class Region:
    """A part of space or of a surface; made by the functions of this module."""

    _table: Mapping[str, Any] | str
    _words: str

    def _as_table(self) -> Mapping[str, Any] | str:
        return self._table

    def __and__(self, other: Region) -> Region:
        return _combined("and", self, "&", other)

    def __or__(self, other: Region) -> Region:
        return _combined("or", self, "|", other)

    def __invert__(self) -> Region:
        return Region({"not": self._table}, f"~{self._words}")

    def __repr__(self) -> str:
        return self._words


everywhere = Region("all", "regions.everywhere")
"""The whole body."""


def plane(*, axis: Literal["x", "y", "z"], at: float, side: Literal["below", "above"]) -> Region:
    """The half-space on one side of an axis-aligned plane.

    A clamp there that touches a flat face of the body holds that face exactly.

    Args:
        axis: normal of the plane.
        at: coordinate of the plane on that axis (m).
        side: ``"below"`` holds coordinates up to ``at``, ``"above"`` those from ``at`` on.
    """
    return _region("plane", axis=axis, at=at, side=side)


def half_space(*, point: Vector, normal: Vector) -> Region:
    """The half-space behind a plane, (x - point) . normal <= 0.

    Args:
        point: a point of the plane (m), shape (3,).
        normal: points out of the region, of any length, shape (3,).
    """
    return _region(
        "half_space",
        point=vector("region.half_space.point", point),
        normal=vector("region.half_space.normal", normal),
    )


def box(*, min: Vector, max: Vector) -> Region:
    """An axis-aligned box between the corners ``min`` and ``max`` (m), shape (3,) each."""
    return _region("box", min=vector("region.box.min", min), max=vector("region.box.max", max))


def ball(*, centre: Vector, radius: float) -> Region:
    """A ball around ``centre`` (m), shape (3,)."""
    return _region("ball", centre=vector("region.ball.centre", centre), radius=radius)


def surface_patch(*, centre: Vector, radius: float, facing: Vector) -> Region:
    """The part of the body's surface in a ball whose normal is within 90 degrees of ``facing``.

    Args:
        centre: centre of the ball (m), shape (3,).
        radius: radius of the ball (m).
        facing: a direction, shape (3,).
    """
    return _region(
        "surface_patch",
        centre=vector("region.surface_patch.centre", centre),
        radius=radius,
        facing=vector("region.surface_patch.facing", facing),
    )


def part(name: str | Sequence[str], *, path: str | os.PathLike[str], scale: float = 1.0) -> Region:
    """Named or painted parts of a mesh file, of nearly the same surface as the body.

    Parts are solids of an ASCII STL, groups, objects and materials of an OBJ, nodes, meshes and
    materials of a GLB, and in a PLY colours such as ``"#ff0000"`` and whole numbers of faces such
    as ``"label=3"``; ``rsph info`` lists them. Surface belongs to the triangle that is nearest.

    Args:
        name: name of the part, or names of several.
        path: the mesh file.
        scale: factor from the units of the mesh to metres (0.001 for a mesh in mm).
    """
    names = [name] if isinstance(name, str) else list(name)
    return _region("part", name=names, path=os.path.abspath(path), scale=scale)


def point(*, at: Vector) -> Region:
    """A single point, for probes, ``at`` that position (m), shape (3,)."""
    position = vector("region.point", at)
    return _checked(Region({"point": position}, f"regions.point(at={_shown(position)})"))


def _region(kind: str, **values: Any) -> Region:
    arguments = ", ".join(f"{key}={_shown(value)}" for key, value in values.items())
    return _checked(Region({kind: values}, f"regions.{kind}({arguments})"))


def _checked(region: Region) -> Region:
    probe = {"name": "probe", "quantity": "mass", "region": region._table}
    check("", probe=[probe])
    return region


def _combined(word: str, a: Region, sign: str, b: object) -> Region:
    if not isinstance(b, Region):
        raise TypeError(f"`{sign}` combines regions, not a region and {b!r}")
    return Region({word: [a._table, b._table]}, f"({a._words} {sign} {b._words})")


def _shown(value: object) -> str:
    return repr(tuple(value)) if isinstance(value, list) else repr(value)
