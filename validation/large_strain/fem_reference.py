"""Finite-element references of the large-strain validation: a neo-Hookean block, E = 10, nu = 0.3.

    pip install numpy scipy scikit-fem
    python fem_reference.py

Energy density mu/2 (F:F - d) - mu ln J + lambda/2 (ln J)^2; quadratic quadrilaterals (plane
strain) and quadratic
hexahedra, graded towards the clamp, Newton to 1e-9. Writes block_tension.csv, block_shear.csv
(displacement at the sample
points) and cube.csv (extension of the cube on several meshes); prints how far two meshes differ.
"""

from pathlib import Path

import numpy as np
from skfem import (
    Basis,
    BilinearForm,
    ElementHex2,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    Functional,
    LinearForm,
    MeshHex,
    MeshQuad,
    condense,
    solve,
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
    _, i, j = kinematics(w)
    df, it = grad(du), transpose(i)
    t = mul(it, mul(transpose(df), it))
    return ddot(MU * (df + t) + LAMBDA * (ddot(it, df) * it - np.log(j) * t), grad(v))


@Functional
def energy(w):
    f, _, j = kinematics(w)
    return MU / 2 * (ddot(f, f) - f.shape[0]) - MU * np.log(j) + LAMBDA / 2 * np.log(j) ** 2


def potential(basis, u, load):
    field = basis.interpolate(u)
    if np.any(det(field.grad + np.eye(basis.mesh.dim())[:, :, None, None]) <= 0):
        return np.inf
    return energy.assemble(basis, u=field) - load @ u


def newton(basis, u, load, held):
    """Equilibrium from the start `u` with the degrees of freedom `held` kept."""
    free = basis.complement_dofs(held)
    undeformed = stiffness.assemble(basis, u=basis.interpolate(basis.zeros()))
    for _ in range(100):
        field = basis.interpolate(u)
        residual = load - internal.assemble(basis, u=field)
        if np.linalg.norm(residual[free]) < 1e-9:
            return u
        tangent, shift = stiffness.assemble(basis, u=field), 0.0
        du = solve(*condense(tangent, residual, D=held))
        # At the corners of the clamps the body may fold: there the tangent is not positive.
        while residual[free] @ du[free] <= 0:
            shift = max(10 * shift, 1e-3)
            du = solve(*condense(tangent + shift * undeformed, residual, D=held))
        # Down the potential: the whole step may wander.
        before, slope, step = potential(basis, u, load), residual[free] @ du[free], 1.0
        while not potential(
            basis, u + step * du, load
        ) <= before - 1e-4 * step * slope + 1e-13 * abs(before):
            step /= 2
        u = u + step * du
    raise RuntimeError("Newton did not converge")


def square(n):
    """Quadratic elements on the unit square, finer towards its edges."""
    t = np.linspace(0, 1, n + 1)
    x = 0.7 * 0.5 * (1 - np.cos(np.pi * t)) + 0.3 * t
    return Basis(MeshQuad.init_tensor(x, x), ElementVector(ElementQuad2()), intorder=5)


def tension(n, loads):
    """The unit square held at y = 0 under dead traction on top."""
    basis = square(n)
    top = basis.mesh.facets_satisfying(lambda p: np.isclose(p[1], 1))
    edge = FacetBasis(basis.mesh, basis.elem, facets=top, intorder=5)
    pull = LinearForm(lambda v, w: v.value[1]).assemble(edge)
    held = basis.get_dofs(lambda p: np.isclose(p[1], 0)).all()
    u = basis.zeros()
    for load in loads:
        u = newton(basis, u, load * pull, held)
        print(f"tension n={n} load {load} extension {pull @ u:.6f}", flush=True)
    return basis, u


def shear(steps, sizes):
    """The unit square held at y = 0, its top moved by 1 along x, on finer and finer meshes;
    yields (n, basis, u).

    On meshes of 16 and more the potential has a lower minimum than the smooth solution, in which
    the surface folds at
    the two compressed corners. No such fold is seen by particles of 1/20 or 1/40. What is
    followed here is the
    smooth equilibrium: the first mesh is too coarse to fold, and the others start from the mesh
    before.
    """
    before = None
    for n in sizes:
        basis = square(n)
        bottom, top = (basis.get_dofs(lambda p, y=y: np.isclose(p[1], y)) for y in (0.0, 1.0))
        held = np.union1d(bottom.all(), top.all())
        axes = [basis.get_dofs(elements=True).all(name) for name in ("u^1", "u^2")]
        u = basis.zeros()
        if before is None:
            for _ in range(steps):
                u[axes[0]] += basis.doflocs[1, axes[0]] / steps
                u = newton(basis, u, basis.zeros(), held)
        else:
            inside = np.clip(basis.doflocs, 1e-12, 1 - 1e-12)
            values = (before[0].probes(inside) @ before[1]).reshape(2, -1)
            for axis, value in zip(axes, values, strict=True):
                u[axis] = value[axis]
            u[bottom.all()], u[top.all("u^1")], u[top.all("u^2")] = 0, 1, 0
            u = nearest_equilibrium(basis, u, held)
        before = basis, u
        yield n, basis, u


def nearest_equilibrium(basis, u, held):
    """Newton on the residual alone: the equilibrium near `u`, a minimum or not."""
    free = basis.complement_dofs(held)

    def left(u):
        if not np.isfinite(potential(basis, u, basis.zeros())):
            return np.inf
        return np.linalg.norm(internal.assemble(basis, u=basis.interpolate(u))[free])

    for _ in range(60):
        before, field, step = left(u), basis.interpolate(u), 1.0
        if before < 1e-9:
            break
        residual = -internal.assemble(basis, u=field)
        du = solve(*condense(stiffness.assemble(basis, u=field), residual, D=held))
        while step > 1e-4 and left(u + step * du) >= before:
            step /= 2
        u = u + step * du
    return u


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
    held = np.unique(
        np.concatenate(
            [
                basis.get_dofs(lambda p: np.isclose(p[2], 0)).all(),
                basis.get_dofs(lambda p: np.isclose(p[0], 0)).all("u^1"),
                basis.get_dofs(lambda p: np.isclose(p[1], 0)).all("u^2"),
            ]
        )
    )
    u = basis.zeros()
    for load in loads:
        u = newton(basis, u, load * pull, held)
    return pull @ u / 0.25


def main():
    gx, gy = np.linspace(0.05, 0.95, 10), np.linspace(0.02, 0.98, 9)
    points = np.stack(np.meshgrid(gx, gy, indexing="ij"), -1).reshape(-1, 2)
    solutions = {
        "tension": [tension(n, np.linspace(0.5, 3.5, 7)) for n in (24, 36)],
        "shear": [(basis, u) for _, basis, u in shear(10, (12, 14, 18, 22, 28, 36))],
        # Straight on a fine mesh the path leads down to the folded minimum.
        "shear_folded": [found[1:] for n in (28, 36) for found in shear(20, (n,))],
    }
    for name, found in solutions.items():
        coarse, fine = (sample(basis, u, points) for basis, u in found[-2:])
        difference = np.sqrt(((coarse - fine) ** 2).sum() / (fine**2).sum())
        energies = [energy.assemble(basis, u=basis.interpolate(u)) for basis, u in found]
        print(f"{name}: L2 difference of the two finest meshes {difference:.2e}")
        print(f"{name}: energies {np.round(energies, 6)}")
        rows = np.hstack([points, fine])
        np.savetxt(HERE / f"block_{name}.csv", rows, "%.8f", ",", header="x,y,u_x,u_y", comments="")
    with open(HERE / "cube.csv", "w") as f:
        f.write("elements_half_width,elements_height,load,extension\n")
        for nx, nz in ((2, 4), (3, 6), (5, 9)):
            extension = cube(nx, nz, (1.0, 2.0, 3.0))
            print(f"cube {nx} {nz}: {extension:.6f}", flush=True)
            f.write(f"{nx},{nz},3,{extension:.6f}\n")


if __name__ == "__main__":
    main()
