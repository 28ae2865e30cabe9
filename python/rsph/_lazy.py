"""Results as an xarray Dataset whose values are read when they are used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rsph.errors import Error

if TYPE_CHECKING:
    from rsph.results import Results

_COMPONENTS = {
    3: ("component", ["x", "y", "z"]),
    6: ("tensor", ["xx", "yy", "zz", "xy", "yz", "xz"]),
    9: ("matrix", ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"]),
}
_PRINCIPAL = ("principal", ["1", "2", "3"])
_OF_PRINCIPAL = ("principal_strain", "principal_stretch", "principal_stress")


def dataset(results: Results) -> Any:
    """The fields of ``results``."""
    try:
        import xarray as xr
        from xarray.backends import BackendArray
        from xarray.core import indexing
    except ImportError as e:
        raise Error("this needs xarray; install it with `pip install rsph[xarray]`") from e
    points = results._steady()

    class Field(BackendArray):  # type: ignore[misc,unused-ignore]
        """A field at all times: each frame is read on its own."""

        def __init__(self, name: str, components: int) -> None:
            self.name = name
            self.shape = (len(results), points) + ((components,) if components > 1 else ())
            self.dtype = np.dtype(np.float64)

        def __getitem__(self, key: Any) -> Any:
            basic = indexing.IndexingSupport.BASIC
            return indexing.explicit_indexing_adapter(key, self.shape, basic, self._read)

        def _read(self, key: tuple[Any, ...]) -> Any:
            frames, rest = key[0], key[1:]
            if isinstance(frames, int | np.integer):
                return results.field(self.name, int(frames))[rest]
            chosen = range(*frames.indices(len(results)))
            if not chosen:
                chosen_rest = (slice(None), *rest)
                return np.empty((0, *self.shape[1:]))[chosen_rest]
            return np.stack([results.field(self.name, k)[rest] for k in chosen])

    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": results.times}
    for name, components in results.fields.items():
        dimensions: tuple[str, ...] = ("time", "point")
        if components > 1:
            default = (f"{name}_component", range(components))
            extra, labels = _COMPONENTS.get(components, default)
            if name in _OF_PRINCIPAL:
                extra, labels = _PRINCIPAL
            dimensions += (extra,)
            coordinates[extra] = list(labels)
        lazy = indexing.LazilyIndexedArray(Field(name, components))
        variables[name] = xr.Variable(dimensions, lazy)
    return xr.Dataset(variables, coords=coordinates)
