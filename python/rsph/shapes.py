"""Shapes of bodies in their undeformed state. Lengths in m (or normalised)."""

from __future__ import annotations

import os
import warnings
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from rsph import _rsph
from rsph._scenario import Vector, vector
from rsph.errors import InputError, RsphWarning

__all__ = ["Box", "Cylinder", "Disc", "Mesh", "Organ", "Rectangle", "Shape", "Sphere", "organs"]


class Shape:
    """A body's shape; use one of the others of this module."""

    _shape: _rsph.Shape

    @property
    def name(self) -> str:
        """What it is."""
        return self._shape.name

    @property
    def volume(self) -> float:
        """Enclosed volume (m^3)."""
        return self._shape.volume

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """Lower and upper corner of the bounding box (m), shape (2, 3)."""
        return np.array(self._shape.bounds)

    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """Vertices of its surface (m), shape (V, 3)."""
        return self._shape.surface()[0]

    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """Triangles of its surface as vertex indices, outward, shape (T, 3)."""
        return self._shape.surface()[1]

    def signed_distance(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Distances (m) of points (N, 3) from the surface, negative inside, shape (N,)."""
        return self._shape.signed_distance(_table("points", points, np.float64))

    def __repr__(self) -> str:
        return repr(self._shape)


class Box(Shape):
    """An axis-aligned box.

    Args:
        size: edge lengths (m), shape (3,).
        corner: its lower corner (m), shape (3,).
    """

    def __init__(self, *, size: Vector, corner: Vector = (0.0, 0.0, 0.0)) -> None:
        self._shape = _rsph.Shape.box(
            vector("body.shape.box.size", size), vector("body.shape.box.corner", corner)
        )


class Sphere(Shape):
    """A sphere of that radius (m) around ``centre`` (m), shape (3,)."""

    def __init__(self, *, radius: float, centre: Vector = (0.0, 0.0, 0.0)) -> None:
        self._shape = _rsph.Shape.sphere(radius, vector("body.shape.sphere.centre", centre))


class Cylinder(Shape):
    """A circular cylinder.

    Args:
        radius: radius (m).
        height: length along its axis (m).
        axis: direction of its axis.
        centre: its centre (m), shape (3,).
    """

    def __init__(
        self,
        *,
        radius: float,
        height: float,
        axis: Literal["x", "y", "z"] = "z",
        centre: Vector = (0.0, 0.0, 0.0),
    ) -> None:
        centre = vector("body.shape.cylinder.centre", centre)
        self._shape = _rsph.Shape.cylinder(radius, height, axis, centre)


class Rectangle(Shape):
    """An axis-aligned rectangle in the plane, for plane strain of thickness one.

    Args:
        size: edge lengths (m) along x and y.
        corner: its lower corner (m).
    """

    def __init__(
        self, *, size: tuple[float, float], corner: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        self._shape = _rsph.Shape.rectangle(
            _pair("body.shape.rectangle.size", size), _pair("body.shape.rectangle.corner", corner)
        )


class Disc(Shape):
    """A disc of that radius (m) around ``centre`` (m) in the plane, for plane strain."""

    def __init__(self, *, radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> None:
        self._shape = _rsph.Shape.disc(radius, _pair("body.shape.disc.centre", centre))


class Organ(Shape):
    """An organ of an adult that the program builds itself; metres, y up. See :func:`organs`."""

    def __init__(self, name: str) -> None:
        self._shape = _rsph.Shape.organ(name)


class Mesh(Shape):
    """The inside of a closed triangle mesh, from a file or from arrays.

    Equal vertices are made one, and a mesh that is turned inside out is turned round, with an
    :class:`rsph.RsphWarning`.

    Args:
        path: an STL, OBJ, PLY or GLB file.
        scale: factor from the units of the mesh to metres (0.001 for a mesh in mm).
        vertices: instead of a path: positions, shape (V, 3).
        triangles: with ``vertices``: vertex indices, outward, shape (T, 3).
    """

    def __init__(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        scale: float = 1.0,
        vertices: npt.ArrayLike | None = None,
        triangles: npt.ArrayLike | None = None,
    ) -> None:
        if path is not None and vertices is None and triangles is None:
            self._shape = _rsph.Shape.mesh_file(os.fspath(path), scale)
        elif path is None and vertices is not None and triangles is not None:
            points = _table("vertices", vertices, np.float64) * scale
            self._shape = _rsph.Shape.mesh_arrays(points, _indices(triangles))
        else:
            raise InputError(
                "`body.shape.mesh`: needs either a path, or vertices and triangles",
                key="body.shape.mesh",
                remedy='for example Mesh("liver.stl") or Mesh(vertices=v, triangles=t)',
            )
        for note in self._shape.notes:
            warnings.warn(note, RsphWarning, stacklevel=2)


def organs() -> list[str]:
    """Names of the organs that :class:`Organ` knows."""
    return _rsph.organ_names()


def _pair(key: str, values: tuple[float, float]) -> list[float]:
    """Two coordinates in the plane."""
    return vector(key, [*values, 0.0])[:2]


def _indices(triangles: npt.ArrayLike) -> npt.NDArray[np.uint32]:
    table: npt.NDArray[np.int64] = _table("triangles", triangles, np.int64)
    if table.size and (table.min() < 0 or table.max() > np.iinfo(np.uint32).max):
        wrong = table.min() if table.min() < 0 else table.max()
        raise InputError(
            f"`triangles`: holds the vertex index {wrong}",
            key="triangles",
            remedy="vertex indices count from 0",
        )
    return table.astype(np.uint32)


def _table(key: str, values: npt.ArrayLike, dtype: Any) -> npt.NDArray[Any]:
    try:
        table = np.asarray(values)
        exact = table.astype(dtype, casting="same_kind" if dtype is np.int64 else "unsafe")
    except (TypeError, ValueError):
        raise InputError(
            f"`{key}`: is no array of {'indices' if dtype is np.int64 else 'numbers'}",
            key=key,
            remedy="give an array of shape (N, 3)",
        ) from None
    if exact.ndim != 2 or exact.shape[1] != 3:
        raise InputError(
            f"`{key}`: has the shape {exact.shape}, but one row of three is needed for each",
            key=key,
            value=f"an array of shape {exact.shape}",
            remedy="give an array of shape (N, 3)",
        )
    return exact
