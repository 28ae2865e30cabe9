"""Ready figures by matplotlib (``pip install rsph[plot]``) and pyvista (``rsph[view]``)."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from rsph.errors import Error, InputError
from rsph.results import Snapshot, Surface

__all__ = ["force_displacement", "history", "image", "polydata", "profile", "strain_map", "surface"]


def history(
    history: Mapping[str, npt.NDArray[np.float64]],
    *,
    probes: Sequence[str] | None = None,
    axes: Any = None,
) -> Any:
    """Plots probes over time.

    Args:
        history: what ``Simulation.run`` or ``Simulation.history`` returns: arrays of shape (S,) by
            name, ``"time"`` (s) first.
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


def force_displacement(
    history: Mapping[str, npt.NDArray[np.float64]],
    *,
    boundary: str,
    component: Literal["x", "y", "z"] | None = None,
    axes: Any = None,
) -> Any:
    """Plots the force of a boundary that moves over its displacement.

    Args:
        history: what ``Simulation.run`` or ``Simulation.history`` returns, or ``Run.history``:
            columns of N readings, shape (N,), forces in N and displacements in m.
        boundary: its name.
        component: which component of both; by default the one that moves farthest.
        axes: matplotlib axes to draw on; by default new ones.

    Returns:
        The axes.

    Raises:
        InputError: no boundary of that name moves.
    """
    moved = {c: history.get(f"{boundary}_displacement_{c}") for c in "xyz"}
    size = {c: float(np.abs(u).max(initial=0.0)) for c, u in moved.items() if u is not None}
    if not size:
        raise InputError(
            f"`boundary`: the history has no displacement of a boundary {boundary!r}",
            key="boundary",
            value=boundary,
            remedy="give the boundary of kind `prescribed` that name",
        )
    along = component if component is not None else max(size, key=lambda c: size[c])
    if axes is None:
        axes = _pyplot().figure(layout="constrained").add_subplot()
    axes.plot(moved[along], history[f"{boundary}_force_{along}"], label=f"{boundary}, {along}")
    axes.set(xlabel="displacement", ylabel="force")
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


def strain_map(
    surface: Surface,
    *,
    field: str = "normal_strain",
    view: Literal["x", "-x", "y", "-y", "z", "-z"] = "z",
    limit: float | None = None,
    exaggerate: float = 1.0,
    axes: Any = None,
    cmap: str | None = None,
) -> Any:
    """Draws a surface as seen from one side, coloured by its strain, as Figs. 6 and 7 of the paper.

    Args:
        surface: of ``Simulation.surface`` or a results file.
        field: ``"normal_strain"``, ``"shear_strain"``, or another field; of a vector its length is
            shown, of a tensor its Frobenius norm.
        view: the axis that points to the viewer; organs have their front at ``"z"`` and up at y.
        limit: the value at the end of the colours; by default the largest of the surface.
        exaggerate: factor on the displacement.
        axes: matplotlib axes to draw on; by default new ones.
        cmap: a colour map of matplotlib; by default one from blue over white to red for fields
            of both signs, else one from light to dark. ``"gray_r"`` prints in black and white.

    Returns:
        The axes.
    """
    pyplot = _pyplot()
    from matplotlib.collections import PolyCollection

    if axes is None:
        axes = pyplot.figure(layout="constrained").add_subplot()
    depth = "xyz".find(view[-1])
    if depth < 0 or view not in (view[-1], f"-{view[-1]}"):
        raise InputError(
            f"`view` = {view!r}: there is no such side",
            key="view",
            value=repr(view),
            remedy='choose "x", "-x", "y", "-y", "z" or "-z"',
        )
    towards = -1.0 if view.startswith("-") else 1.0
    # To the right and up for the viewer, right-handed with the axis towards them.
    right, up = {0: (2, 1), 1: (0, 2), 2: (0, 1)}[depth]
    sign = -towards if depth < 2 else towards
    vertices = surface.vertices + (exaggerate - 1.0) * surface["displacement"]
    corners = vertices[surface.triangles]
    flat = corners[:, :, (right, up)] * (sign, 1.0)
    (ax, ay), (bx, by) = (flat[:, 1] - flat[:, 0]).T, (flat[:, 2] - flat[:, 0]).T
    seen = ax * by - ay * bx > 0.0
    order = np.argsort(towards * corners[seen][:, :, depth].mean(axis=1))
    values = _magnitude(surface[field])[surface.triangles].mean(axis=1)[seen][order]
    signed = bool(values.size) and float(values.min()) < 0.0
    end = limit if limit is not None else float(np.abs(values).max(initial=0.0)) or 1.0
    colours = cmap if cmap is not None else ("RdBu_r" if signed else "viridis_r")
    faces = PolyCollection(flat[seen][order], cmap=colours, edgecolors="face", linewidths=0.2)
    faces.set_array(values)
    faces.set_clim(-end if signed else 0.0, end)
    axes.add_collection(faces)
    axes.autoscale_view()
    names = ("-" if sign < 0.0 else "") + "xyz"[right], "xyz"[up]
    title = f"{field} at t = {surface.time:g}"
    axes.set(aspect="equal", xlabel=names[0], ylabel=names[1], title=title)
    axes.figure.colorbar(faces, ax=axes, label=field, shrink=0.7)
    return axes


