"""Vector fields over the undeformed body, for initial values.

Instead of one of these, ``Simulation`` takes a constant vector, or a function of an array (N, 3) of
reference positions that returns an array (N, 3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from rsph._scenario import Table, Vector, matrix, vector

__all__ = ["Affine", "Field", "FreeBeam", "Rotation", "Wave"]


@dataclass(frozen=True, kw_only=True)
class Affine:
    """``constant + gradient x``.

    Args:
        gradient: row i is the gradient of component i, shape (3, 3); dimensionless for
            displacements, in 1/s for velocities.
        constant: value at the origin (m for displacements, m/s for velocities), shape (3,).
    """

    gradient: npt.ArrayLike
    constant: Vector = (0.0, 0.0, 0.0)

    def _as_table(self) -> Table:
        gradient = matrix("initial.affine.gradient", self.gradient)
        constant = vector("initial.affine.constant", self.constant)
        return {"affine": {"gradient": gradient, "constant": constant}}


@dataclass(frozen=True, kw_only=True)
class Rotation:
    """``rate x (x - centre)``: a rigid rotation.

    Args:
        rate: rotation vector (rad/s for velocities, rad for displacements), shape (3,).
        centre: a point of the axis (m), shape (3,).
    """

    rate: Vector
    centre: Vector = (0.0, 0.0, 0.0)

    def _as_table(self) -> Table:
        rate = vector("initial.rotation.rate", self.rate)
        return {"rotation": {"rate": rate, "centre": vector("initial.centre", self.centre)}}


@dataclass(frozen=True, kw_only=True)
class Wave:
    """``constant + amplitude cos(2 pi wave_number . x + phase)``.

    Args:
        amplitude: largest deviation from the mean, shape (3,).
        wave_number: waves per length along x, y, z, shape (3,).
        constant: mean value, shape (3,).
        phase: phase (rad).
    """

    amplitude: Vector
    wave_number: Vector
    constant: Vector = (0.0, 0.0, 0.0)
    phase: float = 0.0

    def _as_table(self) -> Table:
        table: Table = {
            key: vector(f"initial.wave.{key}", getattr(self, key))
            for key in ("constant", "amplitude", "wave_number")
        }
        return {"wave": table | {"phase": float(self.phase)}}


@dataclass(frozen=True, kw_only=True)
class FreeBeam:
    """A bending mode of a slender beam with free ends.

    Sections move across the beam and turn with it.

    Args:
        start: centre of one end (m), shape (3,).
        end: centre of the other end (m), shape (3,).
        amplitude: value at the start, the largest, across the beam, shape (3,).
        number: number of the mode, 1 (the slowest) to 20.
    """

    start: Vector
    end: Vector
    amplitude: Vector
    number: int = 1

    def _as_table(self) -> Table:
        table: Table = {
            "start": vector("initial.free_beam.start", self.start),
            "end": vector("initial.free_beam.end", self.end),
            "amplitude": vector("initial.free_beam.amplitude", self.amplitude),
        }
        return {"free_beam": table | {"number": int(self.number)}}


Function: TypeAlias = Callable[[npt.NDArray[np.float64]], npt.NDArray[Any]]
Field: TypeAlias = Vector | Affine | Rotation | Wave | FreeBeam | Function
"""Everything that describes initial values."""


def table_of(key: str, field: Field | None) -> Table | None:
    """The table of a field that has words in a scenario file."""
    if field is None or callable(field):
        return None
    if isinstance(field, Affine | Rotation | Wave | FreeBeam):
        return field._as_table()
    return {"constant": vector(key, field)}


def function_of(field: Field | None) -> Function | None:
    """The field if it is a function."""
    return field if callable(field) else None
