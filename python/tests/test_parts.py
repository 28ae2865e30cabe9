"""Shapes, regions, materials, results files and plots."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import rsph
from rsph import regions, shapes

from conftest import BOTTOM, ROOT, TOP, cube, pulled

CUBE_TRIANGLES = shapes.Box(size=(1, 1, 1)).triangles
CUBE_VERTICES = shapes.Box(size=(1, 1, 1)).vertices


def test_shapes_know_their_volume_and_bounds():
    box = shapes.Box(size=(1, 2, 3), corner=(1, 1, 1))
    assert box.volume == pytest.approx(6)
    assert box.bounds.tolist() == [[1, 1, 1], [2, 3, 4]]
    assert "box" in repr(box)
    assert shapes.Sphere(radius=1).volume == pytest.approx(4 / 3 * np.pi, rel=2e-3)
    assert shapes.Cylinder(radius=1, height=2, axis="x").volume == pytest.approx(
        2 * np.pi, rel=2e-3
    )
    distances = box.signed_distance([[1.5, 2, 2], [0, 2, 2]])
    assert distances == pytest.approx([-0.5, 1])


@pytest.mark.parametrize("name", shapes.organs())
def test_organs_have_the_size_of_an_adults(name):
    organ = shapes.Organ(name)
    assert 1e-4 < organ.volume < 2e-3
    assert np.ptp(organ.bounds, axis=0).ravel().max() < 0.3


def test_a_mesh_from_arrays_is_a_body():
    mesh = shapes.Mesh(vertices=CUBE_VERTICES, triangles=CUBE_TRIANGLES, scale=2.0)
    assert mesh.volume == pytest.approx(8)
    sim = cube(shape=mesh, spacing=0.4)
    assert sim.particles == 125


def test_a_flipped_mesh_is_turned_with_a_warning():
    with pytest.warns(rsph.RsphWarning, match="inside out"):
        mesh = shapes.Mesh(vertices=CUBE_VERTICES, triangles=CUBE_TRIANGLES[:, ::-1])
    assert mesh.volume == pytest.approx(1)


def test_broken_meshes_are_refused():
    def refused(vertices, triangles):
        with pytest.raises(rsph.InputError) as e:
            shapes.Mesh(vertices=vertices, triangles=triangles)
        return str(e.value)

    assert "its size is 0.000e0" in refused(CUBE_VERTICES, CUBE_TRIANGLES[:2])
    assert "too wide" in refused(CUBE_VERTICES, CUBE_TRIANGLES[:8])
    assert "-1" in refused(CUBE_VERTICES, CUBE_TRIANGLES.astype(int) - 1)
    assert "not there" in refused(CUBE_VERTICES, CUBE_TRIANGLES + 1)
    assert "shape" in refused(CUBE_VERTICES.T, CUBE_TRIANGLES)
    assert "finite" in refused(np.where(CUBE_VERTICES == 1, np.nan, 0), CUBE_TRIANGLES)
    assert "indices" in refused(CUBE_VERTICES, CUBE_TRIANGLES + 0.5)


def test_an_open_mesh_becomes_a_body_and_says_how_sure_it_is():
    with pytest.warns(rsph.RsphWarning, match="uncertain"):
        mesh = shapes.Mesh(vertices=CUBE_VERTICES, triangles=CUBE_TRIANGLES[1:])
    assert mesh.volume == pytest.approx(1, abs=0.02)
    assert mesh.repair is not None
    assert mesh.repair["open_edges"] == 3
    assert 0 < mesh.repair["uncertain"] < 0.2
    assert mesh.repair["made_up"] == pytest.approx(1 / 12, abs=0.02)
    assert shapes.Mesh(vertices=CUBE_VERTICES, triangles=CUBE_TRIANGLES).repair is None
    with pytest.raises(rsph.InputError, match="open edges"):
        shapes.Mesh(vertices=CUBE_VERTICES, triangles=CUBE_TRIANGLES[1:], repair=False)


def test_a_published_liver_of_open_parts():
    path = ROOT.parent / "shared/data/meshes/VH_F_Liver.glb"
    if not path.exists():
        pytest.skip("the meshes of real organs are not here")
    with pytest.warns(rsph.RsphWarning, match="not closed"):
        liver = shapes.Mesh(path)
    assert liver.volume == pytest.approx(2.1382e-3, rel=5e-3)
    assert liver.repair is not None
    assert liver.repair["uncertain"] < 0.01


def test_a_real_liver():
    path = ROOT.parent / "shared/data/meshes/visible_human_liver_female.stl"
    if not path.exists():
        pytest.skip("the meshes of real organs are not here")
    liver = shapes.Mesh(path)
    assert liver.volume > 0


def mean_of_x(region):
    probe = rsph.Probe(name="x", quantity="displacement.x", region=region)
    sim = cube(initial_displacement=lambda x: x * [1, 0, 0], probes=[probe])
    return sim.probes()["x"]


def test_regions_combine():
    left = regions.plane(axis="x", at=0.5, side="below")
    low = regions.plane(axis="x", at=0.25, side="below")
    assert mean_of_x(left) == pytest.approx((0.1 + 0.3 + 0.5) / 3)
    assert mean_of_x(left & ~low) == pytest.approx(0.4)
    assert mean_of_x(low | ~left) == pytest.approx((0.1 + 0.7 + 0.9) / 3)
    assert mean_of_x(regions.everywhere) == pytest.approx(0.5)
    assert mean_of_x(regions.box(min=(0.6, 0, 0), max=(1, 1, 1))) == pytest.approx(0.8)
    assert mean_of_x(regions.half_space(point=(0.2, 0, 0), normal=(1, 0, 0))) == pytest.approx(0.1)
    shown = repr(left & ~low)
    assert shown.startswith("(regions.plane(axis='x', at=0.5, side='below') & ~regions.plane(")
    with pytest.raises(TypeError):
        left & 3


def test_patches_are_on_the_surface_only():
    patch = regions.surface_patch(centre=(1, 0.5, 0.5), radius=0.2, facing=(1, 0, 0))
    assert mean_of_x(patch) == pytest.approx(1.0, rel=1e-6)


def test_materials_come_from_the_registry():
    names = [m.name for m in rsph.materials.models()]
    assert "kelvin-voigt" in names
    kelvin_voigt = rsph.materials.models()[names.index("kelvin-voigt")]
    values = {p.key: 0.25 for p in kelvin_voigt.parameters if p.numbers[0] > 0}
    by_name = rsph.materials.model("kelvin-voigt", **values)
    assert by_name.parameters == rsph.materials.KelvinVoigt(**values).parameters == values
    assert "density=0.25" in repr(by_name)


def folder_error(path):
    with pytest.raises(rsph.InputError) as e:
        rsph.read(path)
    return e.value


def test_results_that_are_none_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.vtkhdf"):
        with pytest.raises(rsph.InputError):
            rsph.read(path)
    assert "scenario.toml" in str(folder_error(tmp_path))
    text = tmp_path / "text.vtkhdf"
    text.write_text("no HDF5")
    with pytest.raises(rsph.InputError, match=r"text\.vtkhdf"):
        rsph.read(text)


def test_plots(tmp_path):
    import matplotlib

    matplotlib.use("Agg")
    sim = pulled()
    history = sim.run(until=0.02)
    axes = rsph.plot.history(history)
    assert axes.get_legend_handles_labels()[1] == ["extension"]
    for field in ("displacement", "strain", "von_mises"):
        axes = rsph.plot.surface(sim.surface(), field=field, exaggerate=20)
    axes.figure.savefig(tmp_path / "surface.png")
    assert (tmp_path / "surface.png").stat().st_size > 10_000
    for view in ("x", "-x", "y", "-y", "z", "-z"):
        drawn = rsph.plot.strain_map(sim.surface(), view=view, cmap="gray_r").collections[0]
        # The side of the cube that is seen, and no other.
        (low, high) = drawn.get_datalim(drawn.axes.transData).get_points()
        assert np.prod(high - low) == pytest.approx(1.0, abs=0.1)
        corners = np.array([p.vertices[:3] for p in drawn.get_paths()])
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        assert area.min() > 0.0
        assert area.sum() == pytest.approx(1.0, abs=0.1)
    with pytest.raises(rsph.InputError, match="view"):
        rsph.plot.strain_map(sim.surface(), view="front")
    picture = rsph.plot.image(sim.surface(), size=(200, 150), path=tmp_path / "image.png")
    assert picture.shape == (150, 200, 3)
    assert picture.std() > 10
    assert (tmp_path / "image.png").stat().st_size > 1000
    assert rsph.plot.polydata(sim.surface())["stress"].shape[1] == 6
    line = rsph.Simulation.from_toml(ROOT / "scenarios" / "fsi_1d.toml")
    line.run(until=0.1)
    fluid, solid = rsph.plot.profile(line.snapshot()).get_lines()
    assert fluid.get_xdata()[0] == -0.5
    assert solid.get_xdata()[-1] == 0.5
    assert fluid.get_ydata()[-1] == solid.get_ydata()[0]


def test_planes_meet_the_faces(sim):
    assert sim.description.load == pytest.approx([0, 0, 1])
    assert repr(BOTTOM) != repr(TOP)


def test_results_of_the_command_line_are_read(tmp_path):
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release" / "rsph"
    assert program.exists(), "build the command line first: cargo build --release"
    changes = {"body.particles": 125, "time.until": 0.02, "output.every": 0.01}
    sets = [f"--set={key}={value}" for key, value in changes.items()]
    scenario = ROOT / "scenarios" / "tensile_liver.toml"
    run = [program, "run", scenario, "--output", tmp_path / "out", "--quiet", *sets]
    subprocess.run(run, check=True)

    particles = rsph.read(tmp_path / "out" / "particles.vtkhdf")
    assert particles.times == pytest.approx([0, 0.01, 0.02])
    assert len(particles) == len(list(particles)) == len(particles[:]) == 3
    last = particles[-1]
    assert last.time == pytest.approx(0.02)
    assert particles.fields["stress"] == 6
    sim = rsph.Simulation.from_toml(scenario, overrides=changes)
    sim.run(until=0.01)
    sim.run(until=0.02)
    snapshot = sim.snapshot()
    for field in last.fields:
        np.testing.assert_array_equal(last[field], snapshot[field], err_msg=field)
    np.testing.assert_array_equal(last.positions, snapshot.positions)

    surface = rsph.read(tmp_path / "out" / "surface.vtkhdf")[2]
    assert isinstance(surface, rsph.Surface)
    np.testing.assert_array_equal(surface.triangles, sim.surface().triangles)
    np.testing.assert_array_equal(surface["shear_strain"], sim.surface()["shear_strain"])
    with pytest.raises(IndexError, match="3 frames"):
        particles[3]
    with pytest.raises(rsph.MissingFieldError, match="displacement"):
        last["temperature"]
    assert "3 frames from t = 0 to 0.02" in repr(particles)


def test_the_extension_serves_every_python_and_every_processor():
    from rsph import _rsph

    assert ".abi3." in Path(_rsph.__file__).name
    # Wide registers are found at run time; a flag for the build would ask for them everywhere.
    told = [ROOT / "Cargo.toml", ROOT / "pyproject.toml", *ROOT.glob("crates/*/Cargo.toml")]
    told += [*ROOT.glob("crates/*/build.rs"), *ROOT.glob(".cargo/*"), *ROOT.glob("*/.cargo/*")]
    for path in told:
        text = path.read_text()
        assert "target-cpu" not in text, path
        assert "target-feature" not in text, path


def test_a_painted_part_of_a_mesh_file(tmp_path):
    """The upper face of a unit cube, by name and by colour, is loaded as the plane is."""
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    obj = [f"v {x} {y} {z}" for x, y, z in corners]
    for k, face in enumerate(faces):
        obj += [f"g {'upper' if k == 1 else 'rest'}", "f " + " ".join(str(v + 1) for v in face)]
    (tmp_path / "cube.obj").write_text("\n".join(obj))
    upper = rsph.regions.part("upper", path=tmp_path / "cube.obj")

    def extension(region):
        sim = cube(
            boundaries=[rsph.boundaries.Clamp(region=BOTTOM)],
            loads=[rsph.loads.Traction(region=region, traction=(0, 0, 1))],
            probes=[rsph.Probe(name="extension", quantity="displacement.z", region=TOP)],
        )
        sim.solve_static()
        return sim.probes()["extension"]

    assert extension(upper) == pytest.approx(extension(TOP), rel=1e-9)
    with pytest.raises(rsph.InputError, match='has no part "lower"'):
        rsph.regions.part(["upper", "lower"], path=tmp_path / "cube.obj")
    with pytest.raises(rsph.InputError, match=r"no\.obj"):
        rsph.regions.part("upper", path=tmp_path / "no.obj")
