"""Parts of the body that are held or moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from rsph._scenario import Table, Vector, check, vector, without_none
from rsph.loads import Curve
from rsph.regions import Region

__all__ = ["Boundary", "Clamp", "Follow", "Foundation", "Oscillation", "Prescribed", "RampTo"]

Component: TypeAlias = Literal["x", "y", "z", "normal"]


@dataclass(frozen=True, kw_only=True)
class Boundary:
    """A part of the body whose motion is known; use :class:`Clamp` or :class:`Prescribed`.

    Args:
        region: where. A half-space holds the face of the body on its plane; where it holds all
            components, or the normal one, a body that reaches beyond is cut there. Any other region
            holds the particles in it or, if there are none, the part of the surface in it.
        fix: the components held, all of them by default. ``["normal"]`` holds the one along the
            normal of the surface: a roller or a plane of symmetry.
        name: what it carries is called by: probes and histories get ``<name>_force_x``, ``_y`` and
            ``_z``, the force on the body (N), ``<name>_moment_x`` and so on (N m), and where it
            moves ``<name>_displacement_x`` and so on (m).
        moment_about: the point that the moment is about (m), shape (3,); by default the centre of
            what is held, which goes with the boundary.
    """

    region: Region
    fix: Sequence[Component] = ("x", "y", "z")
    name: str | None = None
    moment_about: Vector | None = None

    def __post_init__(self) -> None:
        check("boundary", boundary=[self._as_table()])

    def _as_table(self) -> Table:
        table: Table = {"region": self.region._table, "fix": list(self.fix)}
        about = self.moment_about
        point = None if about is None else vector("boundary.moment_about", about)
        return table | without_none(name=self.name, moment_about=point)


@dataclass(frozen=True, kw_only=True)
class Clamp(Boundary):
    """A part that does not move. ``moment_about`` is a point (m, shape (3,)).

    >>> import rsph
    >>> floor = rsph.regions.plane(axis="z", at=0.0, side="below")
    >>> Clamp(region=floor, fix=["z"])
    Clamp(region=regions.plane(axis='z', at=0.0, side='below'), fix=['z'], name=None,
    moment_about=None)
    """

    def _as_table(self) -> Table:
        return super()._as_table() | {"kind": "clamp"}


@dataclass(frozen=True, kw_only=True)
class RampTo:
    """Moves by ``displacement`` (m, shape (3,)) at constant velocity, then rests.

    Args:
        displacement: where to (m), shape (3,).
        start: begin of the motion (s).
        end: end of the motion (s), later than ``start``.
    """

    displacement: Vector
    start: float = 0.0
    end: float

    def _as_table(self) -> Table:
        displacement = vector("boundary.motion.ramp.displacement", self.displacement)
        return {"ramp": {"displacement": displacement, "from": self.start, "to": self.end}}


@dataclass(frozen=True, kw_only=True)
class Follow:
    """Moves by ``displacement`` (m, shape (3,)) times a curve.

    >>> from rsph.loads import Curve
    >>> there_and_back = Curve(time=[0.0, 1.0, 2.0], value=[0.0, 1.0, 0.0])
    >>> motion = Follow(displacement=(0.0, 0.0, 0.01), curve=there_and_back)

    Args:
        displacement: displacement where the curve is 1 (m), shape (3,).
        curve: its factor in time; without jumps and from 0, unless the solver is static.
    """

    displacement: Vector
    curve: Curve

    def _as_table(self) -> Table:
        displacement = vector("boundary.motion.curve.displacement", self.displacement)
        table = self.curve._table("boundary.motion.curve")
        return {"curve": table | {"displacement": displacement}}


@dataclass(frozen=True, kw_only=True)
class Oscillation:
    """Moves by ``amplitude sin(2 pi frequency t)``.

    Args:
        amplitude: amplitude of the displacement (m), shape (3,).
        frequency: frequency (Hz).
    """

    amplitude: Vector
    frequency: float

    def _as_table(self) -> Table:
        amplitude = vector("boundary.motion.oscillation.amplitude", self.amplitude)
        return {"oscillation": {"amplitude": amplitude, "frequency": self.frequency}}


@dataclass(frozen=True, kw_only=True)
class Prescribed(Boundary):
    """A part that moves in a given way.

    Args:
        region: as for every boundary.
        fix: as for every boundary.
        moment_about: as for every boundary, a point (m), shape (3,).
        motion: a :class:`RampTo`, a :class:`Follow` or an :class:`Oscillation`.
    """

    motion: RampTo | Follow | Oscillation

    def _as_table(self) -> Table:
        table = super()._as_table() | {"kind": "prescribed"}
        return table | {"motion": self.motion._as_table()}


@dataclass(frozen=True, kw_only=True)
class Foundation:
    """Springs between a part of the surface and surroundings that do not move.

    The force per area on the body is ``-(normal n n^T + tangential (1 - n n^T)) u`` with the normal
    n of the undeformed surface. In motion the springs are damped as the material of the body is.

    >>> import rsph
    >>> bed = rsph.regions.plane(axis="z", at=0.0, side="below")
    >>> Foundation(region=bed, normal=1e5).tangential
    0.0

    Args:
        region: where on the surface.
        normal: stiffness along the normal (Pa/m).
        tangential: stiffness across the normal (Pa/m).
    """

    region: Region
    normal: float = 0.0
    tangential: float = 0.0

    def __post_init__(self) -> None:
        check("foundation", foundation=[self._as_table()])

    def _as_table(self) -> Table:
        return {
            "region": self.region._table,
            "normal": self.normal,
            "tangential": self.tangential,
        }
