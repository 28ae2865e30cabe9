"""Everything that rsph raises."""

from __future__ import annotations

from typing import Any

__all__ = [
    "Error",
    "InputError",
    "MissingFieldError",
    "RsphWarning",
    "SimulationError",
    "StorageError",
]


class Error(Exception):
    """Base class of all errors of rsph."""


class InputError(Error, ValueError):
    """Something that cannot be simulated.

    Attributes:
        key: what it is about, in the words of a scenario file, such as ``material.poisson_ratio``
            or ``load[0].region``.
        value: the offending value as text, if there is one.
        remedy: what to do about it.
    """

    def __init__(self, message: str, *, key: str, value: str | None = None, remedy: str) -> None:
        super().__init__(f"{message}\n  help: {remedy}" if remedy else message)
        self.key = key
        self.value = value
        self.remedy = remedy

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args, self.__dict__)


class MissingFieldError(InputError, AttributeError):
    """A field that a snapshot or a results file does not hold."""


class SimulationError(Error, RuntimeError):
    """A simulation that failed; it stands at its last good state.

    Attributes:
        time: simulated time of the failure (s).
        step: number of the step that failed.
        place: reference position (m) where it shows most, if there is one.
        remedy: what to change.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float,
        step: int,
        place: tuple[float, float, float] | None,
        remedy: str,
    ) -> None:
        super().__init__(f"{message}\n  help: {remedy}")
        self.time = time
        self.step = step
        self.place = place
        self.remedy = remedy

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args, self.__dict__)


class StorageError(Error, OSError):
    """Results that could not be stored: no space, no permission.

    Attributes:
        path: the file or folder.
    """

    def __init__(self, message: str, *, path: str) -> None:
        super().__init__(message)
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args, self.__dict__)


class RsphWarning(UserWarning):
    """Something the user should know, such as a mesh that was turned round."""


def _again(kind: type[Error], arguments: tuple[Any, ...], details: dict[str, Any]) -> Error:
    """An error as it was before it was pickled."""
    error = kind.__new__(kind, *arguments)
    error.args = arguments
    error.__dict__.update(details)
    return error
