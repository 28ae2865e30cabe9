"""What pushes or pulls the body.

Every load has a ``ramp`` (from, to) in seconds: it grows from 0 at ``from`` to all of it at ``to``;
equal times switch it on at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rsph._scenario import Table, Vector, check, ramp, vector, without_none
from rsph.regions import Region, everywhere

__all__ = ["BodyForce", "Load", "Patch", "Pressure", "Traction"]


@dataclass(frozen=True, kw_only=True)
class Load:
    """A load; use one of the others of this module."""

    ramp: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        check("load", load=[self._as_table()])

    def _as_table(self) -> Table:
        return {"ramp": ramp("load.ramp", self.ramp)}


@dataclass(frozen=True, kw_only=True)
class Traction(Load):
    """A force per area on the surface inside a region.

    Args:
        region: where on the surface.
        traction: force per area (Pa), shape (3,).
        ramp: times (s) between which it grows.
    """

    region: Region
    traction: Vector

    def _as_table(self) -> Table:
        return super()._as_table() | {
            "kind": "traction",
            "region": self.region._table,
            "traction": vector("load.traction", self.traction),
        }


@dataclass(frozen=True, kw_only=True)
class Pressure(Load):
    """A pressure against the outward normal of the surface inside a region.

    Args:
        region: where on the surface.
        pressure: pressure (Pa); positive pushes inward.
        ramp: times (s) between which it grows.
    """

    region: Region
    pressure: float

    def _as_table(self) -> Table:
        return super()._as_table() | {
            "kind": "pressure",
            "region": self.region._table,
            "pressure": self.pressure,
        }


@dataclass(frozen=True, kw_only=True)
class BodyForce(Load):
    """A force per mass, such as gravity.

    Args:
        acceleration: force per mass (m/s^2), shape (3,).
        region: which part of the body, by default all of it.
        ramp: times (s) between which it grows.
    """

    acceleration: Vector
    region: Region = everywhere

    def _as_table(self) -> Table:
        return super()._as_table() | {
            "kind": "body_force",
            "region": self.region._table,
            "acceleration": vector("load.acceleration", self.acceleration),
        }


@dataclass(frozen=True, kw_only=True)
class Patch(Load):
    """A local push with smooth edges: traction ``pressure exp(-d^2 / radius^2) direction``.

    It acts on the surface that faces against ``direction``; d is the distance from the centre.

    Args:
        pressure: largest pressure (Pa).
        centre: a point on or near the surface (m), shape (3,), or ``"upper-right"`` for the upper
            right part of an organ.
        direction: direction of the push, of any length, shape (3,).
        radius: radius (m); by default 0.15 of the body's extent in x.
        ramp: times (s) between which it grows.
    """

    pressure: float
    centre: Vector | Literal["upper-right"]
    direction: Vector
    radius: float | None = None

    def _as_table(self) -> Table:
        named = isinstance(self.centre, str)
        return super()._as_table() | without_none(
            kind="patch",
            pressure=self.pressure,
            centre=self.centre if named else vector("load.centre", self.centre),
            direction=vector("load.direction", self.direction),
            radius=self.radius,
        )
