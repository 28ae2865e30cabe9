"""What a run stores is what VTK reads: points, cells, fields and the time axis.

Takes the folder of a finished run: ``pytest tests/python/test_vtkhdf.py --run FOLDER``, or the
environment variable ``RSPH_RUN``.
"""

import csv
import json
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
import pyvista
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOHDF import vtkHDFReader

COMPONENTS = {
    "displacement": 3,
    "velocity": 3,
    "mass": 1,
    "volume": 1,
    "density": 1,
    "strain": 6,
    "stress": 6,
    "level_set": 1,
    "von_mises": 1,
    "normal_strain": 1,
    "shear_strain": 1,
}


@pytest.fixture(params=["particles.vtkhdf", "surface.vtkhdf"])
def stored(request: pytest.FixtureRequest, run: Path) -> Path:
    return run / request.param


def times_of(path: Path) -> list[float]:
    """The time axis that VTK sees."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    return list(reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()))


def frames(path: Path) -> Iterator[tuple[int, float, pyvista.PolyData]]:
    """The frames that VTK sees, one after the other, asked for by their time."""
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    for k, time in enumerate(times_of(path)):
        reader.UpdateTimeStep(time)
        mesh = pyvista.wrap(reader.GetOutputDataObject(0)).copy()
        yield k, time, mesh


def rows(group: h5py.Group, step: int, name: str) -> np.ndarray:
    """The rows of a point array that belong to one step, straight from HDF5."""
    count = group["NumberOfPoints"][group["Steps/PartOffsets"][step]]
    if name == "Points":
        start = group["Steps/PointOffsets"][step]
        return group["Points"][start : start + count]
    start = group["Steps/PointDataOffsets"][name][step]
    return group["PointData"][name][start : start + count]


def test_times_increase_from_zero_to_the_end(stored: Path, run: Path) -> None:
    times = times_of(stored)
    summary = json.loads((run / "summary.json").read_text())
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(summary["time"])
    assert times == sorted(set(times))
    assert len(times) == summary["frames"]


def test_points_and_fields_are_those_of_every_step(stored: Path) -> None:
    with h5py.File(stored) as file:
        group = file["VTKHDF"]
        seen = 0
        for k, time, mesh in frames(stored):
            assert group["Steps/Values"][k] == time
            assert np.array_equal(np.asarray(mesh.points), rows(group, k, "Points"))
            assert set(mesh.point_data) == set(group["PointData"])
            for name, values in mesh.point_data.items():
                shape = (mesh.n_points,) + ((COMPONENTS[name],) if COMPONENTS[name] > 1 else ())
                assert values.shape == shape, name
                assert np.array_equal(values, rows(group, k, name), equal_nan=True), name
            seen += 1
        assert seen == group["Steps"].attrs["NSteps"] > 0


def test_pyvista_reads_the_file_by_its_name(stored: Path) -> None:
    mesh = pyvista.read(stored)
    with h5py.File(stored) as file:
        counts = file["VTKHDF/NumberOfPoints"][:]
    assert isinstance(mesh, pyvista.PolyData)
    assert mesh.n_points in counts


def test_particles_are_vertices_with_positive_mass(run: Path) -> None:
    for _, _, mesh in frames(run / "particles.vtkhdf"):
        assert mesh.n_cells == mesh.n_verts == mesh.n_points > 0
        assert np.array_equal(mesh.verts.reshape(-1, 2)[:, 1], np.arange(mesh.n_points))
        assert (mesh["mass"] > 0).all()
        assert (mesh["volume"] > 0).all()


def test_the_surface_is_closed_and_turned_outwards(run: Path) -> None:
    for _, _, mesh in frames(run / "surface.vtkhdf"):
        assert mesh.n_cells > 0
        assert mesh.n_verts == mesh.n_lines == 0
        assert mesh.is_all_triangles
        assert mesh.n_open_edges == 0
        corners = np.asarray(mesh.points)[mesh.regular_faces]
        volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
        assert volume > 0


def test_volumes_of_particles_and_surface_agree_at_the_start(run: Path) -> None:
    _, _, particles = next(frames(run / "particles.vtkhdf"))
    _, _, surface = next(frames(run / "surface.vtkhdf"))
    assert particles["volume"].sum() == pytest.approx(surface.volume, rel=0.2)


def test_probes_and_summary_belong_to_the_run(run: Path) -> None:
    with (run / "probes.csv").open(newline="") as file:
        header, *samples = list(csv.reader(file))
    assert header[0] == "time"
    assert samples
    table = np.array(samples, dtype=float)
    assert table.shape[1] == len(header)
    assert (np.diff(table[:, 0]) > 0).all()
    summary = json.loads((run / "summary.json").read_text())
    assert set(summary["energy"]) == {"kinetic", "elastic", "external_work", "dissipated", "error"}
    assert summary["status"] == "finished"
