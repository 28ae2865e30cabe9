"""The material of measured relaxation, as section 5.1 of the paper takes it from experiments."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rsph._fit import UNSURE, Array, half_width, noise_of, scipy_module
from rsph.errors import Error, InputError, RsphWarning

if TYPE_CHECKING:
    from rsph.materials import KelvinVoigt, Material, Numbers


# A measurement over fewer relaxation times is told of.
_LONG_ENOUGH = 2.0


@dataclass(frozen=True, kw_only=True)
class Relaxation:
    """What a measured relaxation modulus says about a material.

    The fit is a Prony series, E(t) = E + sum_i E_i exp(-t / T_i). Standard errors are those of a
    least-squares fit with noise of equal size at all times (or of the given size); intervals hold
    the true value with the probability ``confidence`` if the noise is independent and the material
    relaxes like that.

    Attributes:
        young_modulus: the limit E of the modulus for long times (Pa).
        young_modulus_error: its standard error (Pa).
        young_modulus_interval: its confidence interval (Pa), shape (2,).
        relaxation_time: T (s): T_1, or with several terms their mean, sum E_i T_i / sum E_i.
        relaxation_time_error: its standard error (s).
        relaxation_time_interval: its confidence interval (s), shape (2,).
        viscous_time: sum E_i T_i / E (s): the relaxation time of the Kelvin-Voigt solid that
            takes as much energy from slow motions as the measured material.
        amplitudes: the E_i (Pa), shape (M,).
        times: the T_i (s), ascending, shape (M,).
        covariance: of E, E_1, T_1, E_2, ..., shape (1 + 2 M, 1 + 2 M).
        prony: the series of a material whose moduli are those for long times: E_i / E and T_i (s)
            of each term, shape (M, 2).
        prony_errors: their standard errors, shape (M, 2).
        prony_intervals: lower and upper ends of their confidence intervals, shape (2, M, 2).
        residual: root mean square of measured less fitted (Pa).
        confidence: probability of the intervals.
        material: a Kelvin-Voigt solid with this modulus and relaxation time.
    """

    young_modulus: float
    young_modulus_error: float
    young_modulus_interval: Array
    relaxation_time: float
    relaxation_time_error: float
    relaxation_time_interval: Array
    viscous_time: float
    amplitudes: Array
    times: Array
    covariance: Array
    prony: Array
    prony_errors: Array
    prony_intervals: Array
    residual: float
    confidence: float
    material: KelvinVoigt

    def modulus(self, t: npt.ArrayLike) -> Array:
        """The fitted relaxation modulus (Pa) at times ``t`` (s), any shape."""
        t = np.asarray(t, dtype=np.float64)
        decay = np.exp(-t[..., None] / self.times)
        modulus: Array = self.young_modulus + decay @ self.amplitudes
        return modulus

    def viscoelastic(self, elastic: Material | None = None) -> Material:
        """The material that relaxes by the whole series, not by one Kelvin-Voigt time.

        >>> t = np.linspace(0.0, 10.0, 50)
        >>> fit = from_relaxation(t, 2e4 + 1e4 * np.exp(-t / 1.5))
        >>> fit.prony.round(3)
        array([[0.5, 1.5]])

        Args:
            elastic: a material of any law with the moduli for long times, such as that of
                :func:`from_curve` for slow loading; its damping is left out. By default the
                neo-Hookean solid of the measured modulus.
        """
        from rsph.materials import model

        name = "neo-hookean" if elastic is None else elastic.model
        parameters: dict[str, Numbers] = dict((elastic or self.material).parameters)
        return model(name, **parameters | {"relaxation_time": 0.0, "prony": self.prony})

    def __str__(self) -> str:
        return (
            f"E = {self.young_modulus:.4g} +- {self.young_modulus_error:.2g}, "
            f"T = {self.relaxation_time:.4g} +- {self.relaxation_time_error:.2g}"
        )


def from_relaxation(
    t: npt.ArrayLike,
    E_t: npt.ArrayLike,  # noqa: N803  as it is written in mechanics
    *,
    sigma: npt.ArrayLike | None = None,
    terms: int = 1,
    confidence: float = 0.95,
    density: float = 1000.0,
    poisson_ratio: float = 0.3,
) -> Relaxation:
    """The material of a measured relaxation modulus (needs SciPy: ``pip install rsph[fit]``).

    Young's modulus is the limit for long times, "to ensure the same stationary solution" (section
    5.1 of the paper), and the relaxation time is fitted with it.

    >>> import numpy as np
    >>> t = np.linspace(0.0, 10.0, 50)
    >>> fit = from_relaxation(t, 2e4 + 1e4 * np.exp(-t / 1.5))
    >>> round(fit.young_modulus), round(fit.relaxation_time, 3)
    (20000, 1.5)
    >>> fit.material
    materials.model('kelvin-voigt', density=1000.0, young_modulus=20000.0, ...)

    Args:
        t: times since the stretch (s), shape (N,).
        E_t: relaxation modulus at these times (Pa), shape (N,).
        sigma: standard deviation of the noise (Pa), shape (N,) or one number; by default it is
            found from the scatter, equal at all times.
        terms: number of exponentials.
        confidence: probability of the intervals.
        density: passed on to the material (kg/m^3); by default that of water, as in the paper.
        poisson_ratio: passed on to the material; by default that of the paper.

    Raises:
        InputError: numbers that are no measurement, or too few of them.
        Error: no fit was found, or SciPy is not installed.
    """
    times, moduli = _measured(t, E_t, 2 * terms + 2)
    noise = None if sigma is None else noise_of(sigma, times.shape)
    width = half_width(confidence, len(times) - 1 - 2 * terms if noise is None else None)
    series = _fit(times, moduli, noise, terms)
    material = _material(series, times, density, poisson_ratio)
    return _with_errors(series, times, moduli, width, confidence, material)


class _Series(NamedTuple):
    """A fitted Prony series."""

    limit: float
    amplitudes: Array
    times: Array
    covariance: Array
    """Of the limit, E_1, T_1, E_2, ..."""

    @property
    def mean_time(self) -> float:
        """sum E_i T_i / sum E_i."""
        return float(self.amplitudes @ self.times / self.amplitudes.sum())

    @property
    def limit_error(self) -> float:
        """Standard error of the limit."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def shares(self) -> Array:
        """E_i / E and T_i, shape (M, 2)."""
        return np.stack([self.amplitudes / self.limit, self.times], axis=1)

    @property
    def share_errors(self) -> Array:
        """Standard errors of E_i / E and T_i, shape (M, 2)."""
        slopes = np.zeros((2 * len(self.times), len(self.covariance)))
        slopes[:, 1:] = np.diag(np.tile([1.0 / self.limit, 1.0], len(self.times)))
        slopes[::2, 0] = -self.amplitudes / self.limit**2
        variances = np.einsum("ij,jk,ik->i", slopes, self.covariance, slopes)
        errors: Array = np.sqrt(variances).reshape(-1, 2)
        return errors

    @property
    def mean_time_error(self) -> float:
        """Standard error of the mean time."""
        total, slope = self.amplitudes.sum(), np.zeros(len(self.covariance))
        slope[1::2] = (self.times - self.mean_time) / total
        slope[2::2] = self.amplitudes / total
        return float(np.sqrt(slope @ self.covariance @ slope))


