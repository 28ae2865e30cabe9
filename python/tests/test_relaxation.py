"""Materials from measured relaxation."""

import numpy as np
import pytest

import rsph


def measured(rng=None, noise=0.0, modulus=2e4, amplitude=1e4, time=1.5, n=60, until=12.0):
    t = np.linspace(0.0, until, n)
    values = modulus + amplitude * np.exp(-t / time)
    return t, values + (0.0 if rng is None else noise * rng.standard_normal(n))


def test_exact_data_give_the_exact_material():
    fit = rsph.materials.from_relaxation(*measured(), density=1060.0, poisson_ratio=0.45)
    assert fit.young_modulus == pytest.approx(2e4, rel=1e-6)
    assert fit.relaxation_time == pytest.approx(1.5, rel=1e-6)
    assert fit.viscous_time == pytest.approx(0.75, rel=1e-6)
    assert fit.residual < 1e-3
    assert isinstance(fit.material, rsph.materials.KelvinVoigt)
    assert fit.material.parameters == pytest.approx(
        {
            "density": 1060.0,
            "young_modulus": 2e4,
            "poisson_ratio": 0.45,
            "relaxation_time": 1.5,
        }
    )
    t, values = measured()
    np.testing.assert_allclose(fit.modulus(t), values, rtol=1e-6)
    assert "E = 2e+04" in str(fit)


@pytest.mark.parametrize("noise", [100.0, 800.0])
def test_intervals_hold_the_truth_in_95_of_100_draws(noise):
    rng = np.random.default_rng(12)
    draws = 200
    held = np.zeros(2)
    errors, values = [], []
    for _ in range(draws):
        fit = rsph.materials.from_relaxation(*measured(rng, noise))
        low, high = fit.young_modulus_interval
        held[0] += low <= 2e4 <= high
        low, high = fit.relaxation_time_interval
        held[1] += low <= 1.5 <= high
        errors.append(fit.young_modulus_error)
        values.append(fit.young_modulus)
    # Binomial: 190 +- 3.1 of 200.
    assert (np.abs(held - 0.95 * draws) < 3 * np.sqrt(draws * 0.95 * 0.05)).all(), held
    # Standard errors are the scatter.
    assert np.mean(errors) == pytest.approx(np.std(values), rel=0.2)


def test_known_noise_and_several_terms():
    rng = np.random.default_rng(3)
    t = np.geomspace(0.01, 100.0, 200)
    truth = 1e4 + 4e3 * np.exp(-t / 0.3) + 2e3 * np.exp(-t / 10.0)
    noise = 0.005 * truth
    values = truth + noise * rng.standard_normal(t.size)
    fit = rsph.materials.from_relaxation(t, values, terms=2, sigma=noise)
    assert fit.times == pytest.approx([0.3, 10.0], rel=0.2)
    assert fit.amplitudes == pytest.approx([4e3, 2e3], rel=0.1)
    low, high = fit.young_modulus_interval
    assert low < 1e4 < high
    mean = (4e3 * 0.3 + 2e3 * 10.0) / 6e3
    low, high = fit.relaxation_time_interval
    assert low < mean < high
    assert fit.covariance.shape == (5, 5)


def test_times_may_come_in_any_order_and_any_units():
    t, values = measured()
    order = np.random.default_rng(0).permutation(t.size)
    fit = rsph.materials.from_relaxation(1e3 * t[order], 1e-6 * values[order])
    assert fit.young_modulus == pytest.approx(0.02, rel=1e-6)
    assert fit.relaxation_time == pytest.approx(1500.0, rel=1e-6)


def test_a_measurement_that_is_too_short_says_so():
    rng = np.random.default_rng(5)
    with pytest.warns(rsph.RsphWarning, match="too short"):
        rsph.materials.from_relaxation(*measured(rng, 200.0, time=8.0, until=4.0))


@pytest.mark.parametrize(
    ("t", "values"),
    [
        ([1, 2, 3], [1, 2, 3]),
        ([0, 1, 2, 3], [1, 2, 3]),
        ([[0, 1, 2, 3]], [[1, 2, 3, 4]]),
        ([0, 1, 2, np.nan], [4, 3, 2, 1]),
        ([-1, 1, 2, 3], [4, 3, 2, 1]),
        ([1, 1, 1, 1], [4, 3, 2, 1]),
        (["a", "b", "c", "d"], [4, 3, 2, 1]),
    ],
)
def test_what_is_no_measurement_is_refused(t, values):
    with pytest.raises(rsph.InputError):
        rsph.materials.from_relaxation(t, values)


