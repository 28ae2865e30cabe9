"""Laws of tissue through the installed package: bars that are pulled, against closed forms."""

import warnings

import numpy as np
import pytest

import rsph

TRACTION = 2000.0
VOLUME = {"density": 1000.0, "bulk_modulus": 5e6}

# dw/dI1 and dw/dI2 by the stretch s of an incompressible bar, and for Ogden s times dw/ds.
LAWS = {
    "mooney-rivlin": (
        lambda: rsph.materials.MooneyRivlin(c10=400.0, c01=100.0, **VOLUME),
        lambda i1: (400.0, 100.0),
    ),
    "yeoh": (
        lambda: rsph.materials.Yeoh(c1=500.0, c2=50.0, c3=20.0, **VOLUME),
        lambda i1: (500.0 + 100.0 * (i1 - 3) + 60.0 * (i1 - 3) ** 2, 0.0),
    ),
    "veronda-westmann": (
        lambda: rsph.materials.VerondaWestmann(c1=800.0, c2=1.5, **VOLUME),
        lambda i1: (1200.0 * np.exp(1.5 * (i1 - 3)), -600.0),
    ),
    "fung": (
        lambda: rsph.materials.Fung(shear_modulus=1000.0, exponent=2.0, **VOLUME),
        lambda i1: (500.0 * np.exp(2.0 * (i1 - 3)), 0.0),
    ),
    "ogden": (
        lambda: rsph.materials.Ogden(moduli=[1000.0], exponents=[2.0], **VOLUME),
        lambda i1: (500.0, 0.0),
    ),
    # Fibres across the bar are slack: the ground alone.
    "holzapfel-gasser-ogden": (
        lambda: rsph.materials.HolzapfelGasserOgden(
            shear_modulus=1000.0, k1=5000.0, k2=1.0, fibre=(0, 1, 0), **VOLUME
        ),
        lambda i1: (500.0, 0.0),
    ),
}


@pytest.mark.parametrize("name", LAWS)
def test_a_pulled_bar_has_its_closed_form(name):
    material, slopes = LAWS[name]
    side = {axis: rsph.regions.plane(axis=axis, at=0.0, side="below") for axis in "xyz"}
    end = rsph.regions.plane(axis="z", at=1.0, side="above")
    sim = rsph.Simulation(
        shape=rsph.shapes.Box(size=(1, 1, 1)),
        spacing=0.25,
        material=material(),
        boundaries=[rsph.boundaries.Clamp(region=side[axis], fix=[axis]) for axis in "xyz"],
        loads=[rsph.loads.Traction(region=end, traction=(0, 0, TRACTION))],
        probes=[rsph.Probe(name="extension", quantity="displacement.z", region=end)],
    )
    assert sim.solve_static().newton_steps > 1
    s = 1 + sim.probes()["extension"]
    w1, w2 = slopes(s**2 + 2 / s)
    # The nominal stress of an incompressible bar; the volume changes by 1e-4.
    assert 2 * (s - s**-2) * (w1 + w2 / s) == pytest.approx(TRACTION, rel=1e-3)


