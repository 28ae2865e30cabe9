"""Loads, observers and probes that come from Python, and copies."""

import copy
import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import rsph
from rsph.loads import Custom

from conftest import BOTTOM, ROOT, TOP, cube, material, pulled

PRESSURE = 2.0


def ball(**changes):
    values = {
        "shape": rsph.shapes.Sphere(radius=0.5),
        "spacing": 0.15,
        "material": material(),
        "units": "normalised",
    }
    return rsph.Simulation(**(values | changes))


def meshed(**changes):
    """A cube whose loads go by the triangles of its surface, which are coarse."""
    box = rsph.shapes.Box(size=(1, 1, 1))
    mesh = rsph.shapes.Mesh(vertices=box.vertices, triangles=box.triangles)
    return ball(**({"shape": mesh, "spacing": 0.2} | changes))


def inward(_, points):
    return -PRESSURE * points.areas[:, None] * points.normals


def same(a, b, tolerance):
    u, v = (s.snapshot().displacement for s in (a, b))
    scale = np.abs(u).max()
    assert scale > 0.0
    assert np.abs(u - v).max() <= tolerance * scale


@pytest.mark.parametrize("options", [{}, {"remesh_every": 20}, {"large": True}])
def test_a_pressure_by_a_function_is_the_pressure(options):
    options = dict(options)
    if options.pop("large", False):
        options["material"] = rsph.materials.NeoHookean(
            density=1.0, young_modulus=100.0, poisson_ratio=0.3, relaxation_time=0.2
        )
    everywhere = rsph.regions.everywhere
    built_in = meshed(loads=[rsph.loads.Pressure(region=everywhere, pressure=PRESSURE)], **options)
    custom = meshed(loads=[Custom(inward)], **options)
    for sim in (built_in, custom):
        sim.run(until=0.06)
        sim.step(3)
    assert custom.steps > 30
    same(built_in, custom, 1e-10)


def test_a_fine_surface_has_fewer_points_and_nearly_the_same_forces():
    everywhere = rsph.regions.everywhere
    built_in = ball(loads=[rsph.loads.Pressure(region=everywhere, pressure=PRESSURE)])
    custom = ball(loads=[Custom(inward)])
    for sim in (built_in, custom):
        sim.run(until=0.06)
    same(built_in, custom, 0.01)
    # A closed surface under equal pressure is not pushed anywhere.
    np.testing.assert_allclose(custom.conservation()["load"], 0.0, atol=1e-12)


def test_a_body_force_by_a_function_is_the_body_force():
    gravity = np.array([0.0, 0.0, -3.0])
    built_in = pulled(loads=[rsph.loads.BodyForce(acceleration=gravity)])
    custom = pulled(loads=[])
    custom.set_load(lambda t, p: p.mass[:, None] * gravity, on="particles")
    for sim in (built_in, custom):
        sim.run(until=0.1)
    same(built_in, custom, 1e-10)
    np.testing.assert_allclose(custom.conservation()["load"], gravity, atol=1e-12)
    still = [pulled(loads=[rsph.loads.BodyForce(acceleration=gravity)]), pulled(loads=[])]
    still[1].set_load(Custom(lambda t, p: p.mass[:, None] * gravity, on="particles"))
    for sim in still:
        sim.solve_static()
    same(*still, 1e-10)


def test_a_function_is_called_once_a_step_beside_the_other_loads():
    calls = []

    def load(t, points):
        calls.append((t, points))
        return np.zeros((len(points.mass), 3))

    plain, sim = pulled(), pulled()
    sim.set_load(load, on="particles")
    for s in (plain, sim):
        s.run(until=0.05)
    assert len(calls) == sim.steps + 1  # one for the step to come
    times = [t for t, _ in calls]
    assert times[0] == 0.0
    assert times[-1] == 0.05
    assert all(t == p.time for t, p in calls)
    same(plain, sim, 0.0)
    last, snapshot = calls[-1][1], sim.snapshot()
    np.testing.assert_array_equal(last.positions, snapshot.positions)
    np.testing.assert_array_equal(last.velocity, snapshot.velocity)
    np.testing.assert_array_equal(last.volume, snapshot.volume)
    assert last.normals is None
    with pytest.raises(ValueError, match="read-only"):
        last.reference[0] = 1.0
    sim.step(2)
    assert len(calls) == sim.steps
    sim.set_load(None)
    sim.step(2)
    assert len(calls) == sim.steps - 2


def test_points_of_the_surface_cover_it():
    seen = []

    def load(t, points):
        seen.append(points)
        return np.zeros_like(points.reference)

    sim = ball(loads=[Custom(load)], initial_displacement=rsph.fields.Affine(gradient=np.eye(3)))
    sim.step()
    points = seen[0]
    assert points.areas.sum() == pytest.approx(np.pi, rel=0.01)
    np.testing.assert_allclose(np.linalg.norm(points.normals, axis=1), 1.0, rtol=1e-12)
    # A linear displacement is exact on the surface.
    np.testing.assert_allclose(points.positions, 2.0 * points.reference, atol=1e-12)
    assert points.mass is None


