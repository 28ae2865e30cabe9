"""Finite-element reference: a column that twists and one that bends from an initial velocity.

    pip install numpy scipy scikit-fem
    python column_reference.py

The column [-.5, .5]^2 x [0, 6], rho = 1100, E = 17 MPa, nu = .45, neo-Hookean, is held at z = 0.
It starts with v = 105 sin(pi z / 12) (y, -x, 0), or with v = (10 z / 6, 0, 0), the velocities of
the columns of C. H. Lee, A. J. Gil and J. Bonet, Comput. Struct. 118 (2013), and what followed it.
Triquadratic elements, masses lumped at their nodes (Simpson), central differences in time.
Writes column_twist.csv and column_bend.csv: time and displacement of the point (.25, 0, 6) of the
twisted column's top and of the middle (0, 0, 6) of the bent one's, on the finest of three meshes,
and prints how far the meshes are apart.
"""

from itertools import product
from pathlib import Path

import numpy as np
from skfem import Basis, ElementHex2, ElementVector, LinearForm, MeshHex
from skfem.helpers import ddot, det, grad, inv, transpose

YOUNG, NU, DENSITY = 17e6, 0.45, 1100.0
LAM, MU = NU * YOUNG / ((1 + NU) * (1 - 2 * NU)), YOUNG / (2 * (1 + NU))
HEIGHT, COURANT = 6, 0.2
HERE = Path(__file__).parent


@LinearForm
def force(v, w):
    f = w["u"].grad + np.eye(3)[:, :, None, None]
    it, j = transpose(inv(f)), det(f)
    return -ddot(MU * (f - it) + LAM * np.log(j) * it, grad(v))


def twist(x):
    rate = 105 * np.sin(np.pi * x[2] / (2 * HEIGHT))
    return np.array([rate * x[1], -rate * x[0], 0 * rate])


def bend(x):
    return np.array([10 * x[2] / HEIGHT, 0 * x[0], 0 * x[0]])


def motion(n, velocity, place, every, count):
    """Displacement at a place at count + 1 times, on n x n x 6 n elements."""
    across, along = np.linspace(-0.5, 0.5, n + 1), np.linspace(0, HEIGHT, HEIGHT * n + 1)
    mesh, element = MeshHex.init_tensor(across, across, along), ElementVector(ElementHex2())
    basis = Basis(mesh, element, intorder=5)
    simpson = list(product(((0.0, 1 / 6), (0.5, 4 / 6), (1.0, 1 / 6)), repeat=3))
    nodes = np.array([[x for x, _ in point] for point in simpson]).T
    weights = np.array([np.prod([w for _, w in point]) for point in simpson])
    at_nodes = Basis(mesh, element, quadrature=(nodes, weights))
    mass = LinearForm(lambda v, w: DENSITY * (v[0] + v[1] + v[2])).assemble(at_nodes)
    held = basis.get_dofs(lambda x: np.isclose(x[2], 0)).all()
    # Degrees of freedom go x, y, z at each node.
    x = basis.doflocs[:, ::3]
    node = np.argmin(np.linalg.norm(x - np.array(place)[:, None], axis=0))
    u, v = basis.zeros(), velocity(x).T.ravel()
    v[held] = 0
    speed = np.sqrt((LAM + 2 * MU) / DENSITY)
    steps = int(np.ceil(every / (COURANT / n / speed)))
    dt = every / steps

    def acceleration():
        a = force.assemble(basis, u=basis.interpolate(u)) / mass
        a[held] = 0
        return a

    found = [u[3 * node : 3 * node + 3].copy()]
    a = acceleration()
    for _ in range(count):
        for _ in range(steps):
            v += 0.5 * dt * a
            u += dt * v
            a = acceleration()
            v += 0.5 * dt * a
        found.append(u[3 * node : 3 * node + 3].copy())
    return np.array(found)


def main():
    cases = (
        ("bend", bend, (0, 0, 6), 0.01, 25, (2, 3, 4)),
        ("twist", twist, (0.25, 0, 6), 0.005, 20, (2, 4, 6)),
    )
    for name, velocity, place, every, count, meshes in cases:
        before = np.zeros((count + 1, 3))
        for n in meshes:
            path = motion(n, velocity, place, every, count)
            apart = np.linalg.norm(path - before) / np.linalg.norm(path)
            print(f"{name}: {n} elements across, {apart:.1e} from the mesh before", flush=True)
            before = path
            rows = np.column_stack([every * np.arange(count + 1), path])
            file = HERE / f"column_{name}.csv"
            np.savetxt(file, rows, "%.6g", ",", header="t,u_x,u_y,u_z", comments="")


if __name__ == "__main__":
    main()
