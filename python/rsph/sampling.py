"""Particles of a body, without a simulation: from surfaces and from masks of images."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from rsph import _rsph
from rsph.errors import InputError
from rsph.shapes import LabelMap, Mask, Mesh, Shape

__all__ = ["Particles"]

Array: TypeAlias = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Particles:
    """The particles that fill a shape, on a regular lattice.

    ``Simulation(shape=particles, ...)`` is the body of that shape at that spacing. Its own lattice
    may be shifted a little, to meet the planes of clamps.

    >>> import rsph
    >>> particles = rsph.Particles.of(rsph.shapes.Sphere(radius=1.0), spacing=0.25)
    >>> particles.positions.shape == (len(particles), 3)
    True
    >>> bool(abs(particles.volume.sum() / particles.shape.volume - 1.0) < 0.01)
    True

    Attributes:
        positions: centres of the cells (m), shape (N, 3).
        volume: volume of the body in each cell (m^3), shape (N,).
        level_set: signed distance to the surface (m), negative inside, shape (N,).
        spacing: distance between particles (m).
        shape: what they fill.
    """

    positions: Array
    volume: Array
    level_set: Array
    spacing: float
    shape: Shape

    @classmethod
    def of(
        cls, shape: Shape, *, spacing: float | None = None, particles: int | None = None
    ) -> Particles:
        """Fills a shape.

        Args:
            shape: any of :mod:`rsph.shapes`.
            spacing: distance between particles (m); either this or ``particles``.
            particles: number of particles (about).
        """
        if (spacing is None) == (particles is None):
            raise InputError(
                "`body.spacing`: needs either `spacing` or `particles`",
                key="body.spacing",
                remedy="for example particles=1000",
            )
        found = _rsph.sample(shape._shape, spacing, particles)
        return cls(shape=shape, **found)

    @classmethod
    def from_mesh(
        cls,
        vertices: npt.ArrayLike,
        triangles: npt.ArrayLike,
        *,
        spacing: float | None = None,
        particles: int | None = None,
        scale: float = 1.0,
    ) -> Particles:
        """Fills a triangle mesh; one that is not closed as :class:`rsph.shapes.Mesh` does.

        Args:
            vertices: positions, shape (V, 3).
            triangles: vertex indices, outward, shape (T, 3).
            spacing: distance between particles (m); either this or ``particles``.
            particles: number of particles (about).
            scale: factor from the units of the vertices to metres.
        """
        mesh = Mesh(vertices=vertices, triangles=triangles, scale=scale)
        return cls.of(mesh, spacing=spacing, particles=particles)

    @classmethod
    def from_mask(
        cls,
        mask: npt.ArrayLike,
        voxel: npt.ArrayLike | None = None,
        *,
        affine: npt.ArrayLike | None = None,
        label: int | None = None,
        spacing: float | None = None,
        particles: int | None = None,
    ) -> Particles:
        """Fills the body that voxels of an image show; see :class:`rsph.shapes.Mask`.

        Args:
            mask: the voxels, shape (NX, NY, NZ).
            voxel: size of a voxel (m), shape (3,) or one number.
            affine: instead of ``voxel``: from indices of voxels to positions (m), shape (4, 4).
            label: the number that means inside; by default everything but 0 and False.
            spacing: distance between particles (m); either this or ``particles``.
            particles: number of particles (about).
        """
        shape = Mask(mask, voxel, affine=affine, label=label)
        return cls.of(shape, spacing=spacing, particles=particles)

    @classmethod
    def from_labelmap(
        cls,
        path: str | os.PathLike[str],
        *,
        label: int = 1,
        spacing: float | None = None,
        particles: int | None = None,
    ) -> Particles:
        """Fills the body of a label in a segmentation; see :class:`rsph.shapes.LabelMap`.

        Args:
            path: a NIfTI or NRRD file.
            label: number of the organ.
            spacing: distance between particles (m); either this or ``particles``.
            particles: number of particles (about).
        """
        return cls.of(LabelMap(path, label=label), spacing=spacing, particles=particles)

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"<Particles: {len(self)} of {self.shape.name}, spacing {self.spacing:.4g}>"
