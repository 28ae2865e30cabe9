"""Scenarios as values, runs into folders, sweeps."""

import pickle

import numpy as np
import pandas as pd
import pytest

import rsph

from conftest import BOTTOM, ROOT, TOP, material

TENSILE = ROOT / "scenarios" / "tensile_liver.toml"
COARSE = {"body.particles": 27, "time.until": 0.02, "output.every": 0.01}


def small():
    return rsph.Scenario.from_toml(TENSILE, overrides=COARSE)


def tables():
    return {
        "units": "normalised",
        "body": {"shape": rsph.shapes.Box(size=(1, 1, 1)), "spacing": np.float64(0.25)},
        "material": material(),
        "boundary": [rsph.boundaries.Clamp(region=BOTTOM)],
        "load": [rsph.loads.Traction(region=TOP, traction=np.array([0, 0, 1.0]))],
        "probe": [rsph.Probe(name="extension", quantity="displacement.z", region=TOP)],
        "initial": {"velocity": rsph.fields.Affine(gradient=np.zeros((3, 3)))},
        "time": {"until": 0.02},
    }


def test_a_scenario_is_a_value():
    scenario = small()
    assert (
        scenario == pickle.loads(pickle.dumps(scenario)) == rsph.Scenario.from_text(scenario.text)
    )
    stiff = scenario.changed({"material.young_modulus": 200.0})
    assert stiff != scenario
    assert "young_modulus = 200" in stiff.text
    assert len({scenario, stiff, small()}) == 2
    assert "tensile_liver.toml" in repr(stiff)
    assert rsph.Scenario.of(scenario) is scenario
    assert rsph.Scenario.of(scenario.text) == scenario
    assert rsph.Scenario.of(str(TENSILE)).changed(COARSE) == scenario


def test_tables_with_objects_in_them_are_a_scenario():
    scenario = rsph.Scenario(tables())
    sim = scenario.simulation()
    sim.run()
    assert sim.time == 0.02
    same = rsph.Simulation(
        shape=rsph.shapes.Box(size=(1, 1, 1)),
        spacing=0.25,
        material=material(),
        boundaries=[rsph.boundaries.Clamp(region=BOTTOM)],
        loads=[rsph.loads.Traction(region=TOP, traction=(0, 0, 1))],
        units="normalised",
    )
    same.run(until=0.02)
    assert (sim.snapshot().displacement == same.snapshot().displacement).all()
    saved = rsph.Scenario.from_text(scenario.text)
    assert saved.simulation().particles == 64


def test_what_is_no_scenario_is_refused(tmp_path):
    with pytest.raises(rsph.InputError, match="did you mean `young_modulus`"):
        small().changed({"material.young_modulos": 1.0})
    with pytest.raises(rsph.InputError, match="no_such"):
        rsph.Scenario.from_toml(tmp_path / "no_such.toml")
    box = rsph.shapes.Box(size=(1, 1, 1))
    shape = rsph.shapes.Mesh(vertices=box.vertices, triangles=box.triangles)
    wrong = tables() | {"body": {"shape": shape, "spacing": 0.2}}
    with pytest.raises(rsph.InputError, match="no words in a scenario"):
        rsph.Scenario(wrong)
    with pytest.raises(rsph.InputError, match="body"):
        rsph.Scenario({"time": {"until": 1.0}})


def test_a_run_leaves_a_folder_that_is_read(tmp_path, capsys):
    run = small().run(tmp_path / "out", progress=True)
    assert "(100%)" in capsys.readouterr().err
    assert run.summary["status"] == "finished"
    assert run.scenario.text == small().text
    history = run.history
    assert list(history) == ["time", "extension"]
    assert history["time"][-1] == 0.02
    assert len(run.particles) == 3
    assert isinstance(run.surface[-1], rsph.Surface)
    sim = small().simulation()
    sim.run(until=0.01)
    sim.run(until=0.02)
    assert (run.particles[-1]["stress"] == sim.snapshot().stress).all()
    with pytest.raises(rsph.InputError, match="holds results"):
        small().run(tmp_path / "out")
    small().run(tmp_path / "out", force=True)
    again = rsph.read(tmp_path / "out")
    assert again.summary["steps"] == run.summary["steps"]
    (tmp_path / "out" / "probes.csv").unlink()
    with pytest.raises(rsph.InputError, match=r"probes\.csv"):
        _ = again.history


