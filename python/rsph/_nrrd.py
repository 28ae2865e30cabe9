"""Segmentations in NRRD files, by the package pynrrd."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

from rsph.errors import Error, InputError

# From the space of an NRRD file to right, anterior, superior; the first letters of the three words.
_SIGNS = {"right": 1.0, "left": -1.0, "anterior": 1.0, "posterior": -1.0, "superior": 1.0}
_SIGNS["inferior"] = -1.0
_SHORT = {
    "ras": "right-anterior-superior",
    "las": "left-anterior-superior",
    "lps": "left-posterior-superior",
}
_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "um": 1e-6, "\u00b5m": 1e-6}


def read_nrrd(
    path: str, label: int, scale: float | None, axes: str
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.float64]]:
    """The voxels (NX, NY, NZ) of a label, and the matrix (4, 4) from indices to metres.

    Raises:
        InputError: the file cannot be read, or holds no such label.
    """
    try:
        import nrrd
    except ImportError as e:
        raise Error("NRRD files need pynrrd; install it with `pip install rsph[nrrd]`") from e

    def refuse(problem: str, remedy: str) -> InputError:
        return InputError(f"{path}: {problem}", key="body.labelmap.path", value=path, remedy=remedy)

    # What the package lets through of a damaged file depends on where the damage is.
    damage = (ArithmeticError, EOFError, LookupError, OSError, TypeError, ValueError)
    try:
        voxels, header = nrrd.read(path)
        directions, origin = _axes(header)
        unit = _unit(header) if scale is None else scale
    except (*damage, MemoryError, zlib.error, nrrd.NRRDError) as e:
        raise refuse(f"cannot be read: {e}", "give a segmentation as NRRD or NIfTI") from None
    if voxels.ndim != 3:
        raise refuse(
            f"has {voxels.ndim} dimensions, a segmentation has three",
            "export one label map, not several in one file",
        )
    if directions.shape != (3, 3) or origin.shape != (3,):
        raise refuse("does not say where its voxels are", "export it again, or give it as NIfTI")
    inside = np.ascontiguousarray(voxels == label)
    if not inside.any():
        there = ", ".join(str(v) for v in np.unique(voxels)[:20])
        raise refuse(f"no voxel has the label {label}", f"the file holds {there}")
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = directions, origin
    # NRRD tells the space of its positions; NIfTI has always right, anterior, superior.
    matrix = np.diag([*_to_ras(header), 1.0]) @ matrix
    if axes == "organ":
        matrix = np.array([[-1.0, 0, 0, 0], [0, 0, 1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) @ matrix
    elif axes != "image":
        raise InputError(
            f"`axes` = {axes!r}: there are no such axes",
            key="body.labelmap.axes",
            value=repr(axes),
            remedy='choose "image" or "organ"',
        )
    return inside, np.diag([unit, unit, unit, 1.0]) @ matrix


def _axes(header: dict[str, Any]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Directions, one column an axis, and origin."""
    directions = header.get("space directions")
    if directions is not None:
        matrix = np.array(directions, dtype=np.float64).T
    else:
        matrix = np.diag(np.array(header.get("spacings", [1.0, 1.0, 1.0]), dtype=np.float64))
    return matrix, np.array(header.get("space origin", [0.0, 0.0, 0.0]), dtype=np.float64)


def _to_ras(header: dict[str, Any]) -> list[float]:
    space = str(header.get("space", "right-anterior-superior")).lower()
    words = _SHORT.get(space, space).split("-")[:3]
    return [_SIGNS.get(word, 1.0) for word in words]


def _unit(header: dict[str, Any]) -> float:
    units = header.get("space units") or ["mm"]
    return _METRES.get(str(units[0]).strip('"'), 0.001)