def test_wrong_options_are_refused():
    t, values = measured()
    with pytest.raises(rsph.InputError, match="confidence"):
        rsph.materials.from_relaxation(t, values, confidence=95)
    with pytest.raises(rsph.InputError, match="sigma"):
        rsph.materials.from_relaxation(t, values, sigma=0.0)
    with pytest.raises(rsph.InputError, match="poisson_ratio"):
        rsph.materials.from_relaxation(t, values, poisson_ratio=0.5)


def test_the_whole_series_is_handed_over_with_its_uncertainty():
    rng = np.random.default_rng(11)
    t = np.geomspace(0.01, 60.0, 120)
    truth = 1e4 * (1 + 0.8 * np.exp(-t / 0.2) + 0.5 * np.exp(-t / 5.0))
    expected, draws = np.array([[0.8, 0.2], [0.5, 5.0]]), 100
    held, values, errors = np.zeros((2, 2)), [], []
    for _ in range(draws):
        fit = rsph.materials.from_relaxation(t, truth + 50.0 * rng.standard_normal(t.size), terms=2)
        low, high = fit.prony_intervals
        held += (low <= expected) & (expected <= high)
        values.append(fit.prony)
        errors.append(fit.prony_errors)
    assert (np.abs(held - 0.95 * draws) < 3 * np.sqrt(draws * 0.95 * 0.05)).all(), held
    np.testing.assert_allclose(np.mean(errors, 0), np.std(values, 0), rtol=0.2)
    np.testing.assert_allclose(np.mean(values, 0), expected, rtol=0.02)
    # The limit and the series are the fitted modulus.
    share, time = fit.prony.T
    series = fit.young_modulus * (1 + np.exp(-t[:, None] / time) @ share)
    np.testing.assert_allclose(fit.modulus(t), series, rtol=1e-12)


def test_a_material_of_any_law_relaxes_by_the_series():
    fit = rsph.materials.from_relaxation(*measured(), density=1060.0, poisson_ratio=0.45)
    solid = fit.viscoelastic()
    assert solid.model == "neo-hookean"
    assert solid.parameters["young_modulus"] == pytest.approx(2e4, rel=1e-6)
    assert solid.parameters["relaxation_time"] == 0.0
    np.testing.assert_allclose(solid.parameters["prony"], [[0.5, 1.5]], rtol=1e-6)
    tissue = rsph.materials.Yeoh(density=1000.0, c1=500.0, c2=80.0, poisson_ratio=0.49)
    relaxing = fit.viscoelastic(tissue)
    assert relaxing.model == "yeoh"
    np.testing.assert_allclose(relaxing.parameters["prony"], [[0.5, 1.5]], rtol=1e-6)
    # At rest it is the law itself.
    stretch = [0.8, 1.0, 1.3]
    np.testing.assert_array_equal(relaxing.stress(stretch), tissue.stress(stretch))


def test_a_bar_that_is_held_relaxes_along_the_series():
    series = [(0.5, 0.2), (0.25, 2.0)]
    material = rsph.materials.KelvinVoigt(
        density=1e-3,
        young_modulus=1000.0,
        poisson_ratio=0.3,
        relaxation_time=0.0,
        prony=series,
    )
    assert material.parameters["prony"] == [list(term) for term in series]

    def face(axis, at=0.0, side="below"):
        return rsph.regions.plane(axis=axis, at=at, side=side)

    ramp = rsph.loads.Curve(time=[0.0, 0.2], value=[0.0, 1.0])
    sim = rsph.Simulation(
        shape=rsph.shapes.Box(size=(0.1, 0.1, 0.1)),
        spacing=0.025,
        material=material,
        boundaries=[
            *[rsph.boundaries.Clamp(region=face(axis), fix=["normal"]) for axis in "xyz"],
            rsph.boundaries.Prescribed(
                region=face("z", 0.1, "above"),
                fix=["normal"],
                motion=rsph.boundaries.Follow(displacement=(0.0, 0.0, 0.001), curve=ramp),
                name="grip",
            ),
        ],
        integrator="sdirk2",
        dt=0.02,
    )
    for t in (0.4, 1.0, 2.0):
        sim.run(until=t)
        # Of strain that grows evenly for .2 s.
        left = sum(
            share * time / 0.2 * (np.exp((0.2 - t) / time) - np.exp(-t / time))
            for share, time in series
        )
        exact = 1000.0 * 0.01 * 0.01 * (1.0 + left)
        assert sim.probes()["grip_force_z"] == pytest.approx(exact, rel=2e-3)
