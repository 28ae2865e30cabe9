"""Laws fitted to measured stress-stretch curves."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from rsph import _rsph
from rsph._fit import UNSURE, Array, half_width, noise_of, scipy_module
from rsph._loading import STRESS_KINDS, component, first_instability, modes_of, one_of
from rsph._scenario import scenario
from rsph.errors import Error, InputError, RsphWarning

if TYPE_CHECKING:
    from rsph.materials import Material

# Correlation of the residuals of neighbours that chance makes once in a thousand, in its errors.
_TOGETHER = 3.1
# A misfit below this part of the largest stress is of no interest.
_SMALL_MISFIT = 1e-3


@dataclass(frozen=True, kw_only=True)
class CurveFit:
    """A law fitted to measured stress, with what is known of its parameters.

    Standard errors are those of a least-squares fit with noise of equal size at all points (or of
    the given size); intervals hold the true value with the probability ``confidence`` if the noise
    is independent and the material follows the law.

    Attributes:
        material: the material of the law with the fitted parameters and no damping.
        parameters: fitted parameters in their units, by name; the terms of Ogden's law as
            arrays.
        errors: their standard errors.
        intervals: their confidence intervals, shape (2,), or (2, terms) of Ogden's law.
        covariance: of all parameters in the order of ``parameters``.
        fitted: stress of the law at the measured stretches (Pa), shape (N,).
        residual: root mean square of measured less fitted (Pa).
        confidence: probability of the intervals.
        notes: what was warned of.
    """

    material: Material
    parameters: dict[str, float | Array]
    errors: dict[str, float | Array]
    intervals: dict[str, Array]
    covariance: Array
    fitted: Array
    residual: float
    confidence: float
    notes: tuple[str, ...]

    def __str__(self) -> str:
        return ", ".join(
            f"{name} = {np.array2string(np.asarray(value), precision=4)}"
            f" +- {np.array2string(np.asarray(self.errors[name]), precision=2)}"
            for name, value in self.parameters.items()
        )


def from_curve(
    stretch: npt.ArrayLike,
    stress: npt.ArrayLike,
    *,
    law: str = "neo-hookean",
    mode: str | Sequence[str] = "uniaxial",
    stress_kind: str = "nominal",
    terms: int = 1,
    sigma: npt.ArrayLike | None = None,
    confidence: float = 0.95,
    density: float = 1000.0,
    poisson_ratio: float = 0.49,
) -> CurveFit:
    """The material of a measured stress-stretch curve (needs SciPy: ``pip install rsph[fit]``).

    The stress fitted is that of the law as it is simulated, with this Poisson's ratio and no stress
    on the free faces. Several curves, one after the other with their modes, are fitted at once:
    parameters that one mode cannot tell apart, two often can.

    >>> import numpy as np
    >>> stretch = np.linspace(1.0, 1.5, 20)
    >>> from rsph.materials import Yeoh, from_curve
    >>> tissue = Yeoh(density=1000.0, c1=500.0, c2=80.0, c3=10.0, poisson_ratio=0.49)
    >>> stress = tissue.stress(stretch)
    >>> fit = from_curve(stretch, stress, law="yeoh")
    >>> round(fit.parameters["c1"], 3), round(fit.parameters["c2"], 3)
    (500.0, 80.0)

    Args:
        stretch: length over undeformed length, or amount of shear in the mode ``shear``,
            shape (N,).
        stress: stress along the stretch (Pa), pull positive, shape (N,).
        law: ``neo-hookean``, ``mooney-rivlin``, ``yeoh``, ``ogden``, ``veronda-westmann``,
            ``fung``, ``st-venant-kirchhoff``, ``corotated`` or ``kelvin-voigt``.
        mode: ``uniaxial`` (pulled or pressed along one axis), ``equibiaxial`` (along two),
            ``planar`` (a wide strip, pure shear) or ``shear`` (simple shear); one, or one for each
            point.
        stress_kind: ``nominal`` (force over undeformed area) or ``cauchy``.
        terms: number of terms of Ogden's law, 1 to 6.
        sigma: standard deviation of the noise (Pa), one number or shape (N,); by default it is
            found from the scatter, equal at all points.
        confidence: probability of the intervals.
        density: passed on to the material (kg/m^3); by default that of water.
        poisson_ratio: Poisson's ratio of the material at small strain.

    Raises:
        InputError: numbers that are no measurement, or too few of them; a law that is not known.
        Error: no fit was found, or SciPy is not installed.
    """
    from rsph.materials import model

    candidate = _candidate(law, terms)
    curve = _measured(stretch, stress, mode, stress_kind, len(candidate.names))
    noise = None if sigma is None else noise_of(sigma, curve.stress.shape)
    freedom = len(curve.stress) - len(candidate.names)
    width = half_width(confidence, None if noise is not None else freedom)

    def keywords(p: Array) -> dict[str, float | list[float]]:
        solid = {"density": density, "poisson_ratio": poisson_ratio, "relaxation_time": 0.0}
        return {**solid, **candidate.keywords(p)}

    def stress_of(p: Array) -> Array:
        first_piola = _rsph.Law(scenario(material={"model": law, **keywords(p)})).first_piola
        with np.errstate(all="ignore"):
            return component(first_piola, curve.stretch, curve.modes, curve.stress_kind)

    best = _least_squares(candidate, stress_of, curve.stress, noise)
    fitted = stress_of(best.parameters)
    material = model(law, **keywords(best.parameters))
    return _with_errors(candidate, best, curve, fitted, width, confidence, material)


class _Curve(NamedTuple):
    """A measurement."""

    stretch: Array
    stress: Array
    modes: npt.NDArray[np.str_]
    stress_kind: str


class _Candidate(NamedTuple):
    """A law whose parameters are fitted: all its stresses grow with its shear modulus."""

    names: tuple[str, ...]
    """Names of the parameters, in order; of Ogden's law that of each term."""
    shapes: tuple[tuple[float, ...], ...]
    """First guesses of what it has besides the shear modulus, as free numbers."""
    parameters: Callable[[float, Array], Array]
    """The parameters of a shear modulus and the free numbers."""

    def keywords(self, p: Array) -> dict[str, float | list[float]]:
        """The parameters by the names that the material takes."""
        values: dict[str, float | list[float]] = {}
        for name in dict.fromkeys(self.names):
            own = [float(x) for x, n in zip(p, self.names, strict=True) if n == name]
            values[name] = own if name in ("moduli", "exponents") else own[0]
        return values


