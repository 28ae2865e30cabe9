# ruff: noqa: N803, RUF100 (names and words of PySPH)
"""Velocity gradient, stress and its divergence in PySPH: OpenMP, cached neighbours."""

import lattice
import numpy as np
import pysph
from compyle.config import get_config
from pysph.base.kernels import CubicSpline
from pysph.base.nnps import LinkedListNNPS
from pysph.base.utils import get_particle_array
from pysph.sph.acceleration_eval import AccelerationEval
from pysph.sph.equation import Equation, Group
from pysph.sph.sph_compiler import SPHCompiler

get_config().use_openmp = True


class VelocityGradient(Equation):
    """sum V_b (v_b - v_a) (x) grad W, then the stress of a linear solid."""

    def __init__(self, dest, sources, lame, shear):
        self.lame = lame
        self.shear = shear
        super().__init__(dest, sources)

    def initialize(self, d_idx, d_g):
        i = declare("int")  # noqa: F821 (a word of PySPH's compiler)
        for i in range(9):
            d_g[9 * d_idx + i] = 0.0

    def loop(self, d_idx, s_idx, d_g, s_V, VIJ, DWIJ):
        i, j = declare("int", 2)  # noqa: F821
        for i in range(3):
            for j in range(3):
                d_g[9 * d_idx + 3 * i + j] -= s_V[s_idx] * VIJ[i] * DWIJ[j]

    def post_loop(self, d_idx, d_g, d_s):
        i, j = declare("int", 2)  # noqa: F821
        trace = declare("double")  # noqa: F821
        trace = d_g[9 * d_idx] + d_g[9 * d_idx + 4] + d_g[9 * d_idx + 8]
        for i in range(3):
            for j in range(3):
                d_s[9 * d_idx + 3 * i + j] = self.shear * (
                    d_g[9 * d_idx + 3 * i + j] + d_g[9 * d_idx + 3 * j + i]
                )
            d_s[9 * d_idx + 4 * i] += self.lame * trace


class StressDivergence(Equation):
    """sum V_b (sigma_a + sigma_b) grad W."""

    def initialize(self, d_idx, d_f):
        i = declare("int")  # noqa: F821
        for i in range(3):
            d_f[3 * d_idx + i] = 0.0

    def loop(self, d_idx, s_idx, d_f, d_s, s_s, s_V, DWIJ):
        i, j = declare("int", 2)  # noqa: F821
        for i in range(3):
            for j in range(3):
                d_f[3 * d_idx + i] += (
                    s_V[s_idx] * (d_s[9 * d_idx + 3 * i + j] + s_s[9 * s_idx + 3 * i + j]) * DWIJ[j]
                )


x = lattice.positions()
v = lattice.velocities(x)
# The cubic spline reaches two smoothing lengths.
solid = get_particle_array(
    name="solid",
    x=x[:, 0],
    y=x[:, 1],
    z=x[:, 2],
    u=v[:, 0],
    v=v[:, 1],
    w=v[:, 2],
    h=0.5 * lattice.REACH,
    V=np.full(len(x), lattice.VOLUME),
)
for name, stride in [("g", 9), ("s", 9), ("f", 3)]:
    solid.add_property(name, stride=stride)
groups = [
    Group([VelocityGradient("solid", ["solid"], lattice.LAMBDA, lattice.SHEAR)]),
    Group([StressDivergence("solid", ["solid"])]),
]
kernel = CubicSpline(dim=3)
evaluation = AccelerationEval([solid], groups, kernel)
SPHCompiler(evaluation, None).compile()
nnps = LinkedListNNPS(dim=3, particles=[solid], radius_scale=kernel.radius_scale, cache=True)
nnps.update()
evaluation.set_nnps(nnps)
lattice.report(pysph.__version__, lambda: evaluation.compute(0.0, 1e-3))
