"""Shapes of bodies in their undeformed state. Lengths in m (or normalised)."""

from __future__ import annotations

import json
import os
import warnings
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from rsph import _rsph
from rsph._scenario import Table, Vector, vector, without_none
from rsph.errors import InputError, RsphWarning

__all__ = [
    "Box",
    "Cylinder",
    "Disc",
    "LabelMap",
    "Mask",
    "Mesh",
    "Organ",
    "Polygon",
    "Rectangle",
    "Shape",
    "Sphere",
    "organs",
]


class Shape:
    """A body's shape; use one of the others of this module."""

    _shape: _rsph.Shape
    _table: Table | None
    """Its words in a scenario, if it has any."""

    def _as_table(self) -> Table:
        if self._table is None:
            raise InputError(
                "`body.shape`: a shape from arrays has no words in a scenario",
                key="body.shape",
                remedy='write it with `shape.save("organ.ply")` and take Mesh("organ.ply")',
            )
        return self._table

    def __reduce__(self) -> tuple[Any, ...]:
        if self._table is None:
            return _of_arrays, (self.vertices, self.triangles)
        if isinstance(self, LabelMap):
            return _of_words, (LabelMap, self._table)
        ((_, words),) = self._table.items()
        return (Organ, (words,)) if isinstance(words, str) else (_of_words, (type(self), words))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the surface (m) as a mesh: STL, OBJ or PLY by the extension.

        Raises:
            InputError: it cannot be written, or the extension is none of these.
        """
        self._shape.save(os.fspath(path))

    @property
    def name(self) -> str:
        """What it is."""
        return self._shape.name

    @property
    def volume(self) -> float:
        """Enclosed volume (m^3)."""
        return self._shape.volume

    @property
    def repair(self) -> dict[str, Any] | None:
        """How the surface of a mesh that was open or overlapped itself was made whole, in the words
        of ``repair`` in ``summary.json``; None for any other shape."""
        text = self._shape.repair
        return None if text is None else dict(json.loads(text))

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
        size, corner = vector("body.shape.box.size", size), vector("body.shape.box.corner", corner)
        self._shape = _rsph.Shape.box(size, corner)
        self._table = {"box": {"size": size, "corner": corner}}


class Sphere(Shape):
    """A sphere of that radius (m) around ``centre`` (m), shape (3,)."""

    def __init__(self, *, radius: float, centre: Vector = (0.0, 0.0, 0.0)) -> None:
        centre = vector("body.shape.sphere.centre", centre)
        self._shape = _rsph.Shape.sphere(radius, centre)
        self._table = {"sphere": {"radius": radius, "centre": centre}}


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
        self._table = {
            "cylinder": {"radius": radius, "height": height, "axis": axis, "centre": centre}
        }


class Rectangle(Shape):
    """An axis-aligned rectangle in the plane, for plane strain of thickness one.

    Args:
        size: edge lengths (m) along x and y.
        corner: its lower corner (m).
    """

    def __init__(
        self, *, size: tuple[float, float], corner: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        sides = _pair("body.shape.rectangle.size", size)
        start = _pair("body.shape.rectangle.corner", corner)
        self._shape = _rsph.Shape.rectangle(sides, start)
        self._table = {"rectangle": {"size": sides, "corner": start}}


class Disc(Shape):
    """A disc of that radius (m) around ``centre`` (m) in the plane, for plane strain."""

    def __init__(self, *, radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> None:
        middle = _pair("body.shape.disc.centre", centre)
        self._shape = _rsph.Shape.disc(radius, middle)
        self._table = {"disc": {"radius": radius, "centre": middle}}


class Polygon(Shape):
    """The inside of a closed outline in the plane, for plane strain of thickness one.

    Args:
        points: its corners (m), shape (N, 2), in order around it.
    """

    def __init__(self, points: npt.ArrayLike) -> None:
        corners = _table("body.shape.polygon.points", points, float, 2)
        self._shape = _rsph.Shape.polygon(corners.tolist())
        self._table = {"polygon": {"points": corners.tolist()}}


class Organ(Shape):
    """An organ of an adult that the program builds itself; metres, y up. See :func:`organs`."""

    def __init__(self, name: str) -> None:
        self._shape = _rsph.Shape.organ(name)
        self._table = {"organ": name}


class Mesh(Shape):
    """The inside of a triangle mesh, from a file or from arrays.

    Equal vertices are made one, and what is turned inside out is turned round, with an
    :class:`rsph.RsphWarning`. A mesh that is open or overlaps itself becomes a body by its winding
    number; warnings say how sure that is and where it is not, :attr:`Shape.repair` has the figures.

    Args:
        path: an STL, OBJ, PLY or GLB file.
        scale: factor from the units of the mesh to metres (0.001 for a mesh in mm).
        vertices: instead of a path: positions, shape (V, 3).
        triangles: with ``vertices``: vertex indices, outward, shape (T, 3).
        repair: False refuses a mesh that is not closed.
    """

    def __init__(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        scale: float = 1.0,
        vertices: npt.ArrayLike | None = None,
        triangles: npt.ArrayLike | None = None,
        repair: bool = True,
    ) -> None:
        if path is not None and vertices is None and triangles is None:
            self._shape = _rsph.Shape.mesh_file(os.fspath(path), scale, repair)
            words = {"path": os.path.abspath(path), "scale": scale, "repair": repair}
            self._table = {"mesh": words}
        elif path is None and vertices is not None and triangles is not None:
            points = _table("vertices", vertices, np.float64) * scale
            self._shape = _rsph.Shape.mesh_arrays(points, _indices(triangles), repair)
            self._table = None
        else:
            raise InputError(
                "`body.shape.mesh`: needs either a path, or vertices and triangles",
                key="body.shape.mesh",
                remedy='for example Mesh("liver.stl") or Mesh(vertices=v, triangles=t)',
            )
        for note in self._shape.notes:
            warnings.warn(note, RsphWarning, stacklevel=2)


class Mask(Shape):
    """The body that voxels of an image show, with a smooth surface of the same volume.

    The voxels are blurred by a Gaussian as wide as a voxel, and the level that encloses their
    volume is the surface; of an image with more than two million voxels around the body two or
    more are first made one.

    >>> import numpy as np
    >>> x = np.indices((40, 40, 40)) - 20.0
    >>> ball = Mask(np.sqrt((x**2).sum(axis=0)) < 15.0, 0.001)
    >>> bool(abs(ball.volume / (4 / 3 * np.pi * 0.015**3) - 1.0) < 0.01)
    True

    Args:
        mask: the voxels, shape (NX, NY, NZ): True or False, or the numbers of labels.
        voxel: size of a voxel (m) along the axes of the array, shape (3,) or one number; the first
            voxel has its centre at the origin.
        affine: instead of ``voxel``: the matrix from indices of voxels to the positions of their
            centres (m), shape (4, 4), as an image's header has it (often in mm).
        label: the number that means inside; by default everything but 0, False and NaN.
    """

    def __init__(
        self,
        mask: npt.ArrayLike,
        voxel: npt.ArrayLike | None = None,
        *,
        affine: npt.ArrayLike | None = None,
        label: int | None = None,
    ) -> None:
        voxels = np.asarray(mask)
        if voxels.ndim != 3 or voxels.dtype.kind not in "biuf":
            raise InputError(
                f"`mask`: is an array of shape {voxels.shape} of {voxels.dtype}",
                key="mask",
                value=f"an array of shape {voxels.shape}",
                remedy="give truth values or whole numbers in three dimensions",
            )
        # What is no number is outside; labels are read to the nearest whole number.
        inside = (
            np.isfinite(voxels) & (voxels != 0)
            if label is None
            else np.abs(voxels.astype(np.float64, copy=False) - label) < 0.5
        )
        self._table = None
        self._shape = _rsph.Shape.mask(
            np.ascontiguousarray(inside), _affine(voxel, affine).tolist(), "mask"
        )
        for note in self._shape.notes:
            warnings.warn(note, RsphWarning, stacklevel=2)


class LabelMap(Shape):
    """The body of one label in a CT or MR segmentation, as :class:`Mask` makes it.

    Positions are those of the image (its header's, in mm most often) in metres.

    Args:
        path: a NIfTI file (``.nii``, ``.nii.gz``) or an NRRD file (``.nrrd``).
        label: number of the organ in the image.
        scale: factor from the units of the image to metres; by default what its header says.
        axes: ``"image"`` keeps the axes of the image; ``"organ"`` turns a patient's (x to the left
            or right, y to the back or front, z up) to those of organs here: x from the right side
            of the body to its left, y up, z to the front.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        label: int = 1,
        scale: float | None = None,
        axes: Literal["image", "organ"] = "image",
    ) -> None:
        name = os.fspath(path)
        self._shape = _rsph.Shape.label_map(name, label, scale, axes)
        self._table = without_none(path=os.path.abspath(name), label=label, scale=scale)
        self._table |= {"axes": axes}
        for note in self._shape.notes:
            warnings.warn(note, RsphWarning, stacklevel=2)

    def _as_table(self) -> Table:
        # A scenario has it beside `body.shape`: see `body_table`.
        raise InputError(
            "`body.shape`: a label map is no shape of a scenario",
            key="body.shape",
            remedy="give its words as `body.labelmap`",
        )


