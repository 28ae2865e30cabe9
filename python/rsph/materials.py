"""What bodies are made of.

Models come from the registry of the compiled half: :func:`models` lists them with their parameters
and units, and :func:`model` makes any of them by name.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from rsph import _rsph
from rsph._curve import CurveFit, from_curve
from rsph._loading import STRESS_KINDS, component, is_isotropic, modes_of, one_of
from rsph._relaxation import Relaxation, from_relaxation
from rsph._scenario import check, scenario, without_none
from rsph.errors import InputError
from rsph.fields import table_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rsph._fit import Array
    from rsph.fields import Field
    from rsph.regions import Region
    from rsph.shapes import Shape

__all__ = [
    "Corotated",
    "CurveFit",
    "Fung",
    "HolzapfelGasserOgden",
    "KelvinVoigt",
    "Material",
    "Model",
    "MooneyRivlin",
    "NeoHookean",
    "Ogden",
    "Parameter",
    "Part",
    "Relaxation",
    "SaintVenantKirchhoff",
    "VerondaWestmann",
    "Yeoh",
    "from_curve",
    "from_relaxation",
    "model",
    "models",
]


Numbers: TypeAlias = "float | Iterable[float] | Iterable[Iterable[float]]"
"""A number, several of them, or several pairs."""

Pairs: TypeAlias = "Iterable[Iterable[float]]"
"""Pairs of numbers, shape (N, 2)."""

_Values: TypeAlias = "float | list[float] | list[list[float]]"


class Parameter(NamedTuple):
    """A parameter of a material model."""

    key: str
    """Name."""
    unit: str
    """Unit in SI."""
    doc: str
    """What it is."""
    default: float | None
    """Value if it is left out; None: there is none."""
    numbers: tuple[int, int]
    """Fewest and most numbers that it takes; 0: it may be left out."""


class Model(NamedTuple):
    """A material model that can be made by :func:`model`."""

    name: str
    """Name in scenario files and for :func:`model`."""
    doc: str
    """One line about it."""
    parameters: tuple[Parameter, ...]
    """What it needs."""


class Material:
    """A material: the name of its model and its parameters."""

    _model: str
    _parameters: dict[str, _Values]

    def __init__(self, model: str, **parameters: Numbers) -> None:
        numbers = {key: _plain(value) for key, value in parameters.items()}
        # The dataclasses below are frozen.
        vars(self).update(_model=model, _parameters=numbers)
        check("material", material=self._as_table())

    @property
    def model(self) -> str:
        """Name of the model."""
        return self._model

    @property
    def parameters(self) -> dict[str, _Values]:
        """Parameters by name."""
        return dict(self._parameters)

    def first_piola(self, deformation_gradient: npt.ArrayLike) -> Array:
        """First Piola-Kirchhoff stress at rest (Pa): force over undeformed area.

        Args:
            deformation_gradient: F = dx/dX, shape (..., 3, 3), which is also that of the stress.
        """
        f = np.asarray(deformation_gradient, dtype=np.float64)
        if f.shape[-2:] != (3, 3):
            raise InputError(
                f"`deformation_gradient` has the shape {f.shape}",
                key="deformation_gradient",
                value=str(f.shape),
                remedy="give three rows of three numbers, in an array of shape (..., 3, 3)",
            )
        law = _rsph.Law(scenario(material=self._as_table()))
        return law.first_piola(f.reshape(-1, 3, 3)).reshape(f.shape)

    def stress(
        self,
        stretch: npt.ArrayLike,
        *,
        mode: str | Sequence[str] = "uniaxial",
        stress_kind: str = "nominal",
    ) -> Array:
        """Stress at rest (Pa) along the stretch, as a testing machine measures it.

        >>> gel = MooneyRivlin(density=1000.0, c10=500.0, poisson_ratio=0.4999)
        >>> gel.stress([0.5, 2.0]).round(-1)
        array([-3500.,  1750.])

        Args:
            stretch: length over undeformed length, or amount of shear in the mode ``shear``,
                shape (N,) or one number.
            mode: as of :func:`from_curve`; no stress acts on the free faces.
            stress_kind: ``nominal`` (force over undeformed area) or ``cauchy``.

        Raises:
            InputError: the material is not isotropic, so that it shears when it is pulled.
        """
        one_of("stress_kind", stress_kind, STRESS_KINDS)
        x = np.asarray(stretch, dtype=np.float64)
        modes = modes_of(mode, x.shape).ravel()
        first_piola = _rsph.Law(scenario(material=self._as_table())).first_piola
        if not is_isotropic(first_piola):
            raise InputError(
                f"`{self._model}` with fibres: what it does when it is pulled depends on the way",
                key="model",
                value=self._model,
                remedy="use first_piola with a deformation gradient",
            )
        if not (x.ravel()[modes != "shear"] > 0.0).all():
            raise InputError(
                "`stretch`: must be positive, the length over the undeformed length",
                key="stretch",
                remedy="add 1 to a strain",
            )
        return component(first_piola, x.ravel(), modes, stress_kind).reshape(x.shape)

    def _as_table(self) -> dict[str, object]:
        return {"model": self._model, **self._parameters}

    def __repr__(self) -> str:
        arguments = "".join(f", {key}={value!r}" for key, value in self._parameters.items())
        return f"materials.model({self._model!r}{arguments})"


@dataclass(frozen=True, kw_only=True)
class Part:
    """A material in a part of a body, for a body of several: ``material=[parenchyma, Part(...)]``.

    Each part lies over those before it in the list. Where two materials meet, the stress of a
    particle is that of a laminate of both, so that the interface may lie anywhere.

    Attributes:
        material: of what.
        name: in results and messages; by default the name of the model.
        region: where, a region of :mod:`rsph.regions`; either this or ``shape``, or neither for the
            rest of the body.
        shape: where, as a closed shape of :mod:`rsph.shapes` such as the mesh of a tumour.
        modulus: Young's modulus at small strain as a field to which the law is scaled: a function
            of positions, shape (N, 3), that returns N moduli (Pa), or a table
            ``{"path": "elastography.nii.gz", "factor": 1000.0}`` of an image as in a scenario.
        fibres: direction of its fibres as a field of :mod:`rsph.fields`, such as a rotation for
            fibres around an axis, or a function of positions, shape (N, 3), that returns N vectors
            of any length but zero. The material is turned so that its ``fibre`` points there.
    """

    material: Material
    name: str | None = None
    region: Region | None = None
    shape: Shape | None = None
    modulus: Callable[[npt.NDArray[np.float64]], npt.ArrayLike] | Mapping[str, Any] | None = None
    fibres: Field | None = None

    def _as_table(self) -> dict[str, object]:
        table = without_none(
            name=self.name,
            region=None if self.region is None else self.region._as_table(),
            shape=None if self.shape is None else self.shape._as_table(),
            modulus=None if callable(self.modulus) else self.modulus,
            fibres=table_of("material.fibres", self.fibres),
        )
        return self.material._as_table() | table

    @property
    def _is_rest(self) -> bool:
        return self.region is None and self.shape is None


def _plain(value: Numbers) -> _Values:
    """Numbers as floats in lists."""
    if isinstance(value, (float, int)):
        return value
    numbers: _Values = np.asarray(list(value), dtype=np.float64).tolist()
    return numbers


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class _Law(Material):
    """A material whose parameters are its fields; those that are None are left out."""

    _name: ClassVar[str]

    prony: Pairs | None = None

    def __post_init__(self) -> None:
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        there = {key: value for key, value in given.items() if value is not None}
        super().__init__(self._name, **there)


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class _Viscoelastic(_Law):
    """An isotropic solid with Kelvin-Voigt damping."""

    density: float
    young_modulus: float
    poisson_ratio: float
    relaxation_time: float


class KelvinVoigt(_Viscoelastic):
    """Linear elastic solid with Kelvin-Voigt damping, for small strain (Eq. 5 of the paper).

    Args:
        density: density (kg/m^3).
        young_modulus: Young's modulus (Pa).
        poisson_ratio: Poisson's ratio, greater than -1 and less than 0.5.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "kelvin-voigt"


