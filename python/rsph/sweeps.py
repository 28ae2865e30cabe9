"""Many runs of one scenario with other values."""

from __future__ import annotations

import csv
import itertools
import json
import os
import sys
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from rsph.errors import Error, InputError
from rsph.scenario import Scenario

__all__ = ["sweep"]

Row: TypeAlias = dict[str, Any]

# What of summary.json is a number of the run or says how it went; the rest is in the output folder.
_SUMMARY = (
    "status",
    "particles",
    "steps",
    "time",
    "wall_seconds",
    "rhs_evaluations",
    "dt",
    "integrator",
    "spacing",
    "volume",
    "mass_error",
    "momentum_error",
)


def sweep(
    scenario: Scenario | Mapping[str, Any] | str | os.PathLike[str],
    parameters: Mapping[str, Sequence[Any]],
    *,
    jobs: int = -1,
    client: Any = None,
    output: str | os.PathLike[str] | None = None,
    progress: bool = False,
) -> Any:
    """Runs a scenario with all combinations of some values.

    Each run is a process of its own, by joblib (``pip install rsph[sweep]``) or on the workers of a
    dask client, where rsph must be installed. The processors are divided among the runs; results
    do not depend on how.

    >>> import rsph
    >>> table = rsph.sweep(
    ...     "scenarios/tensile_liver.toml",
    ...     {"material.young_modulus": [100.0, 200.0], "body.particles": [27]},
    ... )  # doctest: +SKIP
    >>> table["extension"] * table["material.young_modulus"]  # doctest: +SKIP

    Args:
        scenario: the scenario, its tables, its text, or the path of its file.
        parameters: lists of values by dotted key of the scenario, such as
            ``"material.young_modulus"`` or ``"load.0.pressure"``.
        jobs: runs at a time; -1 for as many as there are processors, 1 for one after the other.
        client: a ``dask.distributed.Client`` to run them on instead.
        output: keep the folders of results here, ``0000`` and so on; by default none is written.
        progress: show on stderr how many runs are done.

    Returns:
        A table with one row a run, in the order of the product of the values (the last key changes
        fastest): the values, numbers of the run's summary (``status``, ``particles``, ``steps``,
        ``time``, ``wall_seconds``, ...), the last reading of each probe by its name, ``output`` if
        folders are kept, and ``error``: empty, or why the run failed or could not begin. A pandas
        DataFrame, or a dictionary of columns if pandas is not installed.

    Raises:
        InputError: a key that the scenario does not know, or the folder holds results.
    """
    base = Scenario.of(scenario)
    if not parameters:
        raise InputError(
            "`parameters`: names no key",
            key="parameters",
            remedy='for example {"material.young_modulus": [1e4, 1e5]}',
        )
    for key, values in parameters.items():
        if isinstance(values, str | bytes | Mapping) or not _is_list(values) or len(values) == 0:
            raise InputError(
                f"`parameters`: {key!r} = {values!r} is no list of values",
                key="parameters",
                value=repr(values),
                remedy=f"give a list: {{{key!r}: [...]}}",
            )
    runs = [
        dict(zip(parameters, values, strict=True))
        for values in itertools.product(*parameters.values())
    ]
    # A key that does not exist is a mistake of the sweep, not of a run.
    try:
        base.changed(runs[0])
    except InputError as e:
        if "unknown key" in str(e):
            raise
    folders = _folders(output, len(runs))
    tasks = list(zip([base] * len(runs), runs, folders, strict=True))
    rows: list[Row | None] = [None] * len(runs)
    start = time.monotonic()
    found = _on_dask(client, tasks) if client is not None else _by_joblib(jobs, tasks)
    for done, (i, row) in enumerate(found, start=1):
        rows[i] = row
        if progress:
            seconds = time.monotonic() - start
            sys.stderr.write(f"\r{done} of {len(runs)} runs in {seconds:.0f} s")
            sys.stderr.flush()
    if progress:
        sys.stderr.write("\n")
    return _table([row for row in rows if row is not None], parameters)


Task: TypeAlias = tuple[Scenario, dict[str, Any], "str | None"]


