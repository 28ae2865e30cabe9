"""How human organs deform, by remeshed Smoothed Particle Hydrodynamics.

Build a :class:`Simulation` from :mod:`rsph.shapes`, :mod:`rsph.materials`, :mod:`rsph.boundaries`,
:mod:`rsph.loads` and :mod:`rsph.regions`, or read it from a scenario file with
``Simulation.from_toml``. Quantities are in one consistent system of units, SI or normalised.
"""

from rsph import boundaries, fields, loads, materials, plot, regions, shapes
from rsph._rsph import __version__
from rsph.errors import Error, InputError, MissingFieldError, RsphWarning, SimulationError
from rsph.probes import Probe
from rsph.results import ParticleFrame, Results, Snapshot, Surface, read
from rsph.simulation import Description, Simulation

__all__ = [
    "Description",
    "Error",
    "InputError",
    "MissingFieldError",
    "ParticleFrame",
    "Probe",
    "Results",
    "RsphWarning",
    "Simulation",
    "SimulationError",
    "Snapshot",
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
]
