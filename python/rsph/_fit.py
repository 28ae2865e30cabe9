"""What fits of materials to measurements share."""

from __future__ import annotations

import importlib
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from rsph.errors import Error, InputError

Array: TypeAlias = npt.NDArray[np.float64]

UNSURE = 0.2
"""A value with a larger relative error is told of."""


def scipy_module(module: str) -> Any:
    """A part of SciPy, or the error that says how to install it."""
    try:
        return importlib.import_module(f"scipy.{module}")
    except ImportError as e:
        raise Error("this needs SciPy; install it with `pip install rsph[fit]`") from e


def half_width(confidence: float, freedom: int | None) -> float:
    """Half an interval in standard errors; None: the size of the noise was given.

    Raises:
        InputError: `confidence` is no probability.
    """
    if not 0.0 < confidence < 1.0:
        raise InputError(
            f"`confidence` = {confidence}: must lie between 0 and 1",
            key="confidence",
            value=str(confidence),
            remedy="0.95 is usual",
        )
    stats = scipy_module("stats")
    scatter = stats.norm() if freedom is None else stats.t(freedom)
    return float(scatter.ppf(0.5 + 0.5 * confidence))


def noise_of(sigma: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    """The standard deviation of the noise at each point of a measurement."""
    try:
        noise = np.broadcast_to(np.asarray(sigma, dtype=np.float64), shape)
    except (TypeError, ValueError):
        noise = np.zeros(shape)
    if not (np.isfinite(noise).all() and (noise > 0.0).all()):
        raise InputError(
            "`sigma`: must be positive, one number or one for each point",
            key="sigma",
            remedy="leave it out if it is not known",
        )
    return noise
