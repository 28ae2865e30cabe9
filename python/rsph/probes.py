"""Named readings of a simulation."""

from __future__ import annotations

from dataclasses import dataclass

from rsph._scenario import Table, check
from rsph.regions import Region

__all__ = ["Probe"]


@dataclass(frozen=True, kw_only=True)
class Probe:
    """The mean of a quantity over a part of the body, or its value at a point.

    Args:
        name: names the readings.
        quantity: a field or a component of it: ``"displacement.z"``, ``"velocity"``,
            ``"stress.xy"``, ``"von_mises"``.
        region: where: over its particles if it holds any, else over the surface in it.
    """

    name: str
    quantity: str
    region: Region

    def __post_init__(self) -> None:
        check("probe", probe=[self._as_table()])

    def _as_table(self) -> Table:
        return {"name": self.name, "quantity": self.quantity, "region": self.region._table}
