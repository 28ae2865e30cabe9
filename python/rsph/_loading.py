"""Homogeneous states in which materials are measured, and the stress that a law has there."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from rsph.errors import InputError

Array: TypeAlias = npt.NDArray[np.float64]

FirstPiola: TypeAlias = Callable[[Array], Array]
"""First Piola-Kirchhoff stress (Pa) of deformation gradients, both (N, 3, 3)."""

# The logarithm of the free stretch over that of the given one, if the volume stays.
_FREE = {"uniaxial": -0.5, "equibiaxial": -2.0, "planar": -1.0}

MODES = (*_FREE, "shear")
STRESS_KINDS = ("nominal", "cauchy")


def one_of(key: str, value: object, allowed: tuple[str, ...]) -> None:
    """Raises InputError if a word is none of those allowed."""
    if value not in allowed:
        raise InputError(
            f"`{key}` = {value!r}: there is no such one",
            key=key,
            value=str(value),
            remedy="one of " + ", ".join(allowed),
        )


def modes_of(mode: object, shape: tuple[int, ...]) -> npt.NDArray[np.str_]:
    """The mode of each point, from one for all or one for each."""
    modes = np.asarray(mode, dtype=np.str_)
    for name in np.unique(modes):
        one_of("mode", str(name), MODES)
    if modes.shape not in ((), shape):
        raise InputError(
            f"`mode` has the shape {modes.shape} and `stretch` {shape}",
            key="mode",
            remedy="give one mode for all points, or one for each",
        )
    each: npt.NDArray[np.str_] = np.broadcast_to(modes, shape)
    return each


def gradients(first_piola: FirstPiola, stretch: Array, modes: npt.NDArray[np.str_]) -> Array:
    """Deformation gradients (N, 3, 3) with no stress on the free faces; NaN where there is none.

    The stretch lies along x. In `uniaxial` y and z are free, in `equibiaxial` y is stretched like x
    and z is free, in `planar` y is held and z is free. In `shear` the stretch is the amount of
    shear u_x / y, and nothing is free.
    """
    f = np.broadcast_to(np.eye(3), (len(stretch), 3, 3)).copy()
    is_shear = modes == "shear"
    f[is_shear, 0, 1] = stretch[is_shear]
    f[~is_shear, 0, 0] = stretch[~is_shear]
    is_equibiaxial, is_uniaxial = modes == "equibiaxial", modes == "uniaxial"
    f[is_equibiaxial, 1, 1] = stretch[is_equibiaxial]

    def with_free(x: Array) -> Array:
        s = np.exp(x)
        full: Array = f.copy()
        full[is_uniaxial, 1, 1] = s[is_uniaxial]
        full[~is_shear, 2, 2] = s[~is_shear]
        return full

    def free_stress(x: Array) -> Array:
        stress: Array = first_piola(with_free(x))[:, 2, 2]
        return np.where(is_shear, x, stress)

    factor = np.array([_FREE.get(str(mode), 0.0) for mode in modes])
    same_volume = factor * np.log(np.where(is_shear, 1.0, stretch))
    return with_free(_root(free_stress, same_volume))


def component(
    first_piola: FirstPiola, stretch: Array, modes: npt.NDArray[np.str_], kind: str
) -> Array:
    """The stress (Pa) that is measured: along x, in `shear` that along x on faces across y."""
    f = gradients(first_piola, stretch, modes)
    stress = first_piola(f)
    if kind == "cauchy":
        volume = np.linalg.det(f)
        stress = stress @ f.transpose(0, 2, 1) / volume[:, None, None]
    measured: Array = np.where(modes == "shear", stress[:, 0, 1], stress[:, 0, 0])
    return measured


def first_instability(
    first_piola: FirstPiola, lowest: float, highest: float
) -> tuple[str, float] | None:
    """The mode and the stretch nearest 1 where Drucker's condition fails between two stretches.

    The condition: d tau : d ln V > 0 for any change of the stretches, with Kirchhoff's stress tau.
    """
    low, high = np.log(min(lowest, 1.0)), np.log(max(highest, 1.0))
    parts = [np.linspace(0.0, end, 41)[1:] for end in (low, high) if end != 0.0]
    if not parts:
        return None
    stretch = np.exp(np.concatenate(parts))
    worst: tuple[str, float] | None = None
    for mode in _FREE:
        f = gradients(first_piola, stretch, np.full(stretch.shape, mode))
        logarithms = np.log(np.diagonal(f, axis1=1, axis2=2))
        slopes = _kirchhoff_slopes(first_piola, logarithms)
        known = np.isfinite(slopes).all(axis=(1, 2))
        slopes[~known] = -np.eye(3)
        lowest_slope = np.asarray(np.linalg.eigvalsh(slopes)[:, 0], dtype=np.float64)
        for s in stretch[lowest_slope <= 0.0]:
            if worst is None or abs(np.log(s)) < abs(np.log(worst[1])):
                worst = (mode, float(s))
    return worst


def is_isotropic(first_piola: FirstPiola) -> bool:
    """Whether the stress of three stretches goes with them when they change places."""
    stretches = np.array([[1.05, 0.97, 1.01], [1.01, 1.05, 0.97], [0.97, 1.01, 1.05]])
    stress = first_piola(np.stack([np.diag(s) for s in stretches]))
    normal = np.array([np.diag(p)[[k % 3, (k + 1) % 3, (k + 2) % 3]] for k, p in enumerate(stress)])
    size = np.abs(stress).max()
    sheared = np.abs(stress - np.stack([np.diag(np.diag(p)) for p in stress])).max()
    return bool(np.ptp(normal, axis=0).max() < 1e-9 * size and sheared < 1e-9 * size)


def _kirchhoff_slopes(first_piola: FirstPiola, logarithms: Array) -> Array:
    """Symmetric part of d tau_i / d ln l_j, shape (N, 3, 3), by central differences."""
    step = 1e-5

    def kirchhoff(x: Array) -> Array:
        stretches = np.exp(x)
        stress = first_piola(stretches[:, :, None] * np.eye(3))
        principal: Array = np.diagonal(stress, axis1=1, axis2=2) * stretches
        return principal

    columns = [
        (kirchhoff(logarithms + step * e) - kirchhoff(logarithms - step * e)) / (2.0 * step)
        for e in np.eye(3)
    ]
    slopes = np.stack(columns, axis=2)
    symmetric: Array = 0.5 * (slopes + slopes.transpose(0, 2, 1))
    return symmetric


def _root(function: Callable[[Array], Array], guess: Array) -> Array:
    """Where growing functions are zero, by Newton's method between bounds; NaN where it fails."""
    low, high = np.minimum(guess, 0.0), np.maximum(guess, 0.0)
    width = np.maximum(high - low, 1e-3)
    with np.errstate(all="ignore"):
        for _ in range(12):
            is_low, is_high = function(low) <= 0.0, function(high) >= 0.0
            if (is_low & is_high).all():
                break
            low, high = np.where(is_low, low, low - width), np.where(is_high, high, high + width)
            width *= 2.0
        found = (function(low) <= 0.0) & (function(high) >= 0.0)
        x, step = np.clip(guess, low, high), 1e-7
        for _ in range(100):
            value = function(x)
            low, high = np.where(value <= 0.0, x, low), np.where(value >= 0.0, x, high)
            newton = x - value * step / (function(x + step) - value)
            inside = (newton >= low) & (newton <= high)
            following = np.where(value == 0.0, x, np.where(inside, newton, 0.5 * (low + high)))
            moved, x = np.abs(following - x), following
            if (moved[found] <= 1e-13).all():
                break
    root: Array = np.where(found, x, np.nan)
    return root