def polydata(surface: Surface) -> Any:
    """A surface as ``pyvista.PolyData`` with all its fields on the points (needs pyvista).

    Args:
        surface: of ``Simulation.surface`` or a results file.
    """
    mesh = _pyvista().PolyData.from_regular_faces(surface.vertices, surface.triangles)
    for name, values in surface.fields.items():
        mesh.point_data[name] = values
    return mesh


def image(
    surface: Surface,
    *,
    field: str = "normal_strain",
    exaggerate: float = 1.0,
    size: tuple[int, int] = (800, 600),
    cmap: str = "viridis",
    path: str | os.PathLike[str] | None = None,
) -> npt.NDArray[np.uint8]:
    """A picture of a surface in space by pyvista, off-screen.

    Args:
        surface: of ``Simulation.surface`` or a results file.
        field: which colours it; of a vector its length, of a tensor its Frobenius norm.
        exaggerate: factor on the displacement.
        size: width and height in pixels.
        cmap: a colour map of matplotlib.
        path: also write it here, as PNG.

    Returns:
        The picture, shape (height, width, 3), for ``matplotlib.pyplot.imshow`` or a notebook.
    """
    pyvista = _pyvista()
    mesh = polydata(surface)
    mesh.points += (exaggerate - 1.0) * surface["displacement"]
    mesh.point_data[field] = _magnitude(surface[field])
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    try:
        plotter.add_mesh(mesh, scalars=field, cmap=cmap, smooth_shading=True)
        plotter.view_xy()
        plotter.camera.azimuth = 20.0
        plotter.camera.elevation = 20.0
        picture = plotter.screenshot(os.fspath(path) if path is not None else None)
    finally:
        plotter.close()
    pixels: npt.NDArray[np.uint8] = np.asarray(picture)
    return pixels


def _magnitude(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    if values.ndim == 1:
        return values
    # XY, YZ and XZ occur twice in a symmetric tensor.
    weight = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])[: values.shape[1]]
    length: npt.NDArray[np.float64] = np.sqrt((weight * values**2).sum(axis=1))
    return length


def _pyvista() -> Any:
    try:
        import pyvista
    except ImportError as e:
        raise Error("this needs pyvista; install it with `pip install rsph[view]`") from e
    return pyvista


def _pyplot() -> Any:
    try:
        from matplotlib import pyplot
    except ImportError as e:
        raise Error("plots need matplotlib; install it with `pip install rsph[plot]`") from e
    return pyplot