def _candidate(law: str, terms: int) -> _Candidate:
    """How a law is fitted."""
    if not 1 <= terms <= 6:
        raise InputError(
            f"`terms` = {terms}: must lie between 1 and 6",
            key="terms",
            value=str(terms),
            remedy="start with 1",
        )
    exp = np.exp
    stiffening = tuple((float(np.log(b)),) for b in (0.1, 0.5, 2.0, 8.0, 30.0, 100.0))
    exponents = combinations((2.0, -2.0, 6.0, -6.0, 14.0, -14.0, 30.0, -30.0), terms)

    def ogden(mu: float, shape: Array) -> Array:
        moduli = mu * exp(np.concatenate([[0.0], shape[: terms - 1]]))
        order = np.argsort(shape[terms - 1 :])
        return np.concatenate([moduli[order], shape[terms - 1 :][order]])

    laws = {
        "mooney-rivlin": _Candidate(
            ("c10", "c01"),
            ((0.0,), (0.5,)),
            lambda mu, s: 0.5 * mu * np.array([1.0 - s[0], s[0]]),
        ),
        "yeoh": _Candidate(
            ("c1", "c2", "c3"),
            ((0.0, 0.0), (0.5, 0.5)),
            lambda mu, s: 0.5 * mu * np.array([1.0, s[0], s[1]]),
        ),
        "veronda-westmann": _Candidate(
            ("c1", "c2"), stiffening, lambda mu, s: np.array([mu / exp(s[0]), exp(s[0])])
        ),
        "fung": _Candidate(
            ("shear_modulus", "exponent"), stiffening, lambda mu, s: np.array([mu, exp(s[0])])
        ),
        "ogden": _Candidate(
            ("moduli",) * terms + ("exponents",) * terms,
            tuple((0.0,) * (terms - 1) + e for e in exponents),
            ogden,
        ),
    }
    one_modulus = ("neo-hookean", "st-venant-kirchhoff", "corotated", "kelvin-voigt")
    laws |= {
        name: _Candidate(("young_modulus",), ((),), lambda mu, _: np.array([mu]))
        for name in one_modulus
    }
    one_of("law", law, tuple(laws))
    return laws[law]


