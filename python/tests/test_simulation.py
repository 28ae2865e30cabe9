"""Running, looking, stopping."""

import signal
import threading
import time

import numpy as np
import pytest

import rsph

from conftest import ROOT, cube, pulled


def test_arrays_are_views_that_nobody_can_write(sim):
    sim.step(3)
    snapshot = sim.snapshot()
    for name in snapshot.fields:
        array = snapshot[name]
        assert np.shares_memory(array, snapshot[name]), name
        assert array.shape[0] == len(snapshot) == 125
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
    # State that did not change is the same memory in two snapshots.
    assert np.shares_memory(snapshot.mass, sim.snapshot().mass)
    assert snapshot.displacement.shape == (125, 3)
    assert snapshot.stress.shape == (125, 6)
    np.testing.assert_array_equal(snapshot.positions, snapshot.reference + snapshot.displacement)


def test_a_snapshot_stays_when_the_simulation_goes_on(sim):
    sim.step(5)
    snapshot = sim.snapshot()
    u, kept = snapshot.displacement, snapshot.displacement.copy()
    sim.step(50)
    assert (u == kept).all()
    assert snapshot.step == 5
    assert not np.shares_memory(u, sim.snapshot().displacement)
    assert (sim.snapshot().displacement != kept).any()
    del snapshot, sim
    assert (u == kept).all()


def test_steps_and_times_are_counted(sim):
    assert (sim.time, sim.steps, sim.particles) == (0.0, 0, 125)
    assert sim.spacing == pytest.approx(0.2)
    sim.step()
    assert sim.time == sim.dt
    sim.run(until=0.05)
    assert sim.time == 0.05
    assert sim.dt <= sim.dt_limit
    assert sim.description.neighbours == 26
    assert "125 particles" in repr(sim)


def test_history_begins_and_ends_with_the_run_and_matches_the_probes(sim):
    history = sim.run(until=0.05)
    assert list(history) == ["time", "extension"]
    assert history["time"][0] == 0.0
    assert history["time"][-1] == 0.05
    assert (np.diff(history["time"]) > 0).all()
    assert history["extension"][-1] == sim.probes()["extension"]
    longer = sim.run(until=0.1)
    assert (longer["extension"][: len(history["time"])] == history["extension"]).all()


def test_vector_probes_have_three_columns():
    probe = rsph.Probe(name="tip", quantity="velocity", region=rsph.regions.point(at=(0.5, 0.5, 1)))
    sim = cube(probes=[probe], initial_velocity=(1, 2, 3))
    assert sim.probes() == pytest.approx({"tip_x": 1, "tip_y": 2, "tip_z": 3})


def test_callbacks_are_called_at_equal_times_and_may_look_and_stop(sim):
    times = []
    sim.run(until=0.1, every=0.03, callback=lambda s: times.append(s.snapshot().time))
    assert times == pytest.approx([0.03, 0.06, 0.09, 0.1])

    class StopError(Exception):
        pass

    def stop(_):
        raise StopError

    with pytest.raises(StopError):
        sim.run(until=1.0, callback=stop)
    assert sim.time < 1.0


def test_callbacks_and_progress_do_not_change_the_result_much(capsys):
    a, b = pulled(), pulled()
    a.run(until=0.1)
    b.run(until=0.1, progress=True)
    assert (a.snapshot().displacement == b.snapshot().displacement).all()
    assert "t = 0.1 of 0.1 (100%)" in capsys.readouterr().err


def test_ctrl_c_interrupts_within_half_a_second_and_the_run_can_go_on():
    sim = pulled(spacing=1 / 12, dt=1e-5)
    raised = []

    def interrupt():
        time.sleep(0.3)
        raised.append(time.perf_counter())
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        sim.run(until=100.0)
    late = time.perf_counter() - raised[0]
    thread.join()
    assert late < 0.5
    steps = sim.steps
    assert steps > 0
    sim.step()
    assert sim.steps == steps + 1


def test_other_threads_go_on_during_a_run_but_may_not_touch_it():
    sim = pulled(spacing=1 / 12, dt=1e-5)
    ticks, refused = [0], []

    def tick():
        end = time.perf_counter() + 0.5
        while time.perf_counter() < end:
            ticks[0] += 1
            time.sleep(0.01)
        try:
            sim.snapshot()
        except rsph.Error as e:
            refused.append(str(e))
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=tick)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        sim.run(until=100.0)
    thread.join()
    assert ticks[0] > 10
    assert "another thread" in refused[0]


def test_the_surface_is_closed_and_carries_fields(sim):
    sim.step(10)
    surface = sim.surface()
    v, t = surface.vertices, surface.triangles
    assert v.shape[1] == t.shape[1] == 3
    assert len(v) - 3 * len(t) / 2 + len(t) == 2  # Euler's number of a sphere
    a, b, c = v[t[:, 0]], v[t[:, 1]], v[t[:, 2]]
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(1.0, rel=0.2)
    assert surface["strain"].shape == (len(v), 6)
    assert surface["normal_strain"].shape == (len(v),)
    assert "stress" in surface.fields


def test_from_toml_runs_the_scenario_as_the_command_line_does():
    path = ROOT / "scenarios" / "tensile_liver.toml"
    sim = rsph.Simulation.from_toml(path, overrides={"time.until": 0.02, "body.particles": 125})
    assert sim.particles == 125
    history = sim.run()
    assert sim.time == 0.02
    assert history["extension"][-1] > 0


def test_the_paper_formulation_fails_and_says_when():
    sim = pulled(formulation="paper", dt=1e-3, spacing=1 / 7)
    with pytest.raises(rsph.SimulationError, match="help: ") as e:
        sim.run(until=10.0)
    assert 0 < e.value.time < 10
    assert e.value.step > 0
    assert e.value.remedy
    assert sim.time <= e.value.time
    assert np.isfinite(sim.snapshot().displacement).all()


def test_the_example_runs():
    import runpy

    example = runpy.run_path(str(ROOT / "python" / "examples" / "tensile.py"))
    sim = example["tensile"](spacing=0.25, until=0.05)
    assert sim.probes()["extension"] > 0
