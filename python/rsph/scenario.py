"""Scenarios as values: read, written in Python, changed, run, pickled."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rsph import _rsph
from rsph._progress import Progress
from rsph._scenario import plain, toml
from rsph.results import Run

if TYPE_CHECKING:
    from rsph.simulation import Simulation

__all__ = ["Scenario"]


class Scenario:
    """Everything that a scenario file says, as a value that does not change.

    It can be pickled, compared, and changed into another one. Its tables and their keys are those
    of a scenario file; shapes, materials, boundaries, loads, probes, regions and fields of this
    package may stand for the tables that they are.

    >>> import rsph
    >>> bottom = rsph.regions.plane(axis="z", at=0.0, side="below")
    >>> top = rsph.regions.plane(axis="z", at=1.0, side="above")
    >>> scenario = rsph.Scenario(
    ...     {
    ...         "units": "normalised",
    ...         "body": {"shape": rsph.shapes.Box(size=(1, 1, 1)), "spacing": 0.25},
    ...         "material": rsph.materials.KelvinVoigt(
    ...             density=1.0, young_modulus=100.0, poisson_ratio=0.3, relaxation_time=0.2
    ...         ),
    ...         "boundary": [rsph.boundaries.Clamp(region=bottom)],
    ...         "load": [rsph.loads.Traction(region=top, traction=(0, 0, 1))],
    ...         "time": {"until": 1.0},
    ...     }
    ... )
    >>> stiffer = scenario.changed({"material.young_modulus": 200.0})
    >>> stiffer == scenario
    False
    >>> stiffer.simulation().particles
    64

    Args:
        tables: the tables by name.
        folder: where relative paths in it start; by default the present folder.

    Raises:
        InputError: it is no scenario, with the words of the command line.
    """

    def __init__(
        self, tables: Mapping[str, Any], *, folder: str | os.PathLike[str] | None = None
    ) -> None:
        text = "\n".join(f"{key} = {toml(plain(value), key)}" for key, value in tables.items())
        self._set("", text, os.getcwd() if folder is None else os.fspath(folder), [])

    def _set(self, name: str, text: str, folder: str, sets: list[str]) -> None:
        self._source = (name, text, os.path.abspath(folder), sets)
        self._text = _rsph.scenario_text(self._source)

    @classmethod
    def from_toml(
        cls, path: str | os.PathLike[str], *, overrides: Mapping[str, object] | None = None
    ) -> Scenario:
        """Reads a scenario file.

        Args:
            path: the file.
            overrides: as for :meth:`changed`.

        Raises:
            InputError: it cannot be read or is no scenario, with line and column.
        """
        name = os.fspath(path)
        scenario = cls.__new__(cls)
        text = _rsph.read_scenario(name)
        scenario._set(name, text, os.path.dirname(name), _edits(overrides))
        return scenario

    @classmethod
    def from_text(cls, text: str, *, folder: str | os.PathLike[str] | None = None) -> Scenario:
        """Reads a scenario from a text in TOML.

        Args:
            text: the text.
            folder: where relative paths in it start; by default the present folder.
        """
        scenario = cls.__new__(cls)
        scenario._set("", text, os.getcwd() if folder is None else os.fspath(folder), [])
        return scenario

    @classmethod
    def of(cls, source: Scenario | Mapping[str, Any] | str | os.PathLike[str]) -> Scenario:
        """A scenario from whatever describes one.

        Args:
            source: a scenario, its tables, its text (with an ``=`` in it), or the path of its file.
        """
        if isinstance(source, Scenario):
            return source
        if isinstance(source, Mapping):
            return cls(source)
        if isinstance(source, str) and "=" in source and not os.path.exists(source):
            return cls.from_text(source)
        return cls.from_toml(source)

    def changed(self, overrides: Mapping[str, object]) -> Scenario:
        """Another scenario with other values.

        Args:
            overrides: values by dotted key; lists are counted from 0:
                ``{"time.dt": 0.001, "load.0.ramp.to": 1.0}``.

        Raises:
            InputError: a key that does not exist, or a value of the wrong type.
        """
        name, text, folder, sets = self._source
        scenario = Scenario.__new__(Scenario)
        scenario._set(name, text, folder, [*sets, *_edits(overrides)])
        return scenario

    @property
    def text(self) -> str:
        """The scenario as run, in TOML; paths are absolute."""
        return self._text

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a scenario file that runs from any folder."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._text)

    def simulation(self) -> Simulation:
        """The simulation at its start.

        Raises:
            InputError: it cannot be simulated.
        """
        from rsph.simulation import Simulation

        return Simulation.from_scenario(self)

    def run(
        self, output: str | os.PathLike[str], *, force: bool = False, progress: bool = False
    ) -> Run:
        """Runs it as the command line does, into a folder of results.

        Ctrl-C closes the last frame and raises KeyboardInterrupt.

        Args:
            output: the folder.
            force: overwrite results that are there.
            progress: show on stderr how far it is.

        Raises:
            InputError: it cannot be simulated, or the folder holds results; nothing was written.
            SimulationError: it failed; the results up to there are in the folder.
            StorageError: results could not be stored.
        """
        with Progress(progress) as shown:
            done = self._run(os.fspath(output), force=force, report=shown)
        if done["error"] is not None:
            raise done["error"]
        return Run(output)

    def _run(
        self,
        output: str | None,
        *,
        force: bool = False,
        report: Callable[[float, float], None] | None = None,
    ) -> dict[str, Any]:
        return _rsph.run_scenario(self._source, output, force, report)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scenario) and self._text == other._text

    def __hash__(self) -> int:
        return hash(self._text)

    def __repr__(self) -> str:
        name, text, _, sets = self._source
        what = repr(name) if name else f"of {len(text.splitlines())} lines"
        changed = f", changed by {', '.join(sets)}" if sets else ""
        return f"<Scenario {what}{changed}>"


def _edits(overrides: Mapping[str, object] | None) -> list[str]:
    return [f"{key}={toml(plain(value), key)}" for key, value in (overrides or {}).items()]
