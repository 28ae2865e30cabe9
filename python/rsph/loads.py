"""What pushes or pulls the body.

Every load but :class:`Custom` has a ``ramp`` (from, to) in seconds: it grows from 0 at ``from`` to
all of it at ``to``; equal times switch it on at once. Or it has a :class:`Curve`, which may come in
its place.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from rsph._scenario import Table, Vector, check, curve, ramp, vector, without_none
from rsph.errors import InputError
from rsph.regions import Region, everywhere

__all__ = [
    "BodyForce",
    "Curve",
    "Custom",
    "FollowerPressure",
    "Load",
    "Patch",
    "Points",
    "Pressure",
    "Traction",
]

Array: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Curve:
    """The factor of a load in time, by points.

    >>> beat = Curve(time=[0.0, 0.3, 0.8], value=[0.0, 1.0, 0.0], kind="smooth", periodic=True)

    Args:
        time: times of the points (s), ascending, shape (N,).
        value: factors at these times, shape (N,).
        kind: from one point to the next along a straight line (``"linear"``), not at all until the
            time of the next one (``"step"``), or by monotone cubics with a continuous rate
            (``"smooth"``).
        periodic: whether what it does between the first and the last time repeats for ever;
            otherwise it is constant outside.
    """

    time: npt.ArrayLike
    value: npt.ArrayLike
    kind: Literal["linear", "step", "smooth"] = "linear"
    periodic: bool = False

    def _table(self, key: str) -> Table:
        return curve(key, self.time, self.value, self.kind, self.periodic)


@dataclass(frozen=True, kw_only=True)
class Load:
    """A load; use one of the others of this module."""

    ramp: tuple[float, float] | None = None
    curve: Curve | None = None

    def __post_init__(self) -> None:
        check("load", load=[self._as_table()])

    def _as_table(self) -> Table:
        return without_none(
            ramp=None if self.ramp is None else ramp("load.ramp", self.ramp),
            curve=None if self.curve is None else self.curve._table("load.curve"),
        )


@dataclass(frozen=True, kw_only=True)
class Traction(Load):
    """A force per area on the surface inside a region.

    Args:
        region: where on the surface.
        traction: force per area (Pa), shape (3,).
        ramp: times (s) between which it grows; by default it is there from the start.
        curve: its factor in time, in the place of ``ramp``.
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
        ramp: times (s) between which it grows; by default it is there from the start.
        curve: its factor in time, in the place of ``ramp``.
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
class FollowerPressure(Pressure):
    """A pressure that follows the deformed surface: against the normal and on the area that it has.

    It needs a law for any strain. :class:`Pressure` is a dead load instead, with the normal and the
    area of the undeformed surface.

    Args:
        region: where on the undeformed surface.
        pressure: pressure (Pa); positive pushes inward.
        ramp: times (s) between which it grows; by default it is there from the start.
        curve: its factor in time, in the place of ``ramp``.
    """

    def _as_table(self) -> Table:
        return super()._as_table() | {"kind": "follower_pressure"}


@dataclass(frozen=True, kw_only=True)
class BodyForce(Load):
    """A force per mass, such as gravity.

    Args:
        acceleration: force per mass (m/s^2), shape (3,).
        region: which part of the body, by default all of it.
        ramp: times (s) between which it grows; by default it is there from the start.
        curve: its factor in time, in the place of ``ramp``.
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
        ramp: times (s) between which it grows; by default it is there from the start.
        curve: its factor in time, in the place of ``ramp``.
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


@dataclass(frozen=True)
class Points:
    """Where a :class:`Custom` load acts, and how these points move, at one moment.

    Attributes:
        time: simulated time (s).
        reference: positions X in the undeformed body (m), shape (P, 3).
        displacement: displacement u (m), shape (P, 3).
        velocity: velocity v (m/s), shape (P, 3).
        normals: on the surface, outward unit normals of the undeformed body, shape (P, 3).
        areas: on the surface, the share of the undeformed area of each point (m^2), shape (P,).
        mass: of particles (kg), shape (P,).
        volume: of particles, in the undeformed body (m^3), shape (P,).
    """

    time: float
    reference: Array
    displacement: Array
    velocity: Array
    normals: Array | None = None
    areas: Array | None = None
    mass: Array | None = None
    volume: Array | None = None

    @property
    def positions(self) -> Array:
        """Current positions x = X + u (m), shape (P, 3)."""
        x: Array = self.reference + self.displacement
        return x


Function: TypeAlias = Callable[[float, Points], npt.ArrayLike]


@dataclass(frozen=True)
class Custom:
    """A load that a Python function computes, called once before every time step.

    The forces stay as they are during the step: with time steps that are long against their change
    the error is of first order. ``Simulation.solve_static`` calls it once, for the time of the
    equilibrium and the displacement from before.

    >>> def wind(time, points):
    ...     facing = np.maximum(-points.normals[:, 0], 0.0)
    ...     return 100.0 * np.sin(time) * (facing * points.areas)[:, None] * [1.0, 0.0, 0.0]
    >>> load = Custom(wind)

    Args:
        function: called with the time (s) and the :class:`Points`; returns the force (N) on each of
            them, shape (P, 3).
        on: ``"surface"`` for points all over the surface, about half a spacing apart, whose forces
            go to the particles around them with resultant and moment kept; ``"particles"`` for the
            particles themselves.
    """

    function: Function
    on: Literal["surface", "particles"] = "surface"

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InputError(
                f"`load.function` = {self.function!r}: is no function",
                key="load.function",
                value=repr(self.function),
                remedy="give a function of the time and the points that returns forces (N)",
            )
        if self.on not in ("surface", "particles"):
            raise InputError(
                f'`load.on` = {self.on!r}: must be "surface" or "particles"',
                key="load.on",
                value=repr(self.on),
                remedy='"surface" for contact and pressure, "particles" for forces in the body',
            )

    def _call(self, time: float, columns: dict[str, Any]) -> npt.ArrayLike:
        return self.function(time, Points(time, **columns))
