"""Forces and moments, measures of deformation, and strain gauges."""

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
    sim.solve_static(1.0)
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
    sim.solve_static(1.0)
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