def _fit(times: Array, moduli: Array, noise: Array | None, terms: int) -> _Series:
    """The series by least squares, in units of the data so that one tolerance fits all."""
    optimize = scipy_module("optimize")
    span, size = times[-1] - times[0], float(np.abs(moduli).max())
    x, y = times / span, moduli / size

    def fitted(x: Array, *p: float) -> Array:
        # Logarithms keep times positive.
        return _prony(x, p[0], np.array(p[1::2]), np.exp(np.array(p[2::2])))

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optimize.OptimizeWarning)
            best, scaled = optimize.curve_fit(
                fitted,
                x,
                y,
                _start(x, y, terms),
                sigma=None if noise is None else noise / size,
                absolute_sigma=noise is not None,
                maxfev=20000,
            )
    except RuntimeError as e:
        raise Error(f"no Prony series of {terms} terms fits this relaxation: {e}") from e
    order = np.argsort(best[2::2])
    amplitudes, tau = best[1::2][order] * size, np.exp(best[2::2][order]) * span
    # From (E, E_1, ln T_1, ...) in units of the data to (E, E_1, T_1, ...).
    picked = np.concatenate([[0], np.ravel([(1 + 2 * k, 2 + 2 * k) for k in order])])
    scale = np.concatenate([[size], np.ravel([(size, T) for T in tau])])
    covariance = scaled[np.ix_(picked, picked)] * np.outer(scale, scale)
    return _Series(float(best[0] * size), amplitudes, tau, covariance)


