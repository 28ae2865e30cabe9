"""Simulations that several tests use."""

from pathlib import Path

import pytest

import rsph
from rsph.regions import plane

ROOT = Path(__file__).resolve().parents[2]
BOTTOM = plane(axis="z", at=0.0, side="below")
TOP = plane(axis="z", at=1.0, side="above")


def material(**changes):
    values = {
        "density": 1.0,
        "young_modulus": 100.0,
        "poisson_ratio": 0.3,
        "relaxation_time": 0.2,
    }
    return rsph.materials.KelvinVoigt(**(values | changes))


def cube(**changes):
    """A free unit cube."""
    values = {
        "shape": rsph.shapes.Box(size=(1, 1, 1)),
        "spacing": 0.2,
        "material": material(),
        "units": "normalised",
    }
    return rsph.Simulation(**(values | changes))


def pulled(**changes):
    """A unit cube clamped at the bottom and pulled at the top."""
    values = {
        "boundaries": [rsph.boundaries.Clamp(region=BOTTOM)],
        "loads": [rsph.loads.Traction(region=TOP, traction=(0, 0, 1))],
        "probes": [rsph.Probe(name="extension", quantity="displacement.z", region=TOP)],
    }
    return cube(**(values | changes))


@pytest.fixture
def sim():
    return pulled()
