"""Finite-element references of the tensile test: the clamped unit cube, nu = 0.3, unit load.

Mean displacement of the top at rest (E = 1) with quadratic hexahedra (27 nodes), for n^3 elements; the
sequence converges to 0.97055. And when the liver (E = 100, T = 0.2, density 1) first reaches 95 % of it:
0.564, with the trapezoidal rule. Needs scikit-fem (`pip install scikit-fem`).
"""

import numpy as np
from scipy.sparse.linalg import splu
from skfem import Basis, ElementHex2, ElementVector, FacetBasis, MeshHex, asm
from skfem.assembly import BilinearForm, LinearForm
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity


def cube(n: int, young_modulus: float, poisson_ratio: float = 0.3):
    """Stiffness, mass (density 1) and load of n^3 elements, without what is clamped."""
    grid = np.linspace(0.0, 1.0, n + 1)
    mesh = MeshHex.init_tensor(grid, grid, grid)
    element = ElementVector(ElementHex2())
    basis = Basis(mesh, element)
    stiffness = asm(linear_elasticity(*lame_parameters(young_modulus, poisson_ratio)), basis)
    mass = asm(BilinearForm(lambda u, v, w: dot(u, v)), basis)
    top = FacetBasis(mesh, element, facets=mesh.facets_satisfying(lambda x: x[2] == 1.0))
    load = asm(LinearForm(lambda v, w: v[2]), top)
    free = basis.complement_dofs(basis.get_dofs(mesh.facets_satisfying(lambda x: x[2] == 0.0)))
    return stiffness[free][:, free].tocsc(), mass[free][:, free].tocsc(), load[free]


def extension(n: int) -> float:
    """Mean displacement of the loaded face of a cube of n^3 elements at rest, with E = 1."""
    stiffness, _, load = cube(n, 1.0)
    return float(load @ splu(stiffness).solve(load))  # the load is the mean


def time_to(share: float, n: int, dt: float, relaxation_time: float = 0.2) -> float:
    """When M d2u/dt2 + K (u + T du/dt) = f first has that share of the extension at rest, E = 100."""
    stiffness, mass, load = cube(n, 100.0)
    target = share * load @ splu(stiffness).solve(load)
    step = splu(mass + (0.5 * dt * relaxation_time + 0.25 * dt * dt) * stiffness)
    u, v, t, before = np.zeros_like(load), np.zeros_like(load), 0.0, 0.0
    while True:
        stress = stiffness @ (u + 0.25 * dt * v + 0.5 * relaxation_time * v)
        after = step.solve(mass @ v + dt * (load - stress))
        u, v, t = u + 0.5 * dt * (v + after), after, t + dt
        reached = load @ u
        if reached >= target:
            return t - dt * (reached - target) / (reached - before)
        before = reached


if __name__ == "__main__":
    for n in (4, 6, 8):  # 0.96832, 0.96928, 0.96970; finer meshes need an iterative solver
        print(f"{n}^3 elements: E u = {extension(n):.5f}")
    for n in (3, 4):  # 0.5641, 0.5640
        print(f"{n}^3 elements: 95 % of the extension at {time_to(0.95, n, 0.002):.4f}")
