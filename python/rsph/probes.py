"""Named readings of a simulation."""

from __future__ import annotations

from dataclasses import dataclass

from rsph._scenario import Table, Vector, check, vector
from rsph.regions import Region

__all__ = ["Gauge", "Probe"]


@dataclass(frozen=True, kw_only=True)
class Probe:
    """The mean of a quantity over a part of the body, or its value at a point.

    Args:
        name: names the readings.
        quantity: a field or a component of it: ``"displacement.z"``, ``"velocity"``,
            ``"stress.xy"``, ``"principal_strain.1"``, ``"von_mises"``.
        region: where: over its particles if it holds any, else over the surface in it.
    """

    name: str
    quantity: str
    region: Region

    def __post_init__(self) -> None:
        check("probe", probe=[self._as_table()])

    def _as_table(self) -> Table:
        return {"name": self.name, "quantity": self.quantity, "region": self.region._table}


@dataclass(frozen=True, kw_only=True)
class Gauge:
    """A strain gauge between two points of a solid.

    It reads ``<name>_strain``, the change of their distance over the undeformed one, and
    ``<name>_length`` (m).

    Args:
        name: names the readings.
        start: one end, on the undeformed body or in it (m), shape (3,).
        end: the other end (m), shape (3,).
    """

    name: str
    start: Vector
    end: Vector

    def __post_init__(self) -> None:
        check("gauge", gauge=[self._as_table()])

    def _as_table(self) -> Table:
        start, end = vector("gauge.from", self.start), vector("gauge.to", self.end)
        return {"name": self.name, "from": start, "to": end}
