"""Mixed finite elements for the clamped neo-Hookean cube up to nu = 0.499, E = 10, dead load 3.

    pip install numpy scipy scikit-fem
    python mixed_reference.py

mu/2 (F:F - 3) - mu ln J + p ln J - p^2/(2 lambda): stationary in u and the pressure p, which is
lambda ln J. Quadratic hexahedra for u, continuous trilinear ones for p (Taylor and Hood), a
quarter of the cube, graded towards clamp and edges, Newton on loads 1, 2, 3. Writes
cube_mixed.csv: the mean extension of the top. At nu = 0.3 it must agree with cube.csv.
"""

import sys
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from skfem import (
    Basis,
    BilinearForm,
    ElementHex1,
    ElementHex2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshHex,
)
from skfem.helpers import ddot, det, grad, inv, mul, transpose

E = 10.0
HERE = Path(__file__).parent


def kinematics(w):
    f = w["u"].grad + np.eye(3)[:, :, None, None]
    return f, transpose(inv(f)), det(f)


def cube(nx, nz, nu, loads):
    lam, mu = nu * E / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    x = 0.5 - (0.5 * np.linspace(0, 1, nx + 1) ** 1.5)[::-1]
    mesh = MeshHex.init_tensor(x, x, np.linspace(0, 1, nz + 1) ** 1.5)
    basis = Basis(mesh, ElementVector(ElementHex2()), intorder=4)
    pressure = basis.with_element(ElementHex1())

    @LinearForm
    def internal(v, w):
        f, it, _ = kinematics(w)
        return ddot(mu * (f - it) + w["p"] * it, grad(v))

    @LinearForm
    def constraint(q, w):
        _, _, j = kinematics(w)
        return (np.log(j) - w["p"] / lam) * q

    @BilinearForm
    def uu(du, v, w):
        _, it, _ = kinematics(w)
        df = grad(du)
        turned = mul(it, mul(transpose(df), it))
        return ddot(mu * (df + turned) - w["p"] * turned, grad(v))

    @BilinearForm
    def up(dp, v, w):
        _, it, _ = kinematics(w)
        return dp * ddot(it, grad(v))

    @BilinearForm
    def pp(dp, q, w):
        return -dp * q / lam

    top = mesh.facets_satisfying(lambda p: np.isclose(p[2], 1))
    edge = FacetBasis(mesh, ElementVector(ElementHex2()), facets=top, intorder=4)
    pull = LinearForm(lambda v, w: v.value[2]).assemble(edge)
    held = np.unique(
        np.concatenate(
            [
                basis.get_dofs(lambda p: np.isclose(p[2], 0)).all(),
                basis.get_dofs(lambda p: np.isclose(p[0], 0)).all("u^1"),
                basis.get_dofs(lambda p: np.isclose(p[1], 0)).all("u^2"),
            ]
        )
    )
    n, m = basis.N, pressure.N
    free = np.setdiff1d(np.arange(n + m), held)
    u, p = basis.zeros(), pressure.zeros()
    b = pp.assemble(pressure)
    for load in loads:
        for _ in range(30):
            fields = {"u": basis.interpolate(u), "p": pressure.interpolate(p)}
            residual = np.concatenate(
                [
                    load * pull - internal.assemble(basis, **fields),
                    -constraint.assemble(pressure, **fields),
                ]
            )
            if np.linalg.norm(residual[free]) < 1e-9:
                break
            a = uu.assemble(basis, **fields)
            c = up.assemble(pressure, basis, **fields)
            matrix = sp.bmat([[a, c], [c.T, b]], format="csc")[free][:, free]
            step = np.zeros(n + m)
            step[free] = splu(matrix).solve(residual[free])
            u, p = u + step[:n], p + step[n:]
        else:
            raise RuntimeError("Newton did not converge")
    return pull @ u / 0.25


def main(sizes):
    rows = ["elements_half_width,elements_height,poisson_ratio,load,extension"]
    for nu in (0.3, 0.45, 0.49, 0.499):
        for nx, nz in sizes:
            extension = cube(nx, nz, nu, (1.0, 2.0, 3.0))
            print(f"nu {nu} {nx} x {nx} x {nz}: {extension:.6f}", flush=True)
            rows.append(f"{nx},{nz},{nu},3,{extension:.6f}")
    (HERE / "cube_mixed.csv").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main(((2, 4), (3, 6)) if "--quick" in sys.argv else ((2, 4), (3, 6), (4, 8)))
