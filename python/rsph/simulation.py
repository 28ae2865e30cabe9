"""The simulation of one body."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from rsph import _rsph
from rsph._progress import Progress
from rsph._scenario import Table, plain, scenario, toml, without_none
from rsph.boundaries import Boundary, Foundation
from rsph.errors import InputError, RsphWarning
from rsph.fields import Field, function_of, table_of
from rsph.loads import Custom, Function, Load
from rsph.materials import Material, Part
from rsph.probes import Gauge, Probe
from rsph.results import Snapshot, Surface
from rsph.sampling import Particles
from rsph.scenario import Scenario
from rsph.shapes import Shape

__all__ = ["Description", "Equilibrium", "Simulation"]

Array = npt.NDArray[np.float64]
History: TypeAlias = dict[str, Array]
_T = TypeVar("_T")

# `run` records the probes at least this often, or at every step if it has fewer.
_MIN_SAMPLES = 1000


@dataclass(frozen=True)
class Description:
    """What is known of a simulation before its first step."""

    shape: str
    """Name of the shape."""
    material: str
    """Name of the material model."""
    particles: int
    """Number of particles."""
    spacing: float
    """Distance between particles (m)."""
    smoothing_length: float
    """Smoothing length h (m)."""
    neighbours: int
    """Neighbours of an inner particle."""
    integrator: str
    """Scheme of integration in time."""
    dt: float
    """Time step (s), the first of a scheme that chooses its steps."""
    dt_limit: float
    """Largest stable time step (s)."""
    limited_by_viscosity: bool
    """Whether viscosity (True) or wave speed (False) sets that limit."""
    volume: float
    """Volume of the particles (m^3)."""
    shape_volume: float
    """Volume of the shape (m^3)."""
    load: Array
    """Total force of the loads at full ramp (N), shape (3,)."""


Integrator: TypeAlias = Literal["auto", "rk4", "sdirk2", "backward-euler", "rkc2"]
"""Schemes of integration in time."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """How an equilibrium was found."""

    iterations: int
    """Iterations of the linear solver."""
    newton_steps: int
    """Steps of Newton's method: one or two if the law is linear."""
    residual: float
    """Forces out of balance as a share of the load."""
    compliance: float
    """Loads times displacement, f . u (J)."""
    load: Array
    """Total force of the loads (N), shape (3,)."""
    reaction: Array
    """Total force of the clamps on the body (N), shape (3,)."""


