"""Finite-element references of the large-strain validation: a neo-Hookean block, E = 10, nu = 0.3.

    pip install numpy scipy scikit-fem
    python fem_reference.py

Energy density mu/2 (F:F - d) - mu ln J + lambda/2 (ln J)^2; quadratic quadrilaterals (plane strain) and quadratic
hexahedra, graded towards the clamp, Newton to 1e-9. Writes block_tension.csv, block_shear.csv (displacement at the sample
points) and cube.csv (extension of the cube on several meshes); prints how far two meshes differ.
"""

from pathlib import Path

import numpy as np
from skfem import (
    Basis, BilinearForm, ElementHex2, ElementQuad2, ElementVector, FacetBasis, Functional, LinearForm, MeshHex, MeshQuad,
    condense, solve,
)
from skfem.helpers import ddot, det, grad, inv, mul, transpose

E, NU = 10.0, 0.3
LAMBDA, MU = NU * E / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
HERE = Path(__file__).parent


def kinematics(w):
    f = w["u"].grad + np.eye(w["u"].grad.shape[0])[:, :, None, None]
    return f, inv(f), det(f)


@LinearForm
def internal(v, w):
    f, i, j = kinematics(w)
    return ddot(MU * (f - transpose(i)) + LAMBDA * np.log(j) * transpose(i), grad(v))


@BilinearForm
def stiffness(du, v, w):
    f, i, j = kinematics(w)
    df, it = grad(du), transpose(i)
    t = mul(it, mul(transpose(df), it))
    return ddot(MU * (df + t) + LAMBDA * (ddot(it, df) * it - np.log(j) * t), grad(v))


@Functional
def energy(w):
    f, _, j = kinematics(w)
    return MU / 2 * (ddot(f, f) - f.shape[0]) - MU * np.log(j) + LAMBDA / 2 * np.log(j) ** 2


def newton(basis, u, load, held):
    """Equilibrium from the start `u` with the degrees of freedom `held` kept."""
    free = basis.complement_dofs(held)
    for _ in range(40):
        field = basis.interpolate(u)
        residual = load - internal.assemble(basis, u=field)
        if np.linalg.norm(residual[free]) < 1e-9:
            return u
        du = solve(*condense(stiffness.assemble(basis, u=field), residual, D=held))
        step = 1.0
        while np.any(det(basis.interpolate(u + step * du).grad + np.eye(basis.mesh.dim())[:, :, None, None]) <= 0):
            step /= 2
        u = u + step * du
    raise RuntimeError("Newton did not converge")


def block(n, loads=(), moves=()):
    """The unit square held at y = 0: dead traction on top, or top moved rigidly. Yields (value, basis, u, top mean)."""
    t = np.linspace(0, 1, n + 1)
    x = 0.7 * 0.5 * (1 - np.cos(np.pi * t)) + 0.3 * t
    mesh = MeshQuad.init_tensor(x, x)
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=5)
    top = mesh.facets_satisfying(lambda p: np.isclose(p[1], 1))
    edge = FacetBasis(mesh, ElementVector(ElementQuad2()), facets=top, intorder=5)
    pull = LinearForm(lambda v, w: v.value[1]).assemble(edge)
    held = basis.get_dofs(lambda p: np.isclose(p[1], 0)).all()
    u = basis.zeros()
    for load in loads:
        u = newton(basis, u, load * pull, held)
        yield load, basis, u, pull @ u
    moved = basis.get_dofs(lambda p: np.isclose(p[1], 1)).all()
    before = np.zeros(2)
    for move in moves:
        for c, name in enumerate(("u^1", "u^2")):
            dofs = basis.get_dofs(elements=True).all(name)
            u[dofs] += (np.array(move)[c] - before[c]) * basis.doflocs[1, dofs]
        before = np.array(move)
        u = newton(basis, u, 0 * pull, np.union1d(held, moved))
        yield move, basis, u, pull @ u


def sample(basis, u, points):
    return (basis.probes(points.T.copy()) @ u).reshape(2, -1).T


def cube(nx, nz, loads):
    """A quarter of the unit cube held at z = 0 under dead traction on top: its mean extension."""
    x = 0.5 - (0.5 * np.linspace(0, 1, nx + 1) ** 1.5)[::-1]
    mesh = MeshHex.init_tensor(x, x, np.linspace(0, 1, nz + 1) ** 1.5)
    basis = Basis(mesh, ElementVector(ElementHex2()), intorder=4)
    top = mesh.facets_satisfying(lambda p: np.isclose(p[2], 1))
    edge = FacetBasis(mesh, ElementVector(ElementHex2()), facets=top, intorder=4)
    pull = LinearForm(lambda v, w: v.value[2]).assemble(edge)
    held = np.unique(np.concatenate([
        basis.get_dofs(lambda p: np.isclose(p[2], 0)).all(),
        basis.get_dofs(lambda p: np.isclose(p[0], 0)).all("u^1"),
        basis.get_dofs(lambda p: np.isclose(p[1], 0)).all("u^2"),
    ]))
    u = basis.zeros()
    for load in loads:
        u = newton(basis, u, load * pull, held)
    return pull @ u / 0.25


def main():
    gx, gy = np.linspace(0.05, 0.95, 10), np.linspace(0.02, 0.98, 9)
    points = np.stack(np.meshgrid(gx, gy, indexing="ij"), -1).reshape(-1, 2)
    cases = {
        "block_tension": dict(loads=np.linspace(0.5, 3.5, 7)),
        "block_shear": dict(moves=[(0.1 * k, 0.0) for k in range(1, 11)]),
    }
    for name, case in cases.items():
        found = {}
        for n in (24, 36):
            for value, basis, u, mean in block(n, **case):
                print(f"{name} n={n} value {value} mean displacement of the top along y {mean:.6f}", flush=True)
                found[n] = sample(basis, u, points), mean
        (coarse, _), (fine, mean) = found[24], found[36]
        difference = np.sqrt(((coarse - fine) ** 2).sum() / (fine**2).sum())
        print(f"{name}: L2 difference of the two meshes {difference:.2e}")
        rows = np.hstack([points, fine])
        np.savetxt(HERE / f"{name}.csv", rows, "%.8f", ",", header="x,y,u_x,u_y", comments="")
    with open(HERE / "cube.csv", "w") as f:
        f.write("elements_half_width,elements_height,load,extension\n")
        for nx, nz in ((3, 6), (5, 9), (7, 12)):
            extension = cube(nx, nz, (1.0, 2.0, 3.0))
            print(f"cube {nx} {nz}: {extension:.6f}", flush=True)
            f.write(f"{nx},{nz},3,{extension:.6f}\n")


if __name__ == "__main__":
    main()
