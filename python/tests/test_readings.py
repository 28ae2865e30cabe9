"""Forces and moments, measures of deformation, strain gauges and images of fields."""

import nibabel as nib
import numpy as np
import pytest

import rsph
from rsph import boundaries, regions, shapes

FOOT = regions.plane(axis="z", at=0.0, side="below")
TOP = regions.plane(axis="z", at=0.1, side="above")


def bar(**more):
    """A bar of 0.1 m whose top is moved by 1 mm; nu = 0."""
    motion = boundaries.RampTo(displacement=(0.0, 0.0, 0.001), end=1.0)
    return rsph.Simulation(
        shape=shapes.Box(size=(0.1, 0.1, 0.1)),
        spacing=0.0125,
        material=rsph.materials.KelvinVoigt(
            density=1000.0, young_modulus=1e4, poisson_ratio=0.0, relaxation_time=0.0
        ),
        boundaries=[
            boundaries.Clamp(region=FOOT, name="foot", moment_about=(0.0, 0.0, 0.0)),
            boundaries.Prescribed(region=TOP, motion=motion, name="grip"),
        ],
        **more,
    )


def test_forces_moments_and_gauges():
    sim = bar(gauges=[rsph.Gauge(name="g", start=(0.05, 0.05, 0.02), end=(0.05, 0.05, 0.08))])
    sim.solve_static(time=1.0)
    found = sim.probes()
    assert found["grip_force_z"] == pytest.approx(1.0, abs=1e-8)
    assert found["foot_force_z"] == pytest.approx(-1.0, abs=1e-8)
    assert found["grip_displacement_z"] == 0.001
    # The foot pulls at (0.05, 0.05, 0).
    moment = [found[f"foot_moment_{c}"] for c in "xyz"]
    assert moment == pytest.approx([-0.05, 0.05, 0.0], abs=1e-9)
    assert found["grip_moment_x"] == pytest.approx(0.0, abs=1e-9)
    assert found["g_strain"] == pytest.approx(0.01, abs=1e-8)
    assert found["g_length"] == pytest.approx(0.0606, abs=1e-9)
    history = {name: np.array([0.0, value]) for name, value in found.items()}
    axes = rsph.plot.force_displacement(history, boundary="grip")
    assert axes.lines[0].get_ydata()[-1] == pytest.approx(1.0, abs=1e-8)
    with pytest.raises(rsph.InputError, match="foot"):
        rsph.plot.force_displacement(history, boundary="foot")


def test_measures_are_fields_that_are_asked_for():
    sim = bar(fields=["principal_strain", "principal_direction_1", "volume_ratio", "pressure"])
    sim.solve_static(time=1.0)
    snapshot = sim.snapshot()
    assert snapshot["principal_strain"].shape == (len(snapshot), 3)
    assert np.allclose(snapshot["principal_strain"], [0.01, 0.0, 0.0], atol=1e-8)
    assert np.allclose(snapshot["principal_direction_1"], [0.0, 0.0, 1.0])
    assert np.allclose(snapshot["volume_ratio"], 1.01, atol=1e-8)
    assert np.allclose(snapshot["pressure"], -100.0 / 3.0, rtol=1e-6)
    assert np.allclose(sim.surface()["principal_strain"][:, 0], 0.01, atol=1e-6)
    assert "volume_ratio" not in bar().snapshot().fields
    with pytest.raises(rsph.InputError, match="principal_strain"):
        bar(fields=["principal_strian"])
    with pytest.raises(rsph.InputError, match="list"):
        bar(fields="pressure")


