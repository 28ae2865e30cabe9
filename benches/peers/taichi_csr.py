"""Velocity gradient, stress and its divergence in Taichi: compressed rows, double precision.

The weight of a pair is read from memory, or with the word `evaluate` computed from the kernel.
"""

import math
import os
import sys

import lattice
import numpy as np
import taichi as ti

threads = int(os.environ.get("THREADS", "2"))
EVALUATE = "evaluate" in sys.argv
ti.init(arch=ti.cpu, default_fp=ti.f64, cpu_max_num_threads=threads, log_level=ti.ERROR)
N = lattice.EDGE**3
H = 1.25 * lattice.DX
starts_of, pairs_of, weight_of = lattice.neighbours()
starts = ti.field(ti.i32, N + 1)
pairs = ti.field(ti.i32, len(pairs_of))
weight = ti.field(ti.f64, len(pairs_of))
x, v, force = (ti.Vector.field(3, ti.f64, N) for _ in range(3))
stress = ti.Matrix.field(3, 3, ti.f64, N)
starts.from_numpy(starts_of)
pairs.from_numpy(pairs_of)
weight.from_numpy(np.ascontiguousarray(weight_of))
x.from_numpy(lattice.positions())
v.from_numpy(lattice.velocities(lattice.positions()))


@ti.func
def positive(x):
    return ti.max(x, 0.0) ** 3


@ti.func
def weight_of_pair(q, x):
    """-W'(r)/r of the M5 spline."""
    w = 0.0
    if ti.static(EVALUATE):
        r = x.norm()
        s = r / H
        slope = positive(2.5 - s) - 5 * positive(1.5 - s) + 10 * positive(0.5 - s)
        w = slope * (4 / (20 * math.pi * H**4)) / r
    else:
        w = weight[q]
    return w


@ti.kernel
def gradient():
    for a in x:
        g = ti.Matrix.zero(ti.f64, 3, 3)
        x_a, v_a = x[a], v[a]
        for q in range(starts[a], starts[a + 1]):
            b = pairs[q]
            apart = x[b] - x_a
            g += (v[b] - v_a).outer_product(apart * (lattice.VOLUME * weight_of_pair(q, apart)))
        e = 0.5 * (g + g.transpose())
        pressure = lattice.LAMBDA * e.trace()
        stress[a] = pressure * ti.Matrix.identity(ti.f64, 3) + 2 * lattice.SHEAR * e


@ti.kernel
def divergence():
    for a in x:
        f = ti.Vector.zero(ti.f64, 3)
        x_a, stress_a = x[a], stress[a]
        for q in range(starts[a], starts[a + 1]):
            b = pairs[q]
            apart = x[b] - x_a
            f += (stress[b] + stress_a) @ (apart * (lattice.VOLUME * weight_of_pair(q, apart)))
        force[a] = f


def update():
    gradient()
    divergence()
    ti.sync()


lattice.report(".".join(map(str, ti.__version__)), update)