@pytest.mark.parametrize(
    ("load", "message"),
    [
        (lambda t, p: np.zeros(3), "is needed"),
        (lambda t, p: np.zeros((7, 3)), "is needed"),
        (lambda t, p: np.full_like(p.reference, np.nan), "not finite"),
        (lambda t, p: p.displacement[:, :2], "is needed"),
    ],
)
def test_forces_that_are_none_stop_the_run(load, message):
    sim = pulled()
    sim.set_load(load)
    with pytest.raises(rsph.InputError, match=message):
        sim.run(until=1.0)
    assert sim.steps == 0
    sim.set_load(None)
    sim.step()


def test_errors_of_a_load_come_through_and_the_run_can_go_on():
    def late(t, points):
        if t > 0.01:
            raise ZeroDivisionError("mine")
        return np.zeros_like(points.reference)

    sim = pulled()
    sim.set_load(late)
    with pytest.raises(ZeroDivisionError, match="mine"):
        sim.run(until=1.0)
    assert 0.01 < sim.time < 0.1
    with pytest.raises(rsph.InputError, match="no function"):
        sim.set_load(3.0)
    with pytest.raises(rsph.InputError, match="surface"):
        sim.set_load(late, on="top")
    with pytest.raises(rsph.InputError, match="2 functions"):
        pulled(loads=[Custom(late), Custom(late)])
    sim.set_load(None)
    sim.step()
    prescribed = rsph.Simulation.from_toml(
        ROOT / "scenarios" / "deformation.toml", overrides={"body.particles": 500}
    )
    with pytest.raises(rsph.InputError, match="takes no forces"):
        prescribed.set_load(late)


def test_observers_see_every_frame_or_every_step():
    frames, steps = [], []
    sim = pulled()
    sim.run(until=0.1, every=0.03, observe=frames.append)
    assert [f.time for f in frames] == pytest.approx([0.03, 0.06, 0.09, 0.1])
    assert all(isinstance(f, rsph.Snapshot) for f in frames)
    first = sim.steps
    sim.run(until=0.15, every="step", observe=steps.append)
    assert [s.step for s in steps] == list(range(first + 1, sim.steps + 1))
    assert steps[-1].stress.shape == (125, 6)
    assert (steps[-1].displacement == sim.snapshot().displacement).all()
    plain = pulled()
    plain.run(until=0.03)
    assert (plain.snapshot().displacement == frames[0].displacement).all()
    with pytest.raises(rsph.InputError, match="every"):
        sim.run(until=0.2, every="frame", observe=steps.append)
    with pytest.raises(rsph.InputError, match="observe"):
        sim.run(until=0.2, every="step", callback=steps.append)

    def stop(snapshot):
        raise KeyError(snapshot.step)

    with pytest.raises(KeyError):
        sim.run(until=0.2, every="step", observe=stop)
    assert sim.steps == steps[-1].step + 1


@pytest.mark.parametrize("changes", [{}, {"remesh_every": 10, "dt": 0.0005}, {"large": True}])
def test_probes_can_be_added(changes):
    changes = dict(changes)
    if changes.pop("large", False):
        changes["material"] = rsph.materials.NeoHookean(
            density=1.0, young_modulus=100.0, poisson_ratio=0.3, relaxation_time=0.2
        )
    both = [
        rsph.Probe(name="extension", quantity="displacement.z", region=TOP),
        rsph.Probe(name="tip", quantity="velocity", region=rsph.regions.point(at=(0.5, 0.5, 1))),
    ]
    sim, given = pulled(**changes), pulled(probes=both, **changes)
    sim.run(until=0.05)
    sim.add_probe(both[1])
    later, all_along = sim.run(until=0.1), given.run(until=0.1)
    names = ["time", "extension", "tip_x", "tip_y", "tip_z"]
    assert [n for n in later if n != "volume_inside"] == names
    before = later["time"] <= 0.05
    assert np.isnan(later["tip_z"][before]).all()
    assert np.isfinite(later["tip_z"][~before]).all()
    assert later["tip_z"][-1] == pytest.approx(all_along["tip_z"][-1], rel=1e-6)
    with pytest.raises(rsph.InputError, match="of that name"):
        sim.add_probe(both[1])
    nowhere = rsph.Probe(name="n", quantity="mass", region=rsph.regions.point(at=(9, 9, 9)))
    with pytest.raises(rsph.InputError, match="region"):
        sim.add_probe(nowhere)
    with pytest.raises(rsph.InputError, match="probe"):
        sim.add_probe(BOTTOM)


