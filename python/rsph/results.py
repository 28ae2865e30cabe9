"""What a simulation gives: moments, surfaces, and the files of a run's folder.

Symmetric tensors have six components in the order XX YY ZZ XY YZ XZ, matrices nine, row by row;
principal values have three, the largest first.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
import numpy.typing as npt

from rsph import _rsph
from rsph.errors import Error, InputError, MissingFieldError

if TYPE_CHECKING:
    from rsph.scenario import Scenario

__all__ = ["ParticleFrame", "Results", "Run", "Snapshot", "Surface", "read"]

Array = npt.NDArray[np.float64]


class Snapshot:
    """One moment of a simulation, with read-only arrays that are not copied.

    It stays as it is when the simulation goes on. Every field is an item, those of every simulation
    are attributes too: ``snapshot.stress`` is ``snapshot["stress"]``. Made by
    :meth:`rsph.Simulation.snapshot`.
    """

    def __init__(self, snapshot: _rsph.Snapshot) -> None:
        self._snapshot = snapshot

    @property
    def time(self) -> float:
        """Simulated time (s)."""
        return self._snapshot.time

    @property
    def step(self) -> int:
        """Number of time steps taken."""
        return self._snapshot.step

    @property
    def fields(self) -> list[str]:
        """Names of the fields that are there."""
        return self._snapshot.names()

    @property
    def positions(self) -> Array:
        """Current positions x = X + u (m), shape (N, 3); computed anew at each use."""
        return self._snapshot.positions()

    @property
    def reference(self) -> Array:
        """Positions X in the undeformed body (m), shape (N, 3)."""
        return self["reference"]

    @property
    def displacement(self) -> Array:
        """Displacement u (m), shape (N, 3)."""
        return self["displacement"]

    @property
    def velocity(self) -> Array:
        """Velocity v (m/s), shape (N, 3)."""
        return self["velocity"]

    @property
    def mass(self) -> Array:
        """Mass (kg), shape (N,)."""
        return self["mass"]

    @property
    def volume(self) -> Array:
        """Volume in the undeformed body (m^3), shape (N,)."""
        return self["volume"]

    @property
    def density(self) -> Array:
        """Density (kg/m^3), shape (N,)."""
        return self["density"]

    @property
    def strain(self) -> Array:
        """Strain, shape (N, 6): XX YY ZZ XY YZ XZ."""
        return self["strain"]

    @property
    def stress(self) -> Array:
        """Stress (Pa), shape (N, 6): XX YY ZZ XY YZ XZ."""
        return self["stress"]

    @property
    def level_set(self) -> Array:
        """Signed distance to the undeformed surface (m), negative inside, shape (N,)."""
        return self["level_set"]

    @property
    def von_mises(self) -> Array:
        """Von Mises' equivalent stress (Pa), shape (N,)."""
        return self["von_mises"]

    def to_nifti(
        self,
        path: str | os.PathLike[str],
        *,
        like: str | os.PathLike[str],
        field: str = "displacement",
        scale: float | None = None,
        axes: Literal["image", "organ"] = "image",
        outside: float = 0.0,
    ) -> None:
        """Writes a field on the voxels of a CT or MR image, as :meth:`Run.to_nifti` does.

        Args:
            path: NIfTI file; compressed if its name ends with ``.gz``.
            like: the image whose voxels are taken, a NIfTI file.
            field: a field or a component of it: ``"displacement"``, ``"strain"``, ``"stress.zz"``.
            scale: factor from the units of the image to those of the body; by default to metres, as
                its header says. As given to :class:`rsph.shapes.LabelMap`.
            axes: the same.
            outside: value of the voxels outside the body.
        """
        self._snapshot.to_nifti(
            os.fspath(path), field, os.fspath(like), scale, axes, float(outside)
        )

    def __getitem__(self, field: str) -> Array:
        column = self._snapshot.column(field)
        if column is None:
            raise _missing(field, self.fields)
        return column

    def __len__(self) -> int:
        return len(self._snapshot)

    def __repr__(self) -> str:
        fields = ", ".join(self.fields)
        return f"<Snapshot at t = {self.time:g}: {len(self)} particles with {fields}>"


@dataclass(frozen=True, repr=False)
class _Frame:
    time: float
    fields: Mapping[str, Array]

    def __getitem__(self, field: str) -> Array:
        try:
            return self.fields[field]
        except KeyError:
            raise _missing(field, self.fields) from None