def test_a_field_is_read_at_all_times_or_lazily(tmp_path):
    particles = small().run(tmp_path / "out").particles
    stress = particles["stress"]
    assert stress.shape == (3, 27, 6)
    assert (stress[-1] == particles[-1]["stress"]).all()
    assert (particles.field("displacement", -1) == particles[-1]["displacement"]).all()
    assert particles.points.tolist() == [27, 27, 27]
    with pytest.raises(rsph.MissingFieldError):
        particles["temperature"]

    dataset = particles.to_xarray()
    assert dict(dataset.sizes) == {"time": 3, "point": 27, "component": 3, "tensor": 6}
    # The file is gone: what was not used was not read.
    part = dataset["stress"].isel(time=slice(1, None), point=[3, 5]).sel(tensor="zz").load()
    np.testing.assert_array_equal(part, stress[1:, [3, 5], 2])
    np.testing.assert_array_equal(dataset["mass"].isel(time=-1), particles[-1]["mass"])
    assert dataset["mass"].isel(time=slice(0, 0)).shape == (0, 27)
    (tmp_path / "out" / "particles.vtkhdf").unlink()
    with pytest.raises(rsph.InputError):
        dataset["velocity"].load()


def test_a_sweep_is_a_tidy_table_of_all_combinations():
    parameters = {"material.young_modulus": [100.0, 200.0], "material.poisson_ratio": [0.0, 0.3]}
    table = rsph.sweep(small(), parameters, jobs=2)
    assert isinstance(table, pd.DataFrame)
    assert table["material.young_modulus"].tolist() == [100.0, 100.0, 200.0, 200.0]
    assert table["material.poisson_ratio"].tolist() == [0.0, 0.3, 0.0, 0.3]
    assert (table["status"] == "finished").all()
    assert (table["error"] == "").all()
    assert (table["particles"] == 27).all()
    assert "output" not in table
    for _, row in table.iterrows():
        changes = {key: row[key] for key in parameters}
        sim = small().changed(changes).simulation()
        sim.run(until=0.01)
        sim.run(until=0.02)
        assert row["extension"] == sim.probes()["extension"]


def test_failing_runs_are_rows(tmp_path, capsys):
    parameters = {"material.poisson_ratio": [0.3, 0.5], "time.dt": [1e-3, 0.5]}
    scenario = small().changed({"time.allow_unstable": True, "time.until": 100.0})
    scenario = scenario.changed({"output.every": 50.0, "time.integrator": "rk4"})
    short = scenario.changed({"time.until": 0.02, "output.every": 0.01})
    table = rsph.sweep(short, parameters, output=tmp_path / "kept", progress=True)
    assert "4 of 4 runs" in capsys.readouterr().err
    assert table["status"].tolist()[2:] == ["refused", "refused"]
    assert table["status"][0] == "finished"
    assert "poisson_ratio" in table["error"][2]
    assert np.isnan(table["extension"][2])
    assert (tmp_path / "kept" / "0000" / "report.html").exists()
    assert rsph.read(table["output"][0]).summary["dt"] == 1e-3
    # A simulation that blows up tells why, and its results are there.
    broken = rsph.sweep(scenario, {"time.dt": [0.05]}, jobs=1, output=tmp_path / "broken")
    assert broken["status"][0] == "failed"
    assert "unstable" in broken["error"][0] or "finite" in broken["error"][0]
    assert rsph.read(broken["output"][0]).summary["status"] == "failed"
    with pytest.raises(rsph.InputError, match="not an empty folder"):
        rsph.sweep(scenario, {"time.dt": [0.05]}, output=tmp_path / "broken")


@pytest.mark.parametrize(
    ("parameters", "options"),
    [
        ({}, {}),
        ({"material.young_modulus": 3.0}, {}),
        ({"material.young_modulus": []}, {}),
        ({"material.young_modulus": "12"}, {}),
        ({"material.youngs": [1.0]}, {}),
        ({"material.young_modulus": [1.0]}, {"jobs": 0}),
    ],
)
def test_a_sweep_of_nothing_is_refused(parameters, options):
    with pytest.raises(rsph.InputError):
        rsph.sweep(small(), parameters, **options)


def test_a_killed_process_costs_its_row_only(monkeypatch):
    # The worker of one run ends itself while it reads its scenario.
    values = [100.0, _Deadly(200.0), 300.0]
    table = rsph.sweep(small(), {"material.young_modulus": values}, jobs=2)
    assert table["status"].tolist() == ["finished", "killed", "finished"]
    assert "ended from outside" in table["error"][1]


class _Deadly(float):
    """A number that ends the process in which it is unpickled."""

    def __reduce__(self):
        import os

        return os._exit, (1,)


def test_a_dask_client_runs_a_sweep():
    from distributed import Client

    with Client(n_workers=1, threads_per_worker=1, dashboard_address=None) as client:
        table = rsph.sweep(small(), {"material.young_modulus": [100.0, -1.0]}, client=client)
    assert table["status"].tolist() == ["finished", "refused"]


def test_without_pandas_the_table_is_a_dictionary_of_columns(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "pandas", None)
    table = rsph.sweep(small(), {"material.young_modulus": [100.0]}, jobs=1)
    assert isinstance(table, dict)
    assert table["extension"].shape == (1,)
    assert table["status"].tolist() == ["finished"]