def test_a_linear_law_beyond_its_range_warns():
    below, above = (
        rsph.regions.plane(axis="z", at=0.0, side="below"),
        rsph.regions.plane(axis="z", at=1.0, side="above"),
    )

    def pulled(material, traction):
        return rsph.Simulation(
            shape=rsph.shapes.Box(size=(1, 1, 1)),
            spacing=0.25,
            material=material,
            boundaries=[rsph.boundaries.Clamp(region=below)],
            loads=[rsph.loads.Traction(region=above, traction=(0, 0, traction))],
        )

    kelvin_voigt = rsph.materials.KelvinVoigt(
        density=1000.0, young_modulus=1e4, poisson_ratio=0.3, relaxation_time=0.0
    )
    sim = pulled(kelvin_voigt, 8e3)
    with pytest.warns(rsph.RsphWarning, match=r"strained by [01]\.\d+ at .*neo-hookean"):
        sim.solve_static()
    assert len(sim.notes) == 1
    # Nothing is said of small strain, nor of a law for large strain.
    for quiet in (pulled(kelvin_voigt, 100.0), pulled(large(), 8e3)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            quiet.solve_static()
        assert quiet.notes == []


def large():
    return rsph.materials.NeoHookean(
        density=1000.0, young_modulus=1e4, poisson_ratio=0.3, relaxation_time=0.0
    )


def test_a_law_without_its_volume_is_refused():
    with pytest.raises(rsph.InputError, match="bulk_modulus"):
        rsph.materials.Yeoh(density=1000.0, c1=500.0)
    with pytest.raises(rsph.InputError, match="exclude each other"):
        rsph.materials.Yeoh(density=1000.0, c1=500.0, bulk_modulus=1e6, poisson_ratio=0.4)
    with pytest.raises(rsph.InputError, match="every term has a modulus and an exponent"):
        rsph.materials.Ogden(density=1.0, moduli=[1.0, 2.0], exponents=[2.0], poisson_ratio=0.4)
    with pytest.raises(rsph.InputError, match="direction"):
        rsph.materials.model(
            "holzapfel-gasser-ogden",
            density=1.0,
            shear_modulus=1.0,
            k1=1.0,
            k2=1.0,
            fibre=(0, 0, 0),
            poisson_ratio=0.4,
        )


def test_a_named_boundary_tells_its_force():
    """A bar with nu = 0, E A d / L = 1 N; validation of the case reaction-per-boundary."""
    lower, upper = (
        rsph.regions.plane(axis="z", at=0.0, side="below"),
        rsph.regions.plane(axis="z", at=0.1, side="above"),
    )
    sim = rsph.Simulation(
        shape=rsph.shapes.Box(size=(0.1, 0.1, 0.1)),
        spacing=0.0125,
        material=rsph.materials.KelvinVoigt(
            density=1000.0, young_modulus=1e4, poisson_ratio=0.0, relaxation_time=0.2
        ),
        boundaries=[
            rsph.boundaries.Clamp(region=lower, name="lower"),
            rsph.boundaries.Prescribed(
                region=upper,
                motion=rsph.boundaries.RampTo(displacement=(0, 0, 0.001), end=1.0),
                name="upper",
            ),
        ],
    )
    sim.solve_static(time=1.0)
    forces = sim.probes()
    assert forces["upper_force_z"] == pytest.approx(1.0, rel=1e-6)
    assert forces["lower_force_z"] == pytest.approx(-1.0, rel=1e-6)

    # A stiffer bar carries more; another density is another body.
    stiffer = {"young_modulus": 2e4, "poisson_ratio": 0.0, "relaxation_time": 0.2}
    sim.set_material(rsph.materials.KelvinVoigt(density=1000.0, **stiffer))
    sim.solve_static()
    assert sim.probes()["upper_force_z"] == pytest.approx(2.0, rel=1e-6)
    with pytest.raises(rsph.InputError, match="density"):
        sim.set_material(rsph.materials.KelvinVoigt(density=900.0, **stiffer))


def test_fibres_along_a_field():
    def around(x):
        return np.stack([-x[:, 1], x[:, 0], np.zeros(len(x))], axis=1)

    def inflated(fibres):
        fibred = rsph.materials.HolzapfelGasserOgden(
            density=1000.0,
            shear_modulus=1e4,
            k1=5e4,
            k2=1.0,
            fibre=(1.0, 0.0, 0.0),
            poisson_ratio=0.45,
        )
        part = rsph.materials.Part(material=fibred, fibres=fibres)
        sim = rsph.Simulation(
            shape=rsph.shapes.Box(size=(0.1, 0.1, 0.1), corner=(0.05, 0.0, 0.0)),
            spacing=0.02,
            material=part,
            boundaries=[
                rsph.boundaries.Clamp(region=rsph.regions.plane(axis="z", at=0.0, side="below"))
            ],
            loads=[rsph.loads.BodyForce(acceleration=(30.0, 0.0, 0.0))],
        )
        sim.solve_static()
        return sim.snapshot().displacement

    function = inflated(around)
    rotation = inflated(rsph.fields.Rotation(rate=(0.0, 0.0, 2.0)))
    np.testing.assert_allclose(function, rotation, atol=1e-9)
    assert not np.allclose(function, inflated(None), rtol=0.05)
    with pytest.raises(rsph.InputError, match=r"material\.fibres"):
        inflated((0.0, 0.0, 0.0))
