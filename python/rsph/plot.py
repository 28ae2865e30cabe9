"""Quick plots by matplotlib: ``pip install rsph[plot]``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from rsph.errors import Error
from rsph.results import Snapshot, Surface

__all__ = ["history", "profile", "surface"]


def history(
    history: Mapping[str, npt.NDArray[np.float64]],
    *,
    probes: Sequence[str] | None = None,
    axes: Any = None,
) -> Any:
    """Plots probes over time.

    Args:
        history: what ``Simulation.run`` or ``Simulation.history`` returns.
        probes: which of them; by default all.
        axes: matplotlib axes to draw on; by default new ones.

    Returns:
        The axes.
    """
    if axes is None:
        axes = _pyplot().figure(layout="constrained").add_subplot()
    for name in probes if probes is not None else [k for k in history if k != "time"]:
        axes.plot(history["time"], history[name], label=name)
    axes.set_xlabel("time")
    axes.legend()
    return axes


def profile(
    snapshot: Snapshot,
    *,
    field: str = "velocity",
    axes: Any = None,
) -> Any:
    """Draws a field over x for particles on a line: fluid dashed, solid full, as in Fig. 4.

    Args:
        snapshot: of a fluid beside a solid.
        field: which; of a vector or tensor its first component is shown.
        axes: matplotlib axes to draw on; by default new ones.

    Returns:
        The axes.
    """
    if axes is None:
        axes = _pyplot().figure(layout="constrained").add_subplot()
    x = snapshot.positions[:, 0]
    values = snapshot[field]
    values = values if values.ndim == 1 else values[:, 0]
    fluid, solid = snapshot["colour"] > 0.0, snapshot["colour"] < 1.0
    colour = axes.plot(x[fluid], values[fluid], "--", label=f"t = {snapshot.time:g}, fluid")[
        0
    ].get_color()
    axes.plot(x[solid], values[solid], "-", color=colour, label=f"t = {snapshot.time:g}, solid")
    axes.set(xlabel="x", ylabel=field)
    axes.legend()
    return axes


def surface(
    surface: Surface,
    *,
    field: str = "displacement",
    exaggerate: float = 1.0,
    axes: Any = None,
    cmap: str = "viridis",
) -> Any:
    """Draws a surface coloured by a field.

    Args:
        surface: of ``Simulation.surface`` or a results file.
        field: which; of a vector its length is shown, of a tensor its Frobenius norm.
        exaggerate: factor on the displacement.
        axes: matplotlib 3D axes to draw on; by default new ones.
        cmap: a colour map of matplotlib.

    Returns:
        The axes.
    """
    pyplot = _pyplot()
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    if axes is None:
        axes = pyplot.figure(layout="constrained").add_subplot(projection="3d")
    vertices = surface.vertices + (exaggerate - 1.0) * surface["displacement"]
    faces = Poly3DCollection(vertices[surface.triangles], cmap=cmap)
    faces.set_array(_magnitude(surface[field])[surface.triangles].mean(axis=1))
    axes.add_collection3d(faces)
    lower, upper = vertices.min(axis=0), vertices.max(axis=0)
    axes.set(**{f"{c}lim": (lower[i], upper[i]) for i, c in enumerate("xyz")})
    axes.set_box_aspect(upper - lower)
    axes.set(xlabel="x", ylabel="y", zlabel="z", title=f"{field} at t = {surface.time:g}")
    axes.figure.colorbar(faces, ax=axes, label=field, shrink=0.7)
    return axes


def _magnitude(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    if values.ndim == 1:
        return values
    # XY, YZ and XZ occur twice in a symmetric tensor.
    weight = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])[: values.shape[1]]
    length: npt.NDArray[np.float64] = np.sqrt((weight * values**2).sum(axis=1))
    return length


def _pyplot() -> Any:
    try:
        from matplotlib import pyplot
    except ImportError as e:
        raise Error("plots need matplotlib; install it with `pip install rsph[plot]`") from e
    return pyplot
