"""Finite-element reference: Cook's membrane in plane strain, neo-Hookean, E = 240.565.

    pip install numpy scipy scikit-fem
    python cook_reference.py

Corners (0, 0), (48, 44), (48, 60), (0, 44); held at x = 0, a dead shear traction of 100/16 upward
on x = 48. Biquadratic displacement and, so that nearly incompressible tissue does not lock, a
discontinuous pressure p = lambda ln J: P = mu (F - F^-T) + p F^-T, ln J - p / lambda = 0. Newton's
method in load steps.
Writes cook.csv: displacement (x, y) of the corner (48, 60) on three meshes.
"""

from pathlib import Path

import numpy as np
from scipy.sparse import bmat
from skfem import (
    Basis,
    BilinearForm,
    ElementDG,
    ElementQuad1,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshQuad,
    condense,
    solve,
)
from skfem.helpers import ddot, det, grad, inv, mul, transpose

E = 240.565
HERE = Path(__file__).parent


def kinematics(w):
    f = w["u"].grad + np.eye(2)[:, :, None, None]
    return f, inv(f), det(f)


@LinearForm
def force(v, w):
    f, i, _ = kinematics(w)
    return ddot(w.mu * (f - transpose(i)) + w["p"] * transpose(i), grad(v))


@LinearForm
def constraint(q, w):
    _, _, j = kinematics(w)
    return (np.log(j) - w["p"] / w.lam) * q


@BilinearForm
def stiffness(du, v, w):
    _, i, _ = kinematics(w)
    it, df = transpose(i), grad(du)
    t = mul(it, mul(transpose(df), it))
    return ddot(w.mu * (df + t) - w["p"] * t, grad(v))


@BilinearForm
def coupling(du, q, w):
    _, i, _ = kinematics(w)
    return ddot(transpose(i), grad(du)) * q


@BilinearForm
def compressibility(p, q, w):
    return -p * q / w.lam


def tip(n, nu, steps=8):
    """Displacement of the corner (48, 60) on n x n elements."""
    lam, mu = nu * E / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    mesh = MeshQuad.init_tensor(np.linspace(0, 1, n + 1) ** 1.3, np.linspace(0, 1, n + 1))
    s, t = mesh.p
    mesh = MeshQuad(np.array([48 * s, 44 * s + t * (44 - 28 * s)]), mesh.t)
    u_basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=5)
    p_basis = u_basis.with_element(ElementDG(ElementQuad1()))
    right = mesh.facets_satisfying(lambda x: np.isclose(x[0], 48))
    edge = FacetBasis(mesh, u_basis.elem, facets=right, intorder=5)
    load = LinearForm(lambda v, w: 100 / 16 * v.value[1]).assemble(edge)
    held = u_basis.get_dofs(lambda x: np.isclose(x[0], 0)).all()
    u, p = u_basis.zeros(), p_basis.zeros()
    for share in np.linspace(0, 1, steps + 1)[1:]:
        for _ in range(30):
            at = {"u": u_basis.interpolate(u), "p": p_basis.interpolate(p), "mu": mu, "lam": lam}
            r = np.concatenate(
                [share * load - force.assemble(u_basis, **at), -constraint.assemble(p_basis, **at)]
            )
            free = np.ones(len(r), bool)
            free[held] = False
            if np.linalg.norm(r[free]) < 1e-9 * np.linalg.norm(load):
                break
            b = coupling.assemble(u_basis, p_basis, **at)
            k = bmat(
                [
                    [stiffness.assemble(u_basis, **at), b.T],
                    [b, compressibility.assemble(p_basis, **at)],
                ],
                "csr",
            )
            du = solve(*condense(k, r, D=held))
            u, p = u + du[: len(u)], p + du[len(u) :]
        else:
            raise RuntimeError("Newton did not converge")
    node = np.argmin(np.abs(mesh.p[0] - 48) + np.abs(mesh.p[1] - 60))
    return u[u_basis.nodal_dofs[:, node]]


def main():
    with open(HERE / "cook.csv", "w") as f:
        f.write("poisson_ratio,elements,u_x,u_y\n")
        for nu in (0.3, 0.49, 0.4999):
            for n in (16, 32, 48):
                x, y = tip(n, nu)
                print(nu, n, x, y, flush=True)
                f.write(f"{nu},{n},{x:.5f},{y:.5f}\n")


if __name__ == "__main__":
    main()