def _material(series: _Series, times: Array, density: float, poisson_ratio: float) -> KelvinVoigt:
    """The Kelvin-Voigt solid with its limit and mean time; warns of too short a measurement."""
    from rsph.materials import KelvinVoigt

    limit, error = series.limit, series.limit_error
    seen = times[-1] > _LONG_ENOUGH * series.times.max()
    if not (np.isfinite(series.covariance).all() and error < UNSURE * limit and seen):
        warnings.warn(
            f"the limit of the modulus is not known well, {limit:.3g} +- {error:.2g}: "
            "the measurement is too short, or has more terms than it can tell apart",
            RsphWarning,
            stacklevel=3,
        )
    if not limit > 0.0:
        raise Error(
            f"the modulus falls to {limit:.3g} Pa: the measurement is too short to tell its limit"
        )
    return KelvinVoigt(
        density=density,
        young_modulus=limit,
        poisson_ratio=poisson_ratio,
        relaxation_time=series.mean_time,
    )


def _with_errors(
    series: _Series,
    times: Array,
    moduli: Array,
    width: float,
    confidence: float,
    material: KelvinVoigt,
) -> Relaxation:
    """The series with its standard errors and confidence intervals."""
    limit, error, mean = series.limit, series.limit_error, series.mean_time
    # The logarithm of a time is nearer to normal than the time.
    spread = np.exp(width * series.mean_time_error / mean)
    shares, share_errors = series.shares, series.share_errors
    factors = np.exp(width * share_errors[:, 1] / shares[:, 1])
    ends = [
        np.stack([shares[:, 0] + side * width * share_errors[:, 0], shares[:, 1] * factors**side])
        for side in (-1.0, 1.0)
    ]
    left = moduli - _prony(times, limit, series.amplitudes, series.times)
    return Relaxation(
        young_modulus=limit,
        young_modulus_error=error,
        young_modulus_interval=limit + width * error * np.array([-1.0, 1.0]),
        relaxation_time=mean,
        relaxation_time_error=series.mean_time_error,
        relaxation_time_interval=np.array([mean / spread, mean * spread]),
        viscous_time=float(series.amplitudes @ series.times) / limit,
        amplitudes=series.amplitudes,
        times=series.times,
        covariance=series.covariance,
        prony=shares,
        prony_errors=share_errors,
        prony_intervals=np.stack(ends).transpose(0, 2, 1),
        residual=float(np.sqrt(np.mean(left**2))),
        confidence=confidence,
        material=material,
    )


def _measured(t: npt.ArrayLike, modulus: npt.ArrayLike, fewest: int) -> tuple[Array, Array]:
    """Times and moduli in the order of time."""

    def refuse(key: str, problem: str, remedy: str) -> InputError:
        return InputError(f"`{key}`: {problem}", key=key, remedy=remedy)

    try:
        times = np.asarray(t, dtype=np.float64)
        moduli = np.asarray(modulus, dtype=np.float64)
    except (TypeError, ValueError):
        raise refuse("t", "times and moduli must be numbers", "give two arrays") from None
    if times.ndim != 1 or times.shape != moduli.shape:
        shapes = f"{times.shape} and {moduli.shape}"
        raise refuse("E_t", f"times and moduli have the shapes {shapes}", "give a modulus a time")
    if len(times) < fewest:
        raise refuse("t", f"{len(times)} times are too few", f"measure at {fewest} times or more")
    if not (np.isfinite(times).all() and np.isfinite(moduli).all()):
        raise refuse("E_t", "times and moduli must be finite", "leave out what was not measured")
    if times.min() < 0.0 or np.ptp(times) == 0.0:
        raise refuse("t", "times count from the stretch on, at 0", "give different times from 0 on")
    order = np.argsort(times, kind="stable")
    return times[order], moduli[order]


def _start(x: Array, y: Array, terms: int) -> list[float]:
    """A first guess (E, E_1, ln T_1, ...) from the ends of the curve."""
    tail = max(1, len(y) // 10)
    end = float(y[-tail:].mean())
    drop = float(y[: max(1, tail // 2)].mean()) - end
    passed = np.flatnonzero(y - end < np.exp(-1.0) * drop)
    time = max(float(x[passed[0]] - x[0]), 1e-3) if drop > 0.0 and len(passed) else 0.2
    guess: list[Any] = [end]
    for k in range(terms):
        guess += [drop / terms, np.log(time * 4.0 ** (k - 0.5 * (terms - 1)))]
    return [float(g) for g in guess]


def _prony(x: Array, limit: float, amplitudes: Array, times: Array) -> Array:
    values: Array = limit + np.exp(-x[:, None] / times) @ amplitudes
    return values