def _run(index: int, task: Task, threads: int | None) -> tuple[int, Row]:
    """One run, in the process that does it; a failure is told by its row."""
    if threads is not None:
        # Read when the first simulation of the process begins.
        os.environ.setdefault("RAYON_NUM_THREADS", str(threads))
    base, values, folder = task
    row: Row = dict(values)
    try:
        done = base.changed(values)._run(folder)
    except Error as e:
        return index, row | {"status": "refused", "error": str(e), "output": folder}
    summary, probes = done["summary"], done["probes"]
    if folder is not None:
        summary = Path(folder, "summary.json").read_text(encoding="utf-8")
        probes = _last_row(Path(folder, "probes.csv"))
    numbers = json.loads(summary)
    row |= {key: numbers[key] for key in _SUMMARY}
    row |= {name if name not in row else f"probe.{name}": value for name, value in probes.items()}
    error = "" if done["error"] is None else str(done["error"])
    return index, row | {"error": error, "output": folder}


def _last_row(path: Path) -> dict[str, float]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        header, last = next(rows), deque(rows, maxlen=1)
    values = last[0] if last else ["nan"] * len(header)
    return {
        name: float(value) for name, value in zip(header, values, strict=True) if name != "time"
    }


def _by_joblib(jobs: int, tasks: list[Task]) -> Iterator[tuple[int, Row]]:
    try:
        from joblib import Parallel, cpu_count, delayed
        from joblib.externals.loky.process_executor import TerminatedWorkerError
    except ImportError as e:
        raise Error("sweeps need joblib; install it with `pip install rsph[sweep]`") from e
    if not isinstance(jobs, int) or jobs == 0:
        raise InputError(
            f"`jobs` = {jobs!r}: must be a number of processes, or -1",
            key="jobs",
            value=repr(jobs),
            remedy="give -1 for as many runs at a time as there are processors",
        )
    processors = cpu_count()
    workers = min(len(tasks), jobs if jobs > 0 else max(1, processors + 1 + jobs))
    threads = max(1, processors // workers)

    def parallel(indices: list[int], at_a_time: int) -> Iterator[tuple[int, Row]]:
        # The backend loky has processes even where only one runs at a time.
        pool = Parallel(n_jobs=max(2, at_a_time), return_as="generator_unordered", batch_size=1)
        yield from pool(delayed(_run)(i, tasks[i], threads) for i in indices)

    left = set(range(len(tasks)))
    if workers > 1:
        try:
            for i, row in parallel(sorted(left), workers):
                left.discard(i)
                yield i, row
        except TerminatedWorkerError:
            pass  # one of those that are left; each of them gets a process of its own
    for i in sorted(left):
        try:
            yield from parallel([i], 1)
        except TerminatedWorkerError:
            values, folder = tasks[i][1:]
            error = "the process of this run was ended from outside, perhaps for want of memory"
            yield i, {**values, "status": "killed", "error": error, "output": folder}


def _on_dask(client: Any, tasks: list[Task]) -> Iterator[tuple[int, Row]]:
    from distributed import as_completed

    futures = {client.submit(_run, i, task, None, pure=False): i for i, task in enumerate(tasks)}
    for future in as_completed(list(futures)):
        i = futures[future]
        if future.status == "finished":
            yield future.result()
        else:
            values, folder = tasks[i][1:]
            error = f"the worker failed: {future.exception()}"
            yield i, {**values, "status": "killed", "error": error, "output": folder}


def _folders(output: str | os.PathLike[str] | None, count: int) -> list[str | None]:
    if output is None:
        return [None] * count
    root = Path(output)
    if root.exists() and (not root.is_dir() or any(root.iterdir())):
        raise InputError(
            f"`output` = {os.fspath(root)!r}: is there already and not an empty folder",
            key="output",
            value=os.fspath(root),
            remedy="choose another folder, or remove this one",
        )
    return [str(root / f"{i:04}") for i in range(count)]


def _is_list(values: object) -> bool:
    return isinstance(values, Sequence | np.ndarray) or hasattr(values, "__len__")


def _table(rows: list[Row], parameters: Mapping[str, Any]) -> Any:
    """The rows as a DataFrame or columns; what a row lacks is NaN."""
    names = list(dict.fromkeys(itertools.chain(parameters, *rows)))
    for last in ("error", "output"):
        names.remove(last)
    names.append("error")
    if any(row["output"] is not None for row in rows):
        names.append("output")
    columns = {name: [row.get(name, np.nan) for row in rows] for name in names}
    try:
        import pandas as pd
    except ImportError:
        return {name: _column(values) for name, values in columns.items()}
    return pd.DataFrame(columns)


def _column(values: list[Any]) -> Any:
    if all(isinstance(v, int | float | np.number) for v in values):
        return np.array(values)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column
