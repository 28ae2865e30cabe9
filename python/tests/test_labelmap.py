"""Bodies from segmented images."""

import gzip
import struct

import nibabel as nib
import numpy as np
import pytest

import rsph
from rsph import shapes

from conftest import ROOT

BALL = np.sqrt(((np.indices((40, 36, 30)).T - [18.0, 17.0, 14.0]) ** 2).sum(axis=-1).T) < 11.0
VOLUME = BALL.sum()  # 1.4 % less than that of the ball
CENTRE = np.array([18.0, 17.0, 14.0])


TYPES = ["u1", "i1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8", ">i2", ">f4", ">i4"]


def middle(shape):
    return shape.bounds.mean(axis=0)


def rotation(angle=0.4):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def affine(axes, origin=(10.0, -20.0, 30.0)):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = axes, origin
    return matrix


@pytest.fixture(scope="module")
def liver():
    """The analytic liver, and its mask in voxels of 1 mm with the position of the first (m)."""
    organ = shapes.Organ("liver")
    edge, (low, high) = 1e-3, organ.bounds
    count = [int((b - a) / edge) + 8 for a, b in zip(low, high, strict=True)]
    first = low - 3.3 * edge
    # Voxels far from the surface are those of a coarser look at it.
    signs = np.zeros(count, dtype=bool)
    block = 4
    starts = np.stack(
        np.meshgrid(*(np.arange(0, n, block) for n in count), indexing="ij"), axis=-1
    ).reshape(-1, 3)
    distance = organ.signed_distance(first + (starts + 0.5 * (block - 1)) * edge)
    far = np.abs(distance) > 0.87 * block * edge
    for start in starts[far & (distance < 0)]:
        signs[tuple(slice(s, s + block) for s in start)] = True
    inner = np.stack(np.meshgrid(*[np.arange(block)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    near = (starts[~far][:, None, :] + inner).reshape(-1, 3)
    near = near[(near < count).all(axis=1)]
    signs[tuple(near.T)] = organ.signed_distance(first + near * edge) < 0
    return organ, signs, first


def settled(shape):
    """Mean displacement (m) of the top of a liver under the load of Figs. 6 and 7, at rest."""
    top = rsph.regions.plane(axis="y", at=0.04, side="above")
    sim = rsph.Simulation(
        shape=shape,
        spacing=0.008,
        material=rsph.materials.KelvinVoigt(
            density=1000.0, young_modulus=1e5, poisson_ratio=0.3, relaxation_time=0.2
        ),
        boundaries=[
            rsph.boundaries.Clamp(region=rsph.regions.plane(axis="y", at=-0.05, side="below"))
        ],
        loads=[rsph.loads.Patch(pressure=270, centre=(0.079, 0.052, -0.004), direction=(0, -1, 0))],
        probes=[rsph.Probe(name="top", quantity="displacement.y", region=top)],
    )
    found = sim.solve_static()
    return sim.probes()["top"], found.compliance


def test_a_segmented_liver_is_the_liver(liver, tmp_path):
    organ, mask, first = liver
    path = tmp_path / "liver.nii.gz"
    image = nib.Nifti1Image(3 * mask.astype(np.int16), affine(np.eye(3), 1e3 * first))
    image.header.set_xyzt_units("mm")
    nib.save(image, path)
    segmented = shapes.LabelMap(path, label=3)
    assert segmented.volume == pytest.approx(organ.volume, rel=1e-3)  # asked for: 1 %
    distance = np.abs(organ.signed_distance(segmented.vertices))
    assert distance.mean() < 0.1e-3
    ours, theirs = settled(segmented), settled(organ)
    assert ours == pytest.approx(theirs, rel=0.03)

    text = (ROOT / "scenarios" / "liver_load.toml").read_text()
    words = 'labelmap = { path = "liver.nii.gz", label = 3 }'
    scenario = tmp_path / "segmented.toml"
    scenario.write_text(text.replace('shape = { organ = "liver" }', words))
    sim = rsph.Simulation.from_toml(scenario)
    # The clamp cuts it.
    assert 0.5 * segmented.volume < sim.description.shape_volume < segmented.volume
    assert sim.description.shape == "label 3 of liver.nii.gz"
    # The scenario as run finds the image from anywhere.
    assert str(path) in rsph.Scenario.from_toml(scenario).text
    short = text.replace('shape = { organ = "liver" }', 'labelmap = "liver.nii.gz"')
    scenario.write_text(short)
    with pytest.raises(rsph.InputError, match="no voxel has the label 1") as e:
        rsph.Simulation.from_toml(scenario)
    assert "segmented.toml:" in str(e.value)
    assert e.value.remedy == "it has the labels 3"
    assert e.value.key == "body.labelmap.path"


def test_particles_fill_meshes_and_masks():
    box = shapes.Box(size=(1, 1, 1))
    filled = rsph.Particles.from_mesh(box.vertices, box.triangles, spacing=0.25)
    assert len(filled) == 64
    assert filled.volume.sum() == pytest.approx(1.0)
    assert filled.positions.shape == (64, 3)
    assert (filled.level_set < 0).all()
    ball = rsph.Particles.from_mask(BALL, 0.001, particles=500)
    assert len(ball) == pytest.approx(500, rel=0.1)
    assert ball.volume.sum() == pytest.approx(1e-9 * VOLUME, rel=0.01)
    np.testing.assert_allclose(ball.positions.mean(axis=0), 1e-3 * CENTRE, atol=1e-4)
    labels = rsph.Particles.from_mask(np.where(BALL, 7, 2), (1, 1, 2), label=7, spacing=4.0)
    assert labels.shape.volume == pytest.approx(2 * VOLUME, rel=0.01)
    assert "label" not in repr(labels)
    material = rsph.materials.KelvinVoigt(
        density=1000.0, young_modulus=1e4, poisson_ratio=0.3, relaxation_time=0.01
    )
    sim = rsph.Simulation(shape=ball, material=material)
    assert sim.spacing == ball.spacing
    for wrong in ({}, {"spacing": 1.0, "particles": 3}, {"spacing": -1.0}):
        with pytest.raises(rsph.InputError, match="spacing"):
            rsph.Particles.of(box, **wrong)


@pytest.mark.parametrize("axes", [np.eye(3), np.diag([0.7, 0.7, 2.5]), np.diag([-1.0, 1, 1])])
@pytest.mark.parametrize("form", ["sform", "qform", "none"])
@pytest.mark.parametrize("kind", [nib.Nifti1Image, nib.Nifti2Image])
def test_places_are_those_of_nibabel(tmp_path, kind, form, axes):
    matrix = affine(rotation() @ axes)
    image = kind(BALL.astype(np.uint8), matrix)
    image.header.set_xyzt_units("mm")
    image.set_sform(matrix if form == "sform" else None, 2 if form == "sform" else 0)
    image.set_qform(matrix if form == "qform" else None, 1 if form == "qform" else 0)
    if form == "none":
        image.header["pixdim"][1:4] = np.abs(np.diag(axes))
        matrix = np.diag([*np.abs(np.diag(axes)), 1.0])
    nib.save(image, tmp_path / "ball.nii")
    shape = shapes.LabelMap(tmp_path / "ball.nii")
    assert shape.volume == pytest.approx(1e-9 * VOLUME * abs(np.linalg.det(axes)), rel=0.01)
    expected = 1e-3 * (matrix @ [*CENTRE, 1.0])[:3]
    np.testing.assert_allclose(shape.vertices.mean(axis=0), expected, atol=2e-4)
    same = shapes.Mask(BALL, affine=np.diag([1e-3, 1e-3, 1e-3, 1.0]) @ matrix)
    np.testing.assert_allclose(same.bounds, shape.bounds, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("compressed", [False, True])
def test_numbers_of_every_type_are_read(tmp_path, dtype, compressed):
    dtype = np.dtype(dtype)
    header = nib.Nifti1Header(endianness=">" if dtype.byteorder == ">" else "<")
    header.set_data_dtype(dtype)
    image = nib.Nifti1Image((5 * BALL).astype(dtype), affine(np.eye(3)), header)
    image.header.set_xyzt_units("meter")
    path = tmp_path / ("ball.nii.gz" if compressed else "ball.nii")
    nib.save(image, path)
    assert shapes.LabelMap(path, label=5).volume == pytest.approx(VOLUME, rel=0.01)
    assert shapes.LabelMap(path, label=5, scale=0.1).volume == pytest.approx(
        1e-3 * VOLUME, rel=0.01
    )


def test_scaled_numbers_are_labels(tmp_path):
    image = nib.Nifti1Image(BALL.astype(np.int16), np.eye(4))
    image.header.set_slope_inter(2.0, 1.0)  # nibabel writes what was meant
    nib.save(image, tmp_path / "scaled.nii")
    raw = bytearray((tmp_path / "scaled.nii").read_bytes())
    raw[112:120] = struct.pack("<2f", 2.0, 4.0)
    (tmp_path / "scaled.nii").write_bytes(raw)
    stored = nib.load(tmp_path / "scaled.nii").get_fdata()
    label = int(stored.max())
    assert shapes.LabelMap(tmp_path / "scaled.nii", label=label).volume > 0


def test_a_patient_is_turned_to_the_axes_of_organs(tmp_path):
    image = nib.Nifti1Image(BALL.astype(np.uint8), affine(np.eye(3)))
    nib.save(image, tmp_path / "ball.nii.gz")
    x = middle(shapes.LabelMap(tmp_path / "ball.nii.gz"))
    turned = shapes.LabelMap(tmp_path / "ball.nii.gz", axes="organ")
    # Right, front, up become left, up, front.
    np.testing.assert_allclose(middle(turned), [-x[0], x[2], x[1]], atol=1e-9)
    assert turned.volume > 0
    with pytest.raises(rsph.InputError, match="axes"):
        shapes.LabelMap(tmp_path / "ball.nii.gz", axes="patient")


@pytest.mark.parametrize("space", ["left-posterior-superior", "RAS", None])
def test_nrrd_is_the_same_body_as_nifti(tmp_path, space):
    nrrd = pytest.importorskip("nrrd")
    matrix = affine(rotation() @ np.diag([0.8, 0.8, 1.5]))
    nib.save(nib.Nifti1Image(BALL.astype(np.uint8), matrix), tmp_path / "ball.nii")
    sign = np.diag([-1.0, -1, 1]) if space and space.startswith("left") else np.eye(3)
    header = {
        "space directions": (sign @ matrix[:3, :3]).T,
        "space origin": sign @ matrix[:3, 3],
    }
    if space:
        header["space"] = space
    else:
        header["space dimension"] = 3
    nrrd.write(str(tmp_path / "ball.nrrd"), 4 * BALL.astype(np.uint8), header)
    ours = shapes.LabelMap(tmp_path / "ball.nrrd", label=4)
    theirs = shapes.LabelMap(tmp_path / "ball.nii")
    np.testing.assert_allclose(ours.bounds, theirs.bounds, rtol=1e-5)
    turned = shapes.LabelMap(tmp_path / "ball.nrrd", label=4, axes="organ")
    same = shapes.LabelMap(tmp_path / "ball.nii", axes="organ")
    np.testing.assert_allclose(turned.bounds, same.bounds, rtol=1e-5)
    with pytest.raises(rsph.InputError, match="label 9") as e:
        shapes.LabelMap(tmp_path / "ball.nrrd", label=9)
    assert e.value.remedy == "it has the labels 4"
    (tmp_path / "bad.nrrd").write_bytes(b"NRRD0004\ntype: uchar\n")
    with pytest.raises(rsph.InputError, match=r"bad\.nrrd"):
        shapes.LabelMap(tmp_path / "bad.nrrd")


def test_damaged_nrrd_is_refused(tmp_path):
    nrrd = pytest.importorskip("nrrd")
    path = tmp_path / "ball.nrrd"
    nrrd.write(str(path), BALL[::4, ::4, ::4].astype(np.uint8))
    whole = path.read_bytes()
    rng = np.random.default_rng(8)
    refused = 0
    for _ in range(400):
        damaged = bytearray(whole)
        for at in rng.integers(len(damaged), size=3):
            damaged[at] = rng.integers(256)
        path.write_bytes(damaged[: rng.integers(20, 2 * len(damaged))])
        try:
            shapes.LabelMap(path, label=1)
        except rsph.InputError:
            refused += 1
    assert refused > 200


def nifti(tmp_path):
    nib.save(nib.Nifti1Image(BALL.astype(np.uint8), np.eye(4)), tmp_path / "good.nii")
    return (tmp_path / "good.nii").read_bytes()


def changed(raw, at, fmt, *values):
    raw = bytearray(raw)
    struct.pack_into(fmt, raw, at, *values)
    return bytes(raw)


BROKEN = {
    "empty": (lambda r: b"", "is empty|ends within its header"),
    "text": (lambda r: b"no image at all, but long enough " * 20, "no NIfTI or NRRD file"),
    "magic": (lambda r: changed(r, 344, "4s", b"bad\0"), "no NIfTI file"),
    "pair": (lambda r: changed(r, 344, "4s", b"ni1\0"), "pair"),
    "short header": (lambda r: r[:200], "ends within its header"),
    "short data": (lambda r: r[:-10], "ends too early"),
    "huge": (lambda r: changed(r, 42, "<3h", 32000, 32000, 32000), "are allowed in all"),
    "negative": (lambda r: changed(r, 42, "<h", -4), "-4 voxels"),
    "no dimension": (lambda r: changed(r, 40, "<h", 0), "0 dimensions"),
    "in time": (lambda r: changed(r, 40, "<5h", 4, 10, 10, 10, 43), "43 images"),
    "colour": (lambda r: changed(r, 70, "<h", 128), "type 128"),
    "offset": (lambda r: changed(r, 108, "<f", 10.0), "begin at byte 10"),
    "no number": (lambda r: changed(r, 108, "<f", float("nan")), "begin at byte NaN"),
    "flat": (lambda r: changed(r, 312, "<4f", 0, 0, 0, 0), "plane"),
    "lost": (lambda r: changed(r, 292, "<f", float("inf")), "finite"),
}


@pytest.mark.parametrize("case", BROKEN)
@pytest.mark.parametrize("compressed", [False, True])
def test_broken_images_are_refused(tmp_path, case, compressed):
    breaking, message = BROKEN[case]
    raw = breaking(nifti(tmp_path))
    path = tmp_path / "image.nii.gz"
    path.write_bytes(gzip.compress(raw) if compressed else raw)
    message = "ends" if compressed and case == "short data" else message
    with pytest.raises(rsph.InputError, match=message) as e:
        shapes.LabelMap(path)
    assert e.value.remedy


def test_files_that_are_none_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "none.nii"):
        with pytest.raises(rsph.InputError, match=r"read|file"):
            shapes.LabelMap(path)
    raw = gzip.compress(nifti(tmp_path))
    (tmp_path / "cut.nii.gz").write_bytes(raw[: len(raw) // 2])
    with pytest.raises(rsph.InputError, match="ends in slice"):
        shapes.LabelMap(tmp_path / "cut.nii.gz")


@pytest.mark.parametrize(
    "make",
    [
        lambda: shapes.Mask(np.zeros((5, 5, 5)), 1.0),
        lambda: shapes.Mask(np.zeros((5, 5)), 1.0),
        lambda: shapes.Mask(np.ones((5, 5, 5), dtype=complex), 1.0),
        lambda: shapes.Mask(BALL),
        lambda: shapes.Mask(BALL, 1.0, affine=np.eye(4)),
        lambda: shapes.Mask(BALL, (1.0, 2.0)),
        lambda: shapes.Mask(BALL, affine=np.eye(3)),
        lambda: shapes.Mask(BALL, 0.0),
        lambda: shapes.Mask(BALL, np.nan),
        lambda: shapes.Mask(BALL, "small"),
    ],
)
def test_masks_that_show_nothing_are_refused(make):
    with pytest.raises(rsph.InputError):
        make()


def test_what_is_no_number_is_outside():
    volume = shapes.Mask(BALL, 0.001).volume
    for outside in (0.0, np.nan):
        values = np.where(BALL, 1.0, outside)
        assert shapes.Mask(values, 0.001).volume == volume
        values = np.where(BALL, np.float32(7.0001), np.float32(outside))
        assert shapes.Mask(values, 0.001, label=7).volume == volume