class _Best(NamedTuple):
    """The best parameters and what their covariance is, for noise of the given size."""

    parameters: Array
    covariance: Array
    cost: float
    """Sum of squares of residual over noise, or else over the largest stress."""
    is_noise_known: bool


def _least_squares(
    candidate: _Candidate,
    stress_of: Callable[[Array], Array],
    measured: Array,
    noise: Array | None,
) -> _Best:
    """The best parameters, from the most promising of several guesses."""
    optimize = scipy_module("optimize")
    unit = np.full(measured.shape, np.abs(measured).max()) if noise is None else noise

    def parameters(x: Array) -> Array:
        # Logarithms keep moduli positive.
        return candidate.parameters(float(np.exp(np.clip(x[0], -200.0, 200.0))), x[1:])

    def residual(x: Array) -> Array:
        return (stress_of(parameters(x)) - measured) / unit

    starts = []
    for shape in candidate.shapes:
        # The stress grows with the modulus, so that its best value is known.
        of_one = stress_of(candidate.parameters(1.0, np.array(shape))) / unit
        if not np.isfinite(of_one).all():
            continue
        modulus = float(of_one @ (measured / unit) / (of_one @ of_one))
        if modulus > 0.0:
            x = np.array([np.log(modulus), *shape])
            starts.append((float(np.sum(residual(x) ** 2)), x))
    starts.sort(key=lambda start: start[0])
    best = None
    for _, x in starts[:3]:
        found = optimize.least_squares(
            residual, x, jac="3-point", x_scale="jac", xtol=1e-10, ftol=1e-10, gtol=1e-10
        )
        if np.isfinite(found.cost) and (best is None or found.cost < best.cost):
            best = found
    if best is None:
        raise Error("no parameters of this law come near the measured curve")
    steps = 1e-6 * np.eye(best.x.size)
    change = np.stack([parameters(best.x + e) - parameters(best.x - e) for e in steps], axis=1)
    return _Best(
        parameters(best.x),
        _covariance(best.jac, change / 2e-6),
        2.0 * float(best.cost),
        noise is not None,
    )


def _covariance(jacobian: Array, change: Array) -> Array:
    """Covariance for noise of size 1, infinite where the measurement says nothing."""
    _, singular, axes = np.linalg.svd(jacobian, full_matrices=False)
    unknown = singular <= 1e-9 * singular[0]
    spread = change @ (axes / np.where(unknown, 1.0, singular)[:, None]).T
    covariance: Array = spread @ spread.T
    touched = (np.abs(change @ axes[unknown].T) > 1e-9 * np.abs(change).max()).any(axis=1)
    covariance[touched, :] = covariance[:, touched] = np.inf
    return covariance


def _with_errors(
    candidate: _Candidate,
    best: _Best,
    curve: _Curve,
    fitted: Array,
    width: float,
    confidence: float,
    material: Material,
) -> CurveFit:
    """The fit with standard errors and intervals; warns where it is unsure."""
    left = curve.stress - fitted
    freedom = len(left) - len(best.parameters)
    covariance = best.covariance * (1.0 if best.is_noise_known else best.cost / freedom)
    error = np.sqrt(np.diag(covariance))
    notes = (
        *_unknown(candidate, best.parameters, error),
        *_misfit(best, curve, left, freedom),
        *_instability(material, curve),
    )
    for note in notes:
        warnings.warn(note, RsphWarning, stacklevel=3)

    def by_name(numbers: Array) -> dict[str, float | Array]:
        return {
            name: np.array(value) if isinstance(value, list) else value
            for name, value in candidate.keywords(numbers).items()
        }

    low, high = (by_name(best.parameters + side * width * error) for side in (-1.0, 1.0))
    return CurveFit(
        material=material,
        parameters=by_name(best.parameters),
        errors=by_name(error),
        intervals={name: np.array([low[name], high[name]]) for name in low},
        covariance=covariance,
        fitted=fitted,
        residual=float(np.sqrt(np.mean(left**2))),
        confidence=confidence,
        notes=notes,
    )


