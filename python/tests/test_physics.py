"""What a simulation built in Python computes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rsph

from conftest import BOTTOM, cube, material, pulled

SIDE_WALLS = [rsph.regions.plane(axis=axis, at=0.0, side="below") for axis in ("x", "y")]
small = st.floats(-1e-3, 1e-3)


@settings(max_examples=10, deadline=None)
@given(st.lists(small, min_size=9, max_size=9))
def test_a_linear_displacement_has_its_exact_strain_everywhere(numbers):
    gradient = np.reshape(numbers, (3, 3))
    sim = cube(initial_displacement=rsph.fields.Affine(gradient=gradient, constant=(1, 2, 3)))
    g = 0.5 * (gradient + gradient.T)
    expected = [g[0, 0], g[1, 1], g[2, 2], g[0, 1], g[1, 2], g[0, 2]]
    np.testing.assert_allclose(sim.snapshot().strain, np.tile(expected, (125, 1)), atol=1e-12)


def test_fields_functions_and_constants_agree():
    gradient = np.array([[0.1, 0.2, 0.0], [0.0, -0.1, 0.3], [0.2, 0.0, 0.1]]) * 1e-2
    affine = cube(initial_velocity=rsph.fields.Affine(gradient=gradient, constant=(1, 2, 3)))
    function = cube(initial_velocity=lambda x: x @ gradient.T + (1, 2, 3))
    np.testing.assert_allclose(affine.snapshot().velocity, function.snapshot().velocity, rtol=1e-14)
    rotation = cube(initial_velocity=rsph.fields.Rotation(rate=(0, 0, 2), centre=(0.5, 0.5, 0)))
    x = rotation.snapshot().reference
    expected = np.cross([0, 0, 2.0], x - [0.5, 0.5, 0.0])
    np.testing.assert_allclose(rotation.snapshot().velocity, expected, atol=1e-15)
    constant = cube(initial_velocity=np.array([1, 2, 3]))
    assert (constant.snapshot().velocity == [1, 2, 3]).all()


def test_a_free_beam_starts_in_its_mode():
    beam = rsph.fields.FreeBeam(start=(0, 0.5, 0.5), end=(1, 0.5, 0.5), amplitude=(0, 0, 0.1))
    snapshot = cube(initial_velocity=beam).snapshot()
    x, b = snapshot.reference[:, 0], 4.730040744862704
    q = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
    shape = np.cosh(b * x) + np.cos(b * x) - q * (np.sinh(b * x) + np.sin(b * x))
    np.testing.assert_allclose(snapshot.velocity[:, 2], 0.05 * shape, atol=1e-12)
    turning = snapshot.velocity[:, 0] * (snapshot.reference[:, 2] - 0.5)
    assert (turning[x < 0.4] >= 0).all()
    assert np.abs(turning[x < 0.4]).max() > 0


def test_a_block_on_springs_sinks_by_its_weight_over_their_stiffness():
    bed = rsph.boundaries.Foundation(region=BOTTOM, normal=5.0, tangential=1.0)
    sim = cube(
        material=material(young_modulus=1e5),
        foundations=[bed],
        loads=[rsph.loads.BodyForce(acceleration=(0, 0, -0.3))],
    )
    found = sim.solve_static()
    np.testing.assert_allclose(sim.snapshot().displacement, [[0, 0, -0.06]] * 125, atol=1e-5)
    np.testing.assert_allclose(found.reaction, (0, 0, 0.3), atol=1e-5)


def series(t, stiffness=100.0, relaxation=0.2):
    """End displacement of a bar of length 1 and density 1 under a sudden traction of 1."""
    k = (np.arange(400) + 0.5) * np.pi
    omega2, u = stiffness * k**2, np.zeros_like(t)
    for kn, w2 in zip(k, omega2, strict=True):
        decay = w2 * relaxation / 2
        root = np.emath.sqrt(decay**2 - w2)
        p, q = -decay + root, -decay - root
        response = 1 + (q * np.exp(p * t) - p * np.exp(q * t)) / (p - q)
        u += 2 / (stiffness * kn**2) * np.real(response)
    return u


def test_a_pulled_bar_follows_the_exact_series():
    sim = pulled(material=material(poisson_ratio=0.0), spacing=1 / 7)
    history = sim.run(until=1.0)
    exact = series(history["time"])
    assert exact[-1] == pytest.approx(0.01, rel=0.05)
    assert np.abs(history["extension"] - exact).max() < 0.005 * exact.max()


def test_free_flight_keeps_mass_and_momentum():
    sim = cube(
        initial_velocity=(0.3, -0.2, 0.1),
        initial_displacement=rsph.fields.Affine(gradient=np.diag([1e-3, -2e-3, 0])),
    )
    before = sim.conservation()
    sim.step(200)
    after = sim.conservation()
    assert after["mass"] == before["mass"] == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(after["momentum"], [0.3, -0.2, 0.1], atol=1e-12)
    assert after["momentum_error"] < 1e-12
    assert after["kinetic_energy"] + after["elastic_energy"] > 0


def test_rollers_and_moving_parts():
    top = rsph.regions.plane(axis="z", at=1.0, side="above")
    sim = cube(
        boundaries=[
            rsph.boundaries.Clamp(region=BOTTOM, fix=["z"]),
            rsph.boundaries.Clamp(region=SIDE_WALLS[0], fix=["x"]),
            rsph.boundaries.Clamp(region=SIDE_WALLS[1], fix=["y"]),
            rsph.boundaries.Prescribed(
                region=top,
                fix=["z"],
                motion=rsph.boundaries.RampTo(displacement=(0, 0, 0.01), end=1.0),
            ),
        ]
    )
    sim.run(until=3.0)
    strain = sim.snapshot().strain.mean(axis=0)
    np.testing.assert_allclose(strain[:3], [-0.003, -0.003, 0.01], rtol=0.02)


def test_gravity_pressure_and_patch_push_where_they_should():
    g = rsph.loads.BodyForce(acceleration=(0, 0, -2))
    assert cube(loads=[g]).description.load == pytest.approx([0, 0, -2])
    top = rsph.regions.plane(axis="z", at=1.0, side="above")
    p = rsph.loads.Pressure(region=top, pressure=3.0, ramp=(0, 1))
    assert pulled(loads=[p]).description.load == pytest.approx([0, 0, -3], abs=1e-9)
    patch = rsph.loads.Patch(
        pressure=270, centre="upper-right", direction=(0, -2, 0), ramp=(0, 0.01)
    )
    sim = rsph.Simulation(
        shape=rsph.shapes.Organ("liver"),
        particles=200,
        material=material(density=1000, young_modulus=1e5, relaxation_time=1e-3),
        loads=[patch],
    )
    load = sim.description.load
    assert load[1] < -0.1
    assert np.abs(load[[0, 2]]).max() < 1e-9 * abs(load[1])


@pytest.mark.parametrize("every", [1, 10, "auto"])
def test_a_remeshed_cube_extends_as_much(every):
    def run(remesh_every):
        sim = pulled(remesh_every=remesh_every, dt=0.0005)
        sim.run(until=0.2)
        return sim

    without, remeshed = run(0), run(every)
    ours, theirs = remeshed.snapshot(), without.snapshot()
    assert ours.displacement[:, 2].max() == pytest.approx(theirs.displacement[:, 2].max(), rel=0.01)
    np.testing.assert_allclose(ours.mass.sum(), theirs.mass.sum(), rtol=1e-13)
    np.testing.assert_allclose(ours.positions, ours.reference + ours.displacement, atol=1e-15)


def test_what_remeshing_can_not_be_is_refused():
    for wrong in ({"remesh_every": -1}, {"remesh_every": "sometimes"}, {"remesh_kernel": "m4"}):
        with pytest.raises(rsph.InputError, match="remesh"):
            cube(**wrong)


def test_equilibrium_is_where_motion_ends():
    still, moved = pulled(), pulled(integrator="sdirk2", tolerance=1e-3)
    found = still.solve_static()
    moved.run(until=3.0)
    assert found.residual < 2e-6
    assert 0 < found.iterations <= 20
    np.testing.assert_allclose(found.load + found.reaction, 0.0, atol=1e-5)
    rest, end = still.snapshot().displacement, moved.snapshot().displacement
    np.testing.assert_allclose(end, rest, atol=1e-3 * np.abs(rest).max())
    assert found.compliance == pytest.approx(still.probes()["extension"], rel=0.05)


def test_integrators_agree_and_can_be_changed():
    ends = []
    for integrator in ("rk4", "sdirk2", "rkc2"):
        sim = pulled()
        sim.run(until=0.2, integrator=integrator, dt=None if integrator == "rk4" else 0.005)
        ends.append(sim.probes()["extension"])
    np.testing.assert_allclose(ends, ends[0], rtol=5e-3)


def test_stiffness_is_symmetric_and_balances_the_load():
    sim = pulled()
    stiffness = sim.stiffness
    size = 3 * sim.particles
    assert stiffness.shape == (size, size)
    rng = np.random.default_rng(1)
    a, b = rng.standard_normal((2, size))
    scale = np.linalg.norm(a) * np.linalg.norm(stiffness @ b)
    assert a @ (stiffness @ b) == pytest.approx(b @ (stiffness @ a), abs=1e-12 * scale)
    found = sim.solve_static()
    u = sim.snapshot().displacement.ravel()
    assert u @ (stiffness @ u) == pytest.approx(found.compliance, rel=1e-5)


def test_a_membrane_in_the_plane_rests_like_finite_elements():
    """Cook's membrane, nu = 0.49: validation/large_strain/cook.csv."""
    sim = rsph.Simulation(
        shape=rsph.shapes.Polygon([(0, 0), (48, 44), (48, 60), (0, 44)]),
        spacing=2.0,
        material=rsph.materials.NeoHookean(
            density=1.0, young_modulus=240.565, poisson_ratio=0.49, relaxation_time=0.0
        ),
        boundaries=[
            rsph.boundaries.Clamp(region=rsph.regions.plane(axis="x", at=0.0, side="below"))
        ],
        loads=[
            rsph.loads.Traction(
                region=rsph.regions.plane(axis="x", at=48.0, side="above"), traction=(0, 6.25, 0)
            )
        ],
        probes=[
            rsph.Probe(
                name="corner",
                quantity="displacement.y",
                region=rsph.regions.point(at=(48.0, 60.0, 0.0)),
            )
        ],
        units="normalised",
    )
    sim.solve_static()
    assert sim.probes()["corner"] == pytest.approx(6.984, rel=0.01)
    with pytest.raises(rsph.InputError, match="meets itself"):
        rsph.shapes.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])
