"""How human organs deform, by remeshed Smoothed Particle Hydrodynamics.

Build a :class:`Simulation` from :mod:`rsph.shapes`, :mod:`rsph.materials`, :mod:`rsph.boundaries`,
:mod:`rsph.loads` and :mod:`rsph.regions`, or read it from a scenario file with
``Simulation.from_toml``. A :class:`Scenario` is all that a scenario file says, to change, run and
:func:`sweep`. Quantities are in one consistent system of units, SI or normalised.
"""

from rsph import boundaries, fields, loads, materials, plot, regions, shapes
from rsph._rsph import __version__
from rsph.errors import (
    Error,
    InputError,
    MissingFieldError,
    RsphWarning,
    SimulationError,
    StorageError,
)
from rsph.probes import Gauge, Probe
from rsph.results import ParticleFrame, Results, Run, Snapshot, Surface, read
from rsph.sampling import Particles
from rsph.scenario import Scenario
from rsph.simulation import Description, Equilibrium, Simulation
from rsph.sweeps import sweep

__all__ = [
    "Description",
    "Equilibrium",
    "Error",
    "Gauge",
    "InputError",
    "MissingFieldError",
    "ParticleFrame",
    "Particles",
    "Probe",
    "Results",
    "RsphWarning",
    "Run",
    "Scenario",
    "Simulation",
    "SimulationError",
    "Snapshot",
    "StorageError",
    "Surface",
    "__version__",
    "boundaries",
    "fields",
    "loads",
    "materials",
    "plot",
    "read",
    "regions",
    "shapes",
    "sweep",
]
