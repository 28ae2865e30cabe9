"""The problem that every program gets: n^3 particles, 122 neighbours inside (h = 1.25 dx)."""

import sys
import time

import numpy as np

EDGE = int(sys.argv[1]) if len(sys.argv) > 1 else 37
DX = 1.0 / EDGE
REACH = 3.125 * DX * (1 - 1e-9)
VOLUME = DX**3
LAMBDA, SHEAR = 57.69, 38.46  # Pa
SECONDS = 2.0


def positions():
    """The particles, n^3 rows of x, y, z."""
    axis = (np.arange(EDGE) + 0.5) * DX
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()])


def velocities(x):
    """Some smooth field."""
    return np.sin(3 * x[:, [1, 2, 0]])


def neighbours():
    """Compressed rows: starts, neighbours, and -W'(r)/r of each pair (M5 spline)."""
    cells = np.arange(-3, 4)
    k, j, i = (c.ravel() for c in np.meshgrid(cells, cells, cells, indexing="ij"))
    r = np.sqrt(i**2 + j**2 + k**2) * DX
    near = (r > 0) & (r < REACH)
    i, j, k, r = i[near], j[near], k[near], r[near]
    a = np.arange(EDGE**3)
    x, y, z = a % EDGE, a // EDGE % EDGE, a // EDGE**2
    bx, by, bz = x[:, None] + i, y[:, None] + j, z[:, None] + k
    there = np.logical_and.reduce([(c >= 0) & (c < EDGE) for c in (bx, by, bz)])
    starts = np.concatenate([[0], np.cumsum(there.sum(1))]).astype(np.int32)
    b = ((bz * EDGE + by) * EDGE + bx)[there].astype(np.int32)
    h = 1.25 * DX
    s = r / h
    slope = sum(-4 * c * np.maximum(q - s, 0) ** 3 for c, q in [(1, 2.5), (-5, 1.5), (10, 0.5)]) / (
        20 * np.pi * h**4
    )
    weight = np.broadcast_to(-slope / r, there.shape)[there]
    return starts, b, weight


def report(version, update):
    """Prints the best rate of `update` as JSON, after a first call that compiles."""
    update()
    best, begin, runs = float("inf"), time.perf_counter(), 0
    while runs < 5 or time.perf_counter() - begin < SECONDS:
        start = time.perf_counter()
        update()
        best = min(best, time.perf_counter() - start)
        runs += 1
    print(f'{{"version": "{version}", "rate": {EDGE**3 / best:.4e}}}')