@dataclass(frozen=True, repr=False)
class Surface(_Frame):
    """The deformed surface of one moment.

    Attributes:
        time: simulated time (s).
        fields: values on the vertices by name, shapes (V,), (V, 3), (V, 6), (V, 9);
            ``surface["strain"]`` is ``surface.fields["strain"]``. ``normal_strain`` is n.e.n,
            ``shear_strain`` is |e n - (n.e.n) n|.
        vertices: current positions (m), shape (V, 3).
        triangles: vertex indices, outward, shape (T, 3).
    """

    vertices: Array
    triangles: npt.NDArray[np.uint32]

    def __repr__(self) -> str:
        return (
            f"<Surface at t = {self.time:g}: {len(self.vertices)} vertices, "
            f"{len(self.triangles)} triangles with {', '.join(self.fields)}>"
        )


@dataclass(frozen=True, repr=False)
class ParticleFrame(_Frame):
    """The particles of one stored moment.

    Attributes:
        time: simulated time (s).
        fields: values by name, shapes (N,), (N, 3), (N, 6), (N, 9); ``frame["strain"]`` is
            ``frame.fields["strain"]``.
        positions: current positions (m), shape (N, 3).
    """

    positions: Array

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        fields = ", ".join(self.fields)
        return f"<ParticleFrame at t = {self.time:g}: {len(self)} particles with {fields}>"