def _unknown(candidate: _Candidate, values: Array, errors: Array) -> list[str]:
    """Says which parameters the measurement does not tell."""
    unsure = [
        f"{name} = {value:.3g} +- {error:.2g}"
        for name, value, error in zip(candidate.names, values, errors, strict=True)
        if not error < UNSURE * abs(value)
    ]
    if not unsure:
        return []
    return [
        f"the measurement does not tell {', '.join(unsure)}: measure to larger stretches or in "
        "another mode as well, or take a law of fewer parameters"
    ]


def _misfit(best: _Best, curve: _Curve, left: Array, freedom: int) -> list[str]:
    """Says where the law does not follow the curve, so that errors mean little."""
    rms = float(np.sqrt(np.mean(left**2)))
    share = rms / float(np.abs(curve.stress).max())
    if best.is_noise_known:
        chance = float(scipy_module("stats").chi2.sf(best.cost, freedom))
        is_wrong = chance < 1e-3
    else:
        order = np.lexsort((curve.stretch, curve.modes))
        sorted_left, modes = left[order], curve.modes[order]
        pairs = sorted_left[1:] * sorted_left[:-1]
        together = float(pairs[modes[1:] == modes[:-1]].sum() / max(float(left @ left), 1e-300))
        is_wrong = together * np.sqrt(len(left)) > _TOGETHER
    if not (is_wrong and share > _SMALL_MISFIT):
        return []
    return [
        f"the law does not follow the curve: it misses it by {100 * share:.2g} % of the largest "
        "stress, which is not noise; the errors of the parameters leave that out"
    ]


def _instability(material: Material, curve: _Curve) -> list[str]:
    """Says where the fitted law is unstable in the range of the measurement."""
    is_shear = curve.modes == "shear"
    half = 0.5 * np.abs(curve.stretch[is_shear])
    sheared = half + np.sqrt(1.0 + half**2)
    stretches = np.concatenate([curve.stretch[~is_shear], sheared, 1.0 / sheared])
    with np.errstate(all="ignore"):
        where = first_instability(
            material.first_piola, float(stretches.min()), float(stretches.max())
        )
    if where is None:
        return []
    mode, stretch = where
    return [
        f"the fitted law is unstable at a stretch of {stretch:.3g} ({mode}), within the range of "
        "the measurement: simulations that come there fail; take another law, or measure that mode"
    ]


def _measured(
    stretch: npt.ArrayLike,
    stress: npt.ArrayLike,
    mode: str | Sequence[str],
    stress_kind: str,
    parameters: int,
) -> _Curve:
    """The measurement, if it is one."""

    def refuse(key: str, problem: str, remedy: str) -> InputError:
        return InputError(f"`{key}`: {problem}", key=key, remedy=remedy)

    one_of("stress_kind", stress_kind, STRESS_KINDS)
    try:
        x, y = (np.asarray(values, dtype=np.float64) for values in (stretch, stress))
    except (TypeError, ValueError):
        raise refuse("stretch", "stretch and stress must be numbers", "give two arrays") from None
    if x.ndim != 1 or x.shape != y.shape:
        shapes = f"{x.shape} and {y.shape}"
        problem = f"stretch and stress have the shapes {shapes}"
        raise refuse("stress", problem, "give a stress for each stretch")
    modes = modes_of(mode, x.shape)
    if len(x) < parameters + 1:
        problem = f"{len(x)} points are too few for {parameters} parameters"
        raise refuse("stretch", problem, f"measure {parameters + 1} points or more")
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        problem = "stretch and stress must be finite"
        raise refuse("stress", problem, "leave out what was not measured")
    is_shear = modes == "shear"
    if (x[~is_shear] <= 0.0).any():
        problem = "a stretch is the length over the undeformed length, 1 at rest"
        raise refuse("stretch", problem, "add 1 to a strain")
    strain = np.where(is_shear, x, x - 1.0)
    if not float(strain @ y) > 0.0:
        problem = "does not go with the stretch"
        raise refuse("stress", problem, "pull is positive, pressure negative, stretch 1 at rest")
    return _Curve(x, y, modes, stress_kind)