class Corotated(_Viscoelastic):
    """Linear elastic solid with Kelvin-Voigt damping that may turn: small strain, any rotation.

    Args:
        density: undeformed density (kg/m^3).
        young_modulus: Young's modulus (Pa).
        poisson_ratio: Poisson's ratio, greater than -1 and less than 0.5.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "corotated"


class SaintVenantKirchhoff(_Viscoelastic):
    """Hooke's law for Green's strain, with Kelvin-Voigt damping: moderate strain, any rotation.

    Args:
        density: undeformed density (kg/m^3).
        young_modulus: Young's modulus at small strain (Pa).
        poisson_ratio: Poisson's ratio at small strain, greater than -1 and less than 0.5.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "st-venant-kirchhoff"


class NeoHookean(_Viscoelastic):
    """Compressible neo-Hookean solid with Kelvin-Voigt damping, for large strain and rotation.

    Args:
        density: undeformed density (kg/m^3).
        young_modulus: Young's modulus at small strain (Pa).
        poisson_ratio: Poisson's ratio at small strain, greater than -1 and less than 0.5.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "neo-hookean"


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class _Tissue(_Law):
    """A nearly incompressible law of tissue; the volume resists by one of two moduli."""

    density: float
    bulk_modulus: float | None = None
    poisson_ratio: float | None = None
    relaxation_time: float = 0.0


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class MooneyRivlin(_Tissue):
    """Mooney-Rivlin solid: w = c10 (I1 - 3) + c01 (I2 - 3), with K/2 (ln J)^2 for the volume.

    Args:
        density: undeformed density (kg/m^3).
        c10: factor of I1 - 3 (Pa); 2 (c10 + c01) is the shear modulus at small strain.
        c01: factor of I2 - 3 (Pa).
        bulk_modulus: bulk modulus K (Pa); or else poisson_ratio.
        poisson_ratio: Poisson's ratio at small strain; or else bulk_modulus.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "mooney-rivlin"

    c10: float
    c01: float = 0.0


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Yeoh(_Tissue):
    """Yeoh's solid: w = c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3.

    Args:
        density: undeformed density (kg/m^3).
        c1: factor of I1 - 3 (Pa): half the shear modulus at small strain.
        c2: factor of (I1 - 3)^2 (Pa).
        c3: factor of (I1 - 3)^3 (Pa).
        bulk_modulus: bulk modulus K (Pa); or else poisson_ratio.
        poisson_ratio: Poisson's ratio at small strain; or else bulk_modulus.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "yeoh"

    c1: float
    c2: float = 0.0
    c3: float = 0.0


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Ogden(_Tissue):
    """Ogden's solid: sum of 2 mu_i / a_i^2 (l1^a_i + l2^a_i + l3^a_i - 3), l principal stretches.

    Args:
        density: undeformed density (kg/m^3).
        moduli: mu_i of one to six terms (Pa); their sum is the shear modulus at small strain.
        exponents: exponent a_i of each term.
        bulk_modulus: bulk modulus K (Pa); or else poisson_ratio.
        poisson_ratio: Poisson's ratio at small strain; or else bulk_modulus.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "ogden"

    moduli: Numbers
    exponents: Numbers


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class VerondaWestmann(_Tissue):
    """Solid of Veronda and Westmann: w = c1 (exp(c2 (I1 - 3)) - 1) - c1 c2 / 2 (I2 - 3).

    Args:
        density: undeformed density (kg/m^3).
        c1: scale of the stress (Pa); c1 c2 is the shear modulus at small strain.
        c2: how fast it stiffens.
        bulk_modulus: bulk modulus K (Pa); or else poisson_ratio.
        poisson_ratio: Poisson's ratio at small strain; or else bulk_modulus.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "veronda-westmann"

    c1: float
    c2: float


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Fung(_Tissue):
    """Fung's exponential: w = mu / (2 b) (exp(b (I1 - 3)) - 1).

    Args:
        density: undeformed density (kg/m^3).
        shear_modulus: shear modulus mu at small strain (Pa).
        exponent: b, how fast it stiffens.
        bulk_modulus: bulk modulus K (Pa); or else poisson_ratio.
        poisson_ratio: Poisson's ratio at small strain; or else bulk_modulus.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "fung"

    shear_modulus: float
    exponent: float


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class HolzapfelGasserOgden(_Tissue):
    """Neo-Hookean ground with two families of dispersed fibres, which resist when stretched.

    Args:
        density: undeformed density (kg/m^3).
        shear_modulus: shear modulus of the ground (Pa).
        k1: stiffness of the fibres (Pa).
        k2: how fast they stiffen.
        fibre: their direction in the undeformed body, three numbers.
        second_fibre: direction of the second family; as the first if it is left out.
        dispersion: kappa, 0 for aligned fibres to 1/3 for fibres without direction.
        bulk_modulus: bulk modulus K (Pa); or else poisson_ratio.
        poisson_ratio: Poisson's ratio of the ground at small strain; or else bulk_modulus.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
        prony: terms (gamma, tau) of a Prony series in the place of damping, shape (N, 2): stiffness
            over the stiffness for long times, and relaxation time (s). The moduli are for long
            times.
    """

    _name = "holzapfel-gasser-ogden"

    shear_modulus: float
    k1: float
    k2: float
    fibre: Iterable[float]
    second_fibre: Iterable[float] | None = None
    dispersion: float = 0.0


def model(name: str, **parameters: Numbers) -> Material:
    """The material of the model ``name`` with these parameters; see :func:`models`."""
    return Material(name, **parameters)


def models() -> list[Model]:
    """All material models with their parameters."""
    return [
        Model(m["name"], m["doc"], tuple(Parameter(*p) for p in m["parameters"]))
        for m in _rsph.material_models()
    ]