class Results(Sequence["ParticleFrame | Surface"]):
    """A results file as a sequence of its frames; each is read when it is asked for.

    ``results[-1]`` is the last frame: a :class:`ParticleFrame`, or a :class:`Surface` for a
    ``surface.vtkhdf``. ``results["stress"]`` is one field at all times. Made by :func:`rsph.read`.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._path = os.fspath(path)
        info = _rsph.describe_results(self._path)
        self._times = np.array(info["times"], dtype=np.float64)
        self._fields: dict[str, int] = info["fields"]
        self._points: list[int] = info["points"]

    @property
    def times(self) -> Array:
        """Times of the frames (s), shape (F,)."""
        return self._times

    @property
    def fields(self) -> dict[str, int]:
        """Number of components of each field by name."""
        return dict(self._fields)

    @property
    def points(self) -> npt.NDArray[np.int64]:
        """Number of particles or vertices in each frame, shape (F,)."""
        return np.array(self._points, dtype=np.int64)

    def field(self, name: str, frame: int) -> Array:
        """One field of one frame, without reading the others: shape (N,), (N, 3) or (N, 6).

        Raises:
            MissingFieldError: the file does not hold it.
        """
        if name not in self._fields:
            raise _missing(name, self._fields)
        array: Array = _rsph.read_field(self._path, self._frame(frame), name)
        return array

    def to_xarray(self) -> Any:
        """All fields as an ``xarray.Dataset`` (``pip install rsph[xarray]``), read when used.

        Dimensions ``time``, ``point`` and ``component`` (x y z) or ``tensor`` (xx yy zz xy yz xz).

        Raises:
            Error: the number of points changes in time, as remeshing makes it.
        """
        from rsph._lazy import dataset

        return dataset(self)

    def __len__(self) -> int:
        return len(self._times)

    @overload
    def __getitem__(self, index: int) -> ParticleFrame | Surface: ...
    @overload
    def __getitem__(self, index: slice) -> list[ParticleFrame | Surface]: ...
    @overload
    def __getitem__(self, index: str) -> Array: ...
    def __getitem__(
        self, index: int | slice | str
    ) -> ParticleFrame | Surface | list[ParticleFrame | Surface] | Array:
        if isinstance(index, str):
            self._steady()
            return np.stack([self.field(index, k) for k in range(len(self))])
        if isinstance(index, slice):
            return [self._read(k) for k in range(*index.indices(len(self)))]
        return self._read(self._frame(index))

    def _frame(self, index: int) -> int:
        k = index + len(self) if index < 0 else index
        if not 0 <= k < len(self):
            raise IndexError(f"{self._path} has {len(self)} frames, there is no frame {index}")
        return k

    def _steady(self) -> int:
        """The number of points of every frame."""
        if len(set(self._points)) != 1:
            raise Error(
                f"{self._path}: the number of points changes in time; take the frames one by one"
            )
        return self._points[0]

    def __iter__(self) -> Iterator[ParticleFrame | Surface]:
        return (self._read(k) for k in range(len(self)))

    def _read(self, step: int) -> ParticleFrame | Surface:
        frame: dict[str, Any] = _rsph.read_frame(self._path, step)
        time, fields, points = frame["time"], frame["fields"], frame["points"]
        if frame["triangles"] is None:
            return ParticleFrame(time, fields, points)
        return Surface(time, fields, points, frame["triangles"])

    def __repr__(self) -> str:
        span = f" from t = {self._times[0]:g} to {self._times[-1]:g}" if len(self) else ""
        return f"<Results {self._path}: {len(self)} frames{span} with {', '.join(self._fields)}>"


class Run:
    """The folder of a run, whose files are read when they are asked for; see :func:`rsph.read`."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._path = Path(path)

    @property
    def path(self) -> Path:
        """The folder."""
        return self._path

    @property
    def particles(self) -> Results:
        """The particles, frame by frame."""
        return Results(self._file("particles.vtkhdf"))

    @property
    def surface(self) -> Results:
        """The surface, frame by frame."""
        return Results(self._file("surface.vtkhdf"))

    @property
    def history(self) -> dict[str, Array]:
        """The readings of the probes, arrays of shape (S,) by name, ``"time"`` (s) first."""
        with self._file("probes.csv").open(newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        # A run that goes on may have half a row at the end.
        values = [[float(x) for x in row] for row in rows if len(row) == len(header)]
        table = np.array(values, dtype=np.float64).reshape(-1, len(header))
        return {name: table[:, i] for i, name in enumerate(header)}

    @property
    def summary(self) -> dict[str, Any]:
        """What ``summary.json`` says: particles, steps, wall time, energies, errors, notes."""
        summary: dict[str, Any] = json.loads(self._file("summary.json").read_text(encoding="utf-8"))
        return summary

    @property
    def scenario(self) -> Scenario:
        """The scenario as run."""
        from rsph.scenario import Scenario

        return Scenario.from_toml(self._file("scenario.toml"))

    def to_nifti(
        self,
        path: str | os.PathLike[str],
        *,
        like: str | os.PathLike[str],
        field: str = "displacement",
        frame: int = -1,
        outside: float = 0.0,
    ) -> None:
        """Writes a field of the particles on the voxels of a CT or MR image, for overlay on it.

        The field is shown on the undeformed body, where the image shows it, with the scale and the
        axes of the scenario's label map, if it has one. A displacement is a displacement field
        (NIfTI intent 1006) in the units and along the axes of the image.

        Args:
            path: NIfTI file; compressed if its name ends with ``.gz``.
            like: the image whose voxels are taken, a NIfTI file.
            field: a field or a component of it: ``"displacement"``, ``"strain"``, ``"stress.zz"``.
            frame: which moment.
            outside: value of the voxels outside the body, for example ``float("nan")``.

        Raises:
            InputError: a field that is not there, or an image on which the body is not.
        """
        _rsph.frame_to_nifti(
            os.fspath(self._path),
            self.particles._frame(frame),
            os.fspath(path),
            field,
            os.fspath(like),
            float(outside),
        )

    def _file(self, name: str) -> Path:
        path = self._path / name
        if not path.is_file():
            raise InputError(
                f"{self._path}: has no {name}",
                key="path",
                value=str(self._path),
                remedy="give the folder of a run, or a particles.vtkhdf or surface.vtkhdf",
            )
        return path

    def __repr__(self) -> str:
        return f"<Run {self._path}>"


def read(path: str | os.PathLike[str]) -> Any:
    """Opens the folder of a run, or a ``particles.vtkhdf`` or ``surface.vtkhdf`` in it.

    Returns:
        A :class:`Run` for a folder, else :class:`Results`.

    Raises:
        InputError: it cannot be read, or is something else.
    """
    if not os.path.isdir(path):
        return Results(path)
    run = Run(path)
    run._file("scenario.toml")
    return run


def _missing(field: str, present: object) -> MissingFieldError:
    names = ", ".join(present) if isinstance(present, list | Mapping) else ""
    return MissingFieldError(
        f"there is no field `{field}`", key=field, remedy=f"there are: {names}"
    )
