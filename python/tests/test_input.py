"""Wrong input: what is raised, and what it says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rsph
from rsph import boundaries, loads, regions, shapes

from conftest import BOTTOM, ROOT, cube, material, pulled

CASES = {
    "material.poisson_ratio": lambda: material(poisson_ratio=0.5),
    "material.density": lambda: material(density=float("nan")),
    "material.model": lambda: rsph.materials.model("rubber", density=1.0),
    "material.young_modulos": lambda: rsph.materials.model("kelvin-voigt", young_modulos=1.0),
    "body.shape.box.size": lambda: shapes.Box(size=(1, 1)),
    "body.shape.sphere.radius": lambda: shapes.Sphere(radius=-1),
    "body.shape.cylinder.axis": lambda: shapes.Cylinder(radius=1, height=1, axis="w"),
    "body.shape.organ": lambda: shapes.Organ("heart"),
    "body.shape.mesh.path": lambda: shapes.Mesh("no_such_file.stl"),
    "body.shape.mesh": lambda: shapes.Mesh(),
    "body.spacing": lambda: cube(spacing=-1.0),
    "body.particles": lambda: cube(particles=100),
    "region.ball.radius": lambda: regions.ball(centre=(0, 0, 0), radius=-1),
    "region.half_space.normal": lambda: regions.half_space(point=(0, 0, 0), normal=(0, 0, 0)),
    "region.plane.axis": lambda: regions.plane(axis="w", at=0, side="below"),
    "boundary.fix": lambda: boundaries.Clamp(region=BOTTOM, fix=[]),
    "boundary.motion.ramp.to": lambda: boundaries.Prescribed(
        region=BOTTOM, motion=boundaries.RampTo(displacement=(0, 0, 1), start=1, end=1)
    ),
    "load.ramp": lambda: loads.BodyForce(acceleration=(0, 0, 1), ramp=3.0),
    "load.ramp.to": lambda: loads.BodyForce(acceleration=(0, 0, 1), ramp=(1, 0)),
    "load.curve.time": lambda: loads.BodyForce(
        acceleration=(0, 0, 1), curve=loads.Curve(time=[0, 1, 1], value=[0, 1, 2])
    ),
    "load.curve.value": lambda: loads.BodyForce(
        acceleration=(0, 0, 1), curve=loads.Curve(time=[0, 1], value="up")
    ),
    "load.curve": lambda: loads.BodyForce(
        acceleration=(0, 0, 1), ramp=(0, 1), curve=loads.Curve(time=[0, 1], value=[0, 1])
    ),
    "boundary.motion.curve.time": lambda: boundaries.Prescribed(
        region=BOTTOM,
        motion=boundaries.Follow(
            displacement=(0, 0, 1), curve=loads.Curve(time=[0.0], value=[1.0])
        ),
    ),
    "foundation.normal": lambda: boundaries.Foundation(region=BOTTOM, normal="soft"),
    "foundation[0].tangential": lambda: cube(
        foundations=[boundaries.Foundation(region=BOTTOM, tangential=-1.0)]
    ),
    "foundations[0]": lambda: cube(foundations=[boundaries.Clamp(region=BOTTOM)]),
    "load.traction": lambda: loads.Traction(region=BOTTOM, traction="up"),
    "load.radius": lambda: loads.Patch(pressure=1, centre=(0, 0, 0), direction=(0, 1, 0), radius=0),
    "probe.quantity": lambda: rsph.Probe(name="p", quantity="displacment", region=BOTTOM),
    "loads": lambda: cube(loads=loads.BodyForce(acceleration=(0, 0, 1))),
    "loads[0]": lambda: cube(loads=[BOTTOM]),
    "shape": lambda: cube(shape="liver"),
    "material": lambda: cube(material="kelvin-voigt"),
    "time.dt": lambda: cube(dt=1.0),
    "solver.smoothing": lambda: cube(smoothing=3.0),
    "solver.formulation": lambda: cube(formulation="exact"),
    "initial.velocity": lambda: cube(initial_velocity="fast"),
    "initial_velocity": lambda: cube(initial_velocity=lambda x: x[:, 0]),
    "initial_displacement": lambda: cube(initial_displacement=lambda x: x * np.inf),
    "boundary[0].region": lambda: cube(
        boundaries=[boundaries.Clamp(region=regions.ball(centre=(9, 9, 9), radius=0.1))]
    ),
    "until": lambda: cube().run(),
    "every": lambda: cube().run(until=1.0, every=0.0),
    "n": lambda: cube().step(-1),
}


@pytest.mark.parametrize("key", CASES)
def test_wrong_input_is_named_with_a_remedy(key):
    with pytest.raises(rsph.InputError) as e:
        CASES[key]()
    assert e.value.key == key, str(e.value)
    assert e.value.remedy
    assert e.value.remedy in str(e.value)
    assert isinstance(e.value, ValueError)


def test_messages_are_those_of_the_command_line(tmp_path):
    with pytest.raises(rsph.InputError) as in_python:
        material(poisson_ratio=0.7)
    text = (ROOT / "scenarios" / "tensile_liver.toml").read_text()
    path = tmp_path / "wrong.toml"
    lines = ["poisson_ratio = 0.7" if x.startswith("poisson") else x for x in text.split("\n")]
    path.write_text("\n".join(lines))
    with pytest.raises(rsph.InputError) as in_file:
        rsph.Simulation.from_toml(path)
    assert str(in_file.value).endswith(str(in_python.value))
    line = lines.index("poisson_ratio = 0.7") + 1
    assert f"wrong.toml:{line}:" in str(in_file.value)
    assert in_file.value.value == "0.7"


def test_overrides_that_do_not_fit_are_named():
    path = ROOT / "scenarios" / "tensile_liver.toml"
    with pytest.raises(rsph.InputError, match="until"):
        rsph.Simulation.from_toml(path, overrides={"time.until": "soon"})
    with pytest.raises(rsph.InputError, match="means nothing"):
        rsph.Simulation.from_toml(path, overrides={"time.until": object()})


def test_errors_of_a_users_function_come_through():
    def broken(_):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        cube(initial_velocity=broken)


def test_an_unstable_step_is_taken_on_request_with_a_warning_and_fails():
    with pytest.warns(rsph.RsphWarning, match="stability limit"):
        sim = pulled(dt=0.1, allow_unstable=True)
    with pytest.raises(rsph.SimulationError):
        sim.run(until=100.0)


def test_missing_fields_are_named(sim):
    snapshot = sim.snapshot()
    with pytest.raises(rsph.MissingFieldError, match="displacement"):
        snapshot["temperature"]


def key_of_error(make):
    """The key of the error that ``make`` raises; empty if it raises none."""
    try:
        make()
    except rsph.InputError as e:
        return e.key
    return ""


@given(st.text())
def test_any_text_is_met_at_the_door(text):
    def make():
        rsph.Probe(name=text, quantity="mass", region=regions.everywhere)

    assert key_of_error(make) in ("", "probe.name")


@given(st.floats(), st.floats())
def test_any_number_is_met_at_the_door(at, radius):
    def make():
        regions.plane(axis="x", at=at, side="below")
        regions.ball(centre=(at, at, at), radius=radius)

    key = key_of_error(make)
    assert key == "" or key.startswith("region.")
    assert (key == "") == (np.isfinite([at, radius]).all() and radius > 0)
