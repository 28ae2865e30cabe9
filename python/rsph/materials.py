"""What bodies are made of.

Models come from the registry of the compiled half: :func:`models` lists them with their parameters
and units, and :func:`model` makes any of them by name.
"""

from __future__ import annotations

from typing import ClassVar, NamedTuple

from rsph import _rsph
from rsph._relaxation import Relaxation, from_relaxation
from rsph._scenario import check

__all__ = [
    "Corotated",
    "KelvinVoigt",
    "Material",
    "Model",
    "NeoHookean",
    "Parameter",
    "Relaxation",
    "SaintVenantKirchhoff",
    "from_relaxation",
    "model",
    "models",
]


class Parameter(NamedTuple):
    """A parameter of a material model."""

    key: str
    """Name."""
    unit: str
    """Unit in SI."""
    doc: str
    """What it is."""
    default: float | None
    """Value if it is left out; None: it is required."""


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

    def __init__(self, model: str, **parameters: float) -> None:
        self._model = model
        self._parameters = dict(parameters)
        check("material", material=self._as_table())

    @property
    def model(self) -> str:
        """Name of the model."""
        return self._model

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters by name."""
        return dict(self._parameters)

    def _as_table(self) -> dict[str, object]:
        return {"model": self._model, **self._parameters}

    def __repr__(self) -> str:
        arguments = "".join(f", {key}={value!r}" for key, value in self._parameters.items())
        return f"materials.model({self._model!r}{arguments})"


class _Viscoelastic(Material):
    """An isotropic solid with Kelvin-Voigt damping, by the name of its model."""

    _name: ClassVar[str]

    def __init__(
        self,
        *,
        density: float,
        young_modulus: float,
        poisson_ratio: float,
        relaxation_time: float,
    ) -> None:
        super().__init__(
            self._name,
            density=density,
            young_modulus=young_modulus,
            poisson_ratio=poisson_ratio,
            relaxation_time=relaxation_time,
        )


class KelvinVoigt(_Viscoelastic):
    """Linear elastic solid with Kelvin-Voigt damping, for small strain (Eq. 5 of the paper).

    Args:
        density: density (kg/m^3).
        young_modulus: Young's modulus (Pa).
        poisson_ratio: Poisson's ratio, greater than -1 and less than 0.5.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
    """

    _name = "kelvin-voigt"


class Corotated(_Viscoelastic):
    """Linear elastic solid with Kelvin-Voigt damping that may turn: small strain, any rotation.

    Args:
        density: undeformed density (kg/m^3).
        young_modulus: Young's modulus (Pa).
        poisson_ratio: Poisson's ratio, greater than -1 and less than 0.5.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
    """

    _name = "corotated"


class SaintVenantKirchhoff(_Viscoelastic):
    """Hooke's law for Green's strain, with Kelvin-Voigt damping: moderate strain, any rotation.

    Args:
        density: undeformed density (kg/m^3).
        young_modulus: Young's modulus at small strain (Pa).
        poisson_ratio: Poisson's ratio at small strain, greater than -1 and less than 0.5.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
    """

    _name = "st-venant-kirchhoff"


class NeoHookean(_Viscoelastic):
    """Compressible neo-Hookean solid with Kelvin-Voigt damping, for large strain and rotation.

    Args:
        density: undeformed density (kg/m^3).
        young_modulus: Young's modulus at small strain (Pa).
        poisson_ratio: Poisson's ratio at small strain, greater than -1 and less than 0.5.
        relaxation_time: relaxation time of the damping (s); 0 switches it off.
    """

    _name = "neo-hookean"


def model(name: str, **parameters: float) -> Material:
    """The material of the model ``name`` with these parameters; see :func:`models`."""
    return Material(name, **parameters)


def models() -> list[Model]:
    """All material models with their parameters."""
    return [
        Model(m["name"], m["doc"], tuple(Parameter(*p) for p in m["parameters"]))
        for m in _rsph.material_models()
    ]