@pytest.mark.parametrize("axes", ["image", "organ"])
def test_a_displacement_is_shown_on_the_voxels_of_an_image(tmp_path, axes):
    sim = bar()
    sim.solve_static(time=1.0)
    # From the axes of the body to right, front, up, in mm.
    turn = np.eye(3) if axes == "image" else np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0.0]])
    affine = np.eye(4)
    affine[:3, :3] = np.diag([4.0, -5.0, 6.0])
    affine[:3, 3] = turn @ [50.0, 50.0, 50.0] - affine[:3, :3] @ [17.5, 15.5, 13.5]
    ct = nib.Nifti1Image(np.zeros((36, 32, 28), dtype=np.int16), affine)
    ct.header.set_xyzt_units("mm")
    nib.save(ct, tmp_path / "ct.nii.gz")
    snapshot = sim.snapshot()
    snapshot.to_nifti(tmp_path / "u.nii.gz", like=tmp_path / "ct.nii.gz", axes=axes)
    image = nib.load(tmp_path / "u.nii.gz")
    assert image.header.get_intent("code")[0] == 1006
    assert image.shape == (36, 32, 28, 1, 3)
    assert np.allclose(image.affine, affine)
    found = np.asarray(image.dataobj)[:, :, :, 0, :]
    indices = np.stack(np.meshgrid(*map(np.arange, ct.shape), indexing="ij"), axis=-1)
    places = (indices @ affine[:3, :3].T + affine[:3, 3]) @ turn / 1e3
    inside = ((places > 0.0) & (places < 0.1)).all(axis=-1)
    expected = np.where(inside[..., None], turn @ [0.0, 0.0, 1.0], 0.0)
    expected = expected * (1e3 * 0.01 * places[..., 2:3])
    near_the_rim = (np.abs(np.abs(places - 0.05) - 0.05) < 0.0035).any(axis=-1)
    assert np.allclose(found[~near_the_rim], expected[~near_the_rim], atol=1e-5)
    snapshot.to_nifti(
        tmp_path / "e.nii", field="strain", like=tmp_path / "ct.nii.gz", axes=axes, outside=np.nan
    )
    strain = nib.load(tmp_path / "e.nii")
    assert strain.header.get_intent()[0] == "symmetric matrix"
    tensor = np.nanmean(np.asarray(strain.dataobj)[:, :, :, 0, :], axis=(0, 1, 2))
    pulled = turn @ np.diag([0.0, 0.0, 0.01]) @ turn.T
    assert np.allclose(tensor, pulled[np.tril_indices(3)], atol=1e-6)
    with pytest.raises(rsph.InputError, match="has no voxel in the body"):
        snapshot.to_nifti(tmp_path / "u.nii", like=tmp_path / "ct.nii.gz", scale=1.0)


def test_a_run_is_shown_with_the_registration_of_its_scenario(tmp_path):
    voxels = np.zeros((20, 16, 12), dtype=np.uint8)
    voxels[4:16, 3:13, 2:10] = 1
    affine = np.diag([5.0, 5.0, 5.0, 1.0])
    image = nib.Nifti1Image(voxels, affine)
    image.header.set_xyzt_units("mm")
    nib.save(image, tmp_path / "map.nii.gz")
    text = """
        body = { labelmap = { path = "map.nii.gz", axes = "organ" }, particles = 300 }
        material = { model = "kelvin-voigt", density = 1000.0, young_modulus = 1e4,
                      poisson_ratio = 0.3, relaxation_time = 0.1 }
        solver = { mode = "static" }
        time = { until = 1.0 }
        [[boundary]]
        kind = "clamp"
        region = { plane = { axis = "y", at = 0.012, side = "below" } }
        [[load]]
        kind = "body_force"
        acceleration = [0.0, -9.81, 0.0]
    """.replace("\n                      ", " ")
    (tmp_path / "run.toml").write_text(text)
    run = rsph.Scenario.from_toml(tmp_path / "run.toml").run(output=tmp_path / "out")
    folder = rsph.read(tmp_path / "out")
    assert run is not None
    folder.to_nifti(tmp_path / "u.nii.gz", like=tmp_path / "map.nii.gz")
    u = np.asarray(nib.load(tmp_path / "u.nii.gz").dataobj)[:, :, :, 0, :]
    shown = (u != 0.0).any(axis=-1)
    # Down in the body is down on the image: y of organs is z of the image.
    assert (u[shown][:, 2] < 0.0).mean() > 0.9
    assert shown[voxels == 0].sum() == 0
    assert shown[voxels == 1].mean() > 0.6
