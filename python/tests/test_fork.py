"""A process that is forked after rsph was used computes with threads of its own."""

import multiprocessing as mp
import sys

import pytest

import rsph

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="no fork elsewhere")


def solve() -> float:
    held = rsph.boundaries.Clamp(region=rsph.regions.plane(axis="z", at=0.0, side="below"))
    pulled = rsph.regions.plane(axis="z", at=1.0, side="above")
    sim = rsph.Simulation(
        shape=rsph.shapes.Box(size=(1, 1, 1)),
        spacing=0.125,
        material=rsph.materials.KelvinVoigt(
            density=1.0, young_modulus=100.0, poisson_ratio=0.3, relaxation_time=0.2
        ),
        boundaries=[held],
        loads=[rsph.loads.Traction(region=pulled, traction=(0, 0, 1))],
    )
    sim.solve_static()
    return float(sim.snapshot().displacement[:, 2].max())


def child(results, depth):
    results.put(solve())
    if depth:
        forked(results, depth - 1)


def forked(results, depth):
    process = mp.get_context("fork").Process(target=child, args=(results, depth))
    process.start()
    process.join(60)
    hangs = process.is_alive()
    if hangs:
        process.kill()
    assert not hangs
    assert process.exitcode == 0


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_children_and_their_children_find_what_the_parent_found():
    found = solve()
    results = mp.get_context("fork").Queue()
    forked(results, 2)
    assert [results.get(timeout=10) for _ in range(3)] == [found] * 3
    assert solve() == found