class Simulation:
    """A body, what it is made of, and what happens to it.

    >>> import rsph
    >>> below, above = (
    ...     rsph.regions.plane(axis="z", at=0.0, side="below"),
    ...     rsph.regions.plane(axis="z", at=1.0, side="above"),
    ... )
    >>> sim = rsph.Simulation(
    ...     shape=rsph.shapes.Box(size=(1, 1, 1)),
    ...     spacing=0.25,
    ...     material=rsph.materials.KelvinVoigt(
    ...         density=1.0, young_modulus=100.0, poisson_ratio=0.3, relaxation_time=0.2
    ...     ),
    ...     boundaries=[rsph.boundaries.Clamp(region=below)],
    ...     loads=[rsph.loads.Traction(region=above, traction=(0, 0, 1))],
    ...     probes=[rsph.Probe(name="extension", quantity="displacement.z", region=above)],
    ... )
    >>> history = sim.run(until=0.1)
    >>> bool(history["extension"][-1] > 0.0)
    True

    Args:
        shape: the body, or the :class:`rsph.Particles` of one, whose spacing is taken.
        spacing: distance between particles (m); either this or ``particles``.
        particles: number of particles (about); the spacing is found from it.
        material: what the body is made of; for a body of several materials a list of them, with
            :class:`rsph.materials.Part` saying where each is.
        boundaries: parts that are held or moved.
        foundations: springs between parts of the surface and the surroundings.
        loads: what pushes or pulls; at most one of them a :class:`rsph.loads.Custom`.
        probes: named readings, for :meth:`probes` and the history.
        gauges: strain gauges, whose readings follow those of the probes.
        fields: measures of deformation and stress that snapshots and surfaces have beside the
            fields of every simulation, such as ``"principal_strain"``.
        initial_velocity: a constant vector (m/s), a field of :mod:`rsph.fields`, or a function of
            an array (N, 3) of positions (m) that returns an array (N, 3). At rest by default.
        initial_displacement: the same for the displacement (m). None by default.
        formulation: ``"adjoint"``, which is stable, or ``"paper"``, which is the paper's to the
            letter and is not.
        smoothing: smoothing length in spacings; by default 0.8 (1.25 with formulation
            ``"paper"``).
        hourglass: modulus of the hourglass term as a multiple of its default, 1; 0 switches it off.
        integrator: scheme of integration; ``"auto"`` is ``"rk4"``, or ``"sdirk2"`` where viscosity
            makes the steps of ``"rk4"`` more than 100 times shorter than waves do.
        dt: time step (s), or ``"auto"`` for 0.9 of the stability limit, or for steps that
            ``"sdirk2"`` chooses by their error.
        tolerance: that error as a share of the displacement; by default 0.02.
        allow_unstable: accept a ``dt`` above the stability limit.
        remesh_every: time steps between remeshings, 0 for never, or ``"auto"``: when a stretch
            since the last one has left 0.8 to 1.25 anywhere (under the linear law, the displacement
            gradient has changed by 0.25).
        remesh_kernel: interpolation kernel of remeshing; by default ``"m4-prime"``.
        restore_level_set: whether the level set becomes the distance from the present surface at
            each remeshing; by default particles carry that of the undeformed body.
        units: ``"SI"`` or ``"normalised"``; labels only.

    Raises:
        InputError: something that cannot be simulated.
    """

    def __init__(
        self,
        *,
        shape: Shape | Particles,
        material: Material | Part | Sequence[Material | Part],
        spacing: float | None = None,
        particles: int | None = None,
        boundaries: Sequence[Boundary] = (),
        foundations: Sequence[Foundation] = (),
        loads: Sequence[Load | Custom] = (),
        probes: Sequence[Probe] = (),
        gauges: Sequence[Gauge] = (),
        fields: Sequence[str] = (),
        initial_velocity: Field | None = None,
        initial_displacement: Field | None = None,
        formulation: Literal["adjoint", "paper"] = "adjoint",
        smoothing: float | None = None,
        hourglass: float | None = None,
        integrator: Integrator = "auto",
        dt: float | Literal["auto"] = "auto",
        tolerance: float | None = None,
        allow_unstable: bool = False,
        remesh_every: int | Literal["auto"] = 0,
        remesh_kernel: Literal["m4-prime", "lambda-4-2", "lambda-6-4"] | None = None,
        restore_level_set: bool = False,
        units: Literal["SI", "normalised"] = "SI",
    ) -> None:
        if isinstance(shape, Particles):
            if spacing is None and particles is None:
                spacing = shape.spacing
            shape = shape.shape
        _check_types(shape, Shape, "shape", "a shape, for example rsph.shapes.Box(size=(1, 1, 1))")
        parts = _parts(material)
        given = _list(loads, (Load, Custom), "loads")
        custom = [load for load in given if isinstance(load, Custom)]
        if len(custom) > 1:
            raise InputError(
                f"`loads`: holds {len(custom)} functions",
                key="loads",
                remedy="give one function that returns the sum of their forces",
            )
        box: Table = {"box": {"size": [1.0, 1.0, 1.0]}}  # `shape` takes its place
        text = scenario(
            units=units,
            body=without_none(shape=box, spacing=spacing, particles=particles),
            material=[part._as_table() for part in parts],
            initial=without_none(
                velocity=table_of("initial.velocity", initial_velocity),
                displacement=table_of("initial.displacement", initial_displacement),
            ),
            boundary=[b._as_table() for b in _list(boundaries, Boundary, "boundaries")],
            foundation=[f._as_table() for f in _list(foundations, Foundation, "foundations")],
            load=[load._as_table() for load in given if isinstance(load, Load)],
            probe=[probe._as_table() for probe in _list(probes, Probe, "probes")],
            gauge=[gauge._as_table() for gauge in _list(gauges, Gauge, "gauges")],
            output={"fields": _list(fields, str, "fields")},
            solver=without_none(formulation=formulation, smoothing=smoothing, hourglass=hourglass),
            time=without_none(
                integrator=integrator,
                dt=dt,
                tolerance=tolerance,
                until=1.0,
                allow_unstable=allow_unstable,
            ),
            remesh=without_none(
                every=remesh_every,
                kernel=remesh_kernel,
                restore_level_set=restore_level_set,
            ),
        )
        self._start(
            _rsph.Simulation(
                text,
                shape._shape,
                function_of(initial_displacement),
                function_of(initial_velocity),
                [(k, part.modulus) for k, part in enumerate(parts) if callable(part.modulus)],
                [(k, part.fibres) for k, part in enumerate(parts) if callable(part.fibres)],
            )
        )
        if custom:
            self.set_load(custom[0])

    @classmethod
    def from_toml(
        cls, path: str | os.PathLike[str], *, overrides: Mapping[str, object] | None = None
    ) -> Simulation:
        """A simulation from a scenario file.

        Args:
            path: the file.
            overrides: values to put in the place of those of the file by dotted key, such as
                ``{"time.dt": 0.001, "load.0.ramp.to": 1.0}``.
        """
        sets = [f"{key}={toml(plain(value), key)}" for key, value in (overrides or {}).items()]
        simulation = cls.__new__(cls)
        simulation._start(_rsph.Simulation.from_toml(os.fspath(path), sets))
        return simulation

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> Simulation:
        """The simulation of a :class:`rsph.Scenario`."""
        simulation = cls.__new__(cls)
        simulation._start(_rsph.Simulation.from_scenario(scenario._source))
        return simulation

    def __copy__(self) -> Simulation:
        """Another simulation in the same state, which goes on bit by bit as this one."""
        twin = Simulation.__new__(type(self))
        twin._core = self._core.copy()
        twin._description = self._description
        twin._doubted = self._doubted
        return twin

    def __deepcopy__(self, memo: dict[int, object]) -> Simulation:
        return self.__copy__()

    def __reduce__(self) -> Any:
        raise TypeError(
            "a running simulation is not pickled; pickle its rsph.Scenario, or copy.copy it"
        )

    def _start(self, core: _rsph.Simulation) -> None:
        self._core = core
        self._doubted = False
        self._description = Description(**core.description())
        for note in core.notes:
            warnings.warn(note, RsphWarning, stacklevel=3)

    def _doubt(self) -> None:
        """Warns, once, of a state that the law is not for."""
        if self._doubted:
            return
        note = self._core.beyond_the_law()
        if note is not None:
            self._doubted = True
            warnings.warn(note, RsphWarning, stacklevel=3)

    def step(self, n: int = 1) -> None:
        """Takes ``n`` time steps of length ``dt``.

        Raises:
            SimulationError: it failed; it stands at its last good state.
        """
        if n < 0:
            raise InputError(
                f"`n` = {n}: steps are counted", key="n", value=str(n), remedy="give 0 or more"
            )
        self._core.step(n)

    def run(
        self,
        *,
        until: float | None = None,
        integrator: Integrator | None = None,
        dt: float | None = None,
        every: float | Literal["step"] | None = None,
        observe: Callable[[Snapshot], object] | None = None,
        callback: Callable[[Simulation], object] | None = None,
        progress: bool = False,
    ) -> History:
        """Runs to the time ``until`` exactly, shortening its steps a little to meet it.

        Other Python threads go on meanwhile. Ctrl-C stops it at a whole step with a
        KeyboardInterrupt, after which it can go on.

        Args:
            until: end of the run (s); by default that of the scenario file.
            integrator: scheme from here on; by default the one so far.
            dt: its time step (s); by default the scheme's own. Only together with ``integrator``.
            every: time (s) between two calls of ``observe`` and ``callback``; by default a fiftieth
                of the run. ``"step"`` calls ``observe`` after every time step.
            observe: called with the :class:`rsph.Snapshot` of the moment. An exception ends the
                run.
            callback: called with the simulation, which it may change. An exception ends the run.
            progress: show on stderr how far it is.

        Returns:
            The history of the probes, as :meth:`history`.

        Raises:
            SimulationError: it failed; it stands at its last good state.
        """
        start = self.time
        end = self._end(until)
        if integrator is not None:
            self._core.set_integration(integrator, dt)
            self._description = Description(**self._core.description())
        elif dt is not None:
            raise InputError(
                f"`dt` = {dt}: is for another `integrator`",
                key="dt",
                value=str(dt),
                remedy="name the integrator as well",
            )
        each_step = every == "step"
        if each_step and callback is not None:
            raise InputError(
                '`every` = "step": is for `observe`, which sees the simulation during a step',
                key="every",
                value="step",
                remedy="give `observe`, or the time between two calls of `callback`",
            )
        if not (every is None or isinstance(every, str) or every > 0.0) or (
            isinstance(every, str) and not each_step
        ):
            raise InputError(
                f'`every` = {every}: must be greater than 0, or "step"',
                key="every",
                value=str(every),
                remedy="give the time between two calls",
            )
        stride = max(1, int((end - start) / self.dt) // _MIN_SAMPLES)
        pieces = 1
        if callback is not None or (observe is not None and not each_step):
            # A remainder of rounding is no piece of its own.
            interval = float(every) if isinstance(every, int | float) else (end - start) / 50
            pieces = max(1, math.ceil((end - start) / interval - 1e-9))
        look = None
        if observe is not None and each_step:
            see = observe

            def look(moment: _rsph.Snapshot) -> None:
                see(Snapshot(moment))

        with Progress(progress, start) as shown:

            def report(time: float) -> None:
                shown(time, end)

            for k in range(1, pieces + 1):
                t = end if k == pieces else start + k * interval
                self._core.advance(t, stride, report if progress else None, look)
                if observe is not None and not each_step:
                    observe(self.snapshot())
                if callback is not None:
                    callback(self)
            shown(self.time, end)
        self._doubt()
        return self.history()

    def set_load(
        self,
        load: Custom | Function | None,
        *,
        on: Literal["surface", "particles"] = "surface",
    ) -> None:
        """Lets a Python function push or pull, beside the other loads, from here on.

        Args:
            load: a :class:`rsph.loads.Custom`, or its function: it is called before every time step
                with the time (s) and the :class:`rsph.loads.Points`, and returns forces (N), shape
                (P, 3). It takes the place of one that was there; None takes that away.
            on: where, if ``load`` is a function.

        Raises:
            InputError: this body takes no such load.
        """
        if load is not None and not isinstance(load, Custom):
            load = Custom(load, on)
        self._core.set_load(
            None if load is None else load._call, load is None or load.on == "surface"
        )

    def add_probe(self, probe: Probe) -> None:
        """Adds a probe; the history has NaN for the time before.

        Raises:
            InputError: its name is taken, or there is nothing in its region.
        """
        _check_types(probe, Probe, "probe", "a rsph.Probe")
        self._core.add_probe(scenario(probe=[probe._as_table()]))

    def set_material(self, material: Material, *, name: str | None = None) -> None:
        """Goes on with another material: for moduli that are tried out as a body moves.

        Args:
            material: of the same density, and linear if the one before is.
            name: of the part of a body of several materials that it is for; by default the first.

        Raises:
            InputError: it is of another density or kind, there is no part of that name, or a given
                time step is too long for it.
        """
        _check_types(material, Material, "material", "a material of rsph.materials")
        self._core.set_material(scenario(material=material._as_table()), name)

    def solve_static(self, *, time: float | None = None) -> Equilibrium:
        """Goes straight to equilibrium under the loads and holds of a moment, at rest.

        Args:
            time: that moment (s), which becomes the present one; by default the present time.

        Raises:
            SimulationError: the body is not held, or no equilibrium was found.
        """
        found = self._core.solve_static(self.time if time is None else float(time))
        self._doubt()
        return Equilibrium(**found)

    @property
    def stiffness(self) -> Any:
        """The stiffness K as a ``scipy.sparse.linalg.LinearOperator`` (needs SciPy).

        It acts on displacements (m) in the order of ``snapshot().displacement.ravel()`` and gives
        forces (N), shape (3 N, 3 N); held components are zero.
        """
        from scipy.sparse.linalg import LinearOperator  # type: ignore[import-untyped,unused-ignore]

        size = 3 * self.particles

        def apply(u: Array) -> Array:
            rows = np.ascontiguousarray(u, dtype=np.float64).reshape(-1, 3)
            return self._core.stiffness(rows).ravel()

        return LinearOperator((size, size), matvec=apply, rmatvec=apply, dtype=np.float64)

    def _end(self, until: float | None) -> float:
        end = self._core.until if until is None else until
        if end is None:
            raise InputError(
                "`until`: missing", key="until", remedy="say when to stop, for example until=3.0"
            )
        if not (math.isfinite(end) and end >= self.time):
            raise InputError(
                f"`until` = {end}: must be a number from the present time t = {self.time:g} on",
                key="until",
                value=str(end),
                remedy="give the time at which to stop, not a duration",
            )
        return float(end)

    @property
    def time(self) -> float:
        """Simulated time (s)."""
        return self._core.time

    @property
    def steps(self) -> int:
        """Number of time steps taken."""
        return self._core.steps

    @property
    def dt(self) -> float:
        """Time step (s)."""
        return self._description.dt

    @property
    def dt_limit(self) -> float:
        """Largest stable time step (s)."""
        return self._description.dt_limit

    @property
    def particles(self) -> int:
        """Number of particles."""
        return self._description.particles

    @property
    def spacing(self) -> float:
        """Distance between particles (m)."""
        return self._description.spacing

    @property
    def description(self) -> Description:
        """What is known before the first step."""
        return self._description

    @property
    def notes(self) -> list[str]:
        """What you should know of it and of this moment, a sentence each; also as warnings."""
        note = self._core.beyond_the_law()
        return self._core.notes if note is None else [*self._core.notes, note]

    def snapshot(self) -> Snapshot:
        """This moment, with read-only arrays that are not copied."""
        return Snapshot(self._core.snapshot())

    def surface(self) -> Surface:
        """The deformed surface of this moment, with all fields on its vertices."""
        vertices, triangles, fields = self._core.surface()
        return Surface(self.time, fields, vertices, triangles)

    def probes(self) -> dict[str, float]:
        """The probes' readings of this moment; a vector probe gives ``<name>_x`` and so on."""
        return self._core.probes()

    def history(self) -> History:
        """What :meth:`run` recorded of the probes.

        Arrays of shape (S,) by name, ``"time"`` first: at every step, or about a thousand samples
        of a longer run.
        """
        return self._core.history()

    def conservation(self) -> dict[str, float | Array]:
        """Mass (kg), momentum (kg m/s), energies (J), forces (N) and their errors at this moment.

        Keys: ``mass``, ``momentum`` of shape (3,), ``kinetic_energy``, ``elastic_energy``,
        ``external_work``, ``dissipated``, ``load`` (3,), ``reaction`` (3,), and the relative
        ``momentum_error`` and ``mass_error``; beside a fluid ``energy_error`` as well.
        """
        return self._core.conservation()

    def __repr__(self) -> str:
        d = self._description
        return (
            f"<Simulation of {d.shape}, {d.material}: {d.particles} particles, spacing "
            f"{d.spacing:.4g}; t = {self.time:g} after {self.steps} steps, dt {d.dt:.3g} of at "
            f"most {d.dt_limit:.3g}>"
        )


def _parts(material: Material | Part | Sequence[Material | Part]) -> list[Part]:
    """The materials of a body, that of the rest of it first."""
    given = [material] if isinstance(material, (Material, Part)) else material
    if not isinstance(given, (list, tuple)):
        _check_types(material, Material, "material", "a material of rsph.materials")
        given = []
    for i, one in enumerate(given):
        _check_types(
            one, (Material, Part), f"material[{i}]", "a material of rsph.materials, or a Part"
        )
    parts = [one if isinstance(one, Part) else Part(material=one) for one in given]
    return sorted(parts, key=lambda part: not part._is_rest)


def _list(values: Sequence[_T], kind: type[_T] | tuple[type[Any], ...], name: str) -> Sequence[_T]:
    if isinstance(values, kind):
        remedy = f"wrap it in brackets: {name}=[...]"
        raise InputError(f"`{name}`: needs a list", key=name, remedy=remedy)
    for i, value in enumerate(values):
        first = kind[0] if isinstance(kind, tuple) else kind
        _check_types(value, kind, f"{name}[{i}]", f"a {first.__name__}")
    return values


def _check_types(value: object, kind: type | tuple[type, ...], key: str, wanted: str) -> None:
    if not isinstance(value, kind):
        raise InputError(
            f"`{key}` = {value!r}: needs {wanted}",
            key=key,
            value=repr(value),
            remedy="see help(rsph.Simulation)",
        )