@pytest.mark.parametrize(
    "make",
    [
        pulled,
        lambda: pulled(integrator="sdirk2"),
        lambda: pulled(integrator="rkc2", dt=0.005),
        lambda: pulled(remesh_every=7, dt=0.0005),
        lambda: pulled(formulation="paper", dt=1e-3, smoothing=1.25),
        lambda: ball(loads=[Custom(inward)], spacing=0.25),
        lambda: ball(
            material=rsph.materials.NeoHookean(
                density=1.0, young_modulus=100.0, poisson_ratio=0.3, relaxation_time=0.2
            ),
            remesh_every=15,
            initial_velocity=lambda x: x @ np.diag([1.0, -0.5, -0.5]),
        ),
    ],
)
@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_a_copy_goes_on_bit_by_bit(make, copied):
    sim = make()
    sim.run(until=0.01)
    sim.step(2)
    twin = copied(sim)
    end = sim.time + 0.02
    for s in (sim, twin):
        s.run(until=end)
    assert sim.steps == twin.steps
    a, b = sim.snapshot(), twin.snapshot()
    for field in a.fields:
        np.testing.assert_array_equal(a[field], b[field], err_msg=field)
    for name, values in sim.history().items():
        np.testing.assert_array_equal(values, twin.history()[name])
    # They are two.
    twin.step()
    assert twin.steps == sim.steps + 1
    assert (sim.snapshot().displacement == a.displacement).all()


def test_a_running_simulation_is_not_pickled(sim):
    with pytest.raises(TypeError, match="Scenario"):
        pickle.dumps(sim)


@pytest.mark.parametrize(
    "shape",
    [
        rsph.shapes.Box(size=(1, 2, 3)),
        rsph.shapes.Sphere(radius=0.5),
        rsph.shapes.Cylinder(radius=0.5, height=1.0, axis="x"),
        rsph.shapes.Rectangle(size=(1, 2)),
        rsph.shapes.Disc(radius=1.0),
        rsph.shapes.Polygon([(0, 0), (2, 0), (1, 1)]),
        rsph.shapes.Organ("kidney"),
        rsph.shapes.Mask(np.pad(np.ones((5, 5, 5), dtype=bool), 1), 0.1),
    ],
)
def test_shapes_and_errors_are_pickled(shape):
    again = pickle.loads(pickle.dumps(shape))
    assert again.volume == pytest.approx(shape.volume, rel=1e-12)
    np.testing.assert_allclose(again.bounds, shape.bounds, rtol=1e-12)
    with pytest.raises(rsph.InputError) as e:
        cube(spacing=-1.0)
    error = pickle.loads(pickle.dumps(e.value))
    assert (type(error), str(error), error.key) == (rsph.InputError, str(e.value), "body.spacing")


INTERRUPTED = {
    "run": "sim = cube(spacing=1 / 24, dt=1e-6); ready(); sim.run(until=100.0)",
    "step": "sim = cube(spacing=1 / 24, dt=1e-6); ready(); sim.step(10**9)",
    "implicit": "sim = implicit(); ready(); sim.run(until=1e5)",
    "static": "sim = thin(); ready(); [sim.solve_static(time=float(k)) for k in range(10**6)]",
    "construction": "ready(); cube(spacing=1 / 90)",
    "scenario": "s = scenario(); ready(); s._run(None)",
    "load": "sim = cube(); sim.set_load(lambda t, p: 0 * p.velocity); ready(); sim.run(until=1e5)",
}

PRELUDE = """
import sys, numpy as np
import rsph
from conftest import ROOT, cube, pulled

def thin():
    material = rsph.materials.KelvinVoigt(
        density=1.0, young_modulus=100.0, poisson_ratio=0.49, relaxation_time=0.2
    )
    clamp = rsph.regions.plane(axis="x", at=0.0, side="below")
    return rsph.Simulation(
        shape=rsph.shapes.Box(size=(4, 1, 1)), spacing=1 / 18, material=material,
        boundaries=[rsph.boundaries.Clamp(region=clamp)],
        loads=[rsph.loads.BodyForce(acceleration=(0, 0, 1), ramp=(0, 1e7))],
    )

def implicit():
    return cube(spacing=0.05, integrator="sdirk2", dt=0.01)

def scenario():
    changes = {"time.until": 1e4, "time.integrator": "rk4", "output.every": 1e3}
    return rsph.Scenario.from_toml(ROOT / "scenarios/tensile_liver.toml", overrides=changes)

def ready():
    print("ready", flush=True)
"""


def seconds_until_interrupted(what):
    """Wall time (s) from SIGINT to KeyboardInterrupt in a process of its own."""
    stopped = "except KeyboardInterrupt:\n    print('stopped', flush=True)"
    body = f"try:\n    {INTERRUPTED[what]}\n{stopped}"
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", f"{PRELUDE}\n{body}"],
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parent)},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.3)
        assert process.poll() is None, "it ended before it was interrupted"
        start = time.perf_counter()
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "stopped\n"
        return time.perf_counter() - start
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("what", INTERRUPTED)
def test_ctrl_c_ends_everything_within_half_a_second(what):
    # A machine that is busy otherwise gets another try.
    assert any(seconds_until_interrupted(what) < 0.5 for _ in range(3))