def organs() -> list[str]:
    """Names of the organs that :class:`Organ` knows."""
    return _rsph.organ_names()


def _of_words(kind: type[Shape], words: Table) -> Shape:
    return kind(**words)


def _of_arrays(vertices: npt.NDArray[np.float64], triangles: npt.NDArray[np.uint32]) -> Shape:
    return Mesh(vertices=vertices, triangles=triangles)


def _affine(voxel: npt.ArrayLike | None, affine: npt.ArrayLike | None) -> npt.NDArray[np.float64]:
    """The matrix (4, 4) from indices to positions."""
    if (voxel is None) == (affine is None):
        raise InputError(
            "`voxel`: needs either the size of a voxel or `affine`",
            key="voxel",
            remedy="for example 0.001 for voxels of 1 mm",
        )
    try:
        if affine is not None:
            matrix = np.array(affine, dtype=np.float64)
        else:
            size = np.broadcast_to(np.asarray(voxel, dtype=np.float64), (3,))
            matrix = np.diag([*size, 1.0])
    except (TypeError, ValueError):
        matrix = np.empty(0)
    if matrix.shape != (4, 4):
        key = "voxel" if affine is None else "affine"
        raise InputError(
            f"`{key}` = {voxel if affine is None else affine!r}: has the wrong shape",
            key=key,
            remedy="give one number or three (m) as `voxel`, or four rows of four as `affine`",
        )
    return matrix


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


def _table(key: str, values: npt.ArrayLike, dtype: Any, columns: int = 3) -> npt.NDArray[Any]:
    try:
        table = np.asarray(values)
        exact = table.astype(dtype, casting="same_kind" if dtype is np.int64 else "unsafe")
    except (TypeError, ValueError):
        raise InputError(
            f"`{key}`: is no array of {'indices' if dtype is np.int64 else 'numbers'}",
            key=key,
            remedy=f"give an array of shape (N, {columns})",
        ) from None
    if exact.ndim != 2 or exact.shape[1] != columns:
        raise InputError(
            f"`{key}`: has the shape {exact.shape}, but one row of {columns} is needed for each",
            key=key,
            value=f"an array of shape {exact.shape}",
            remedy=f"give an array of shape (N, {columns})",
        )
    return exact
