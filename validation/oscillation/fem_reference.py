"""References of the beam: first bending frequency of a free 1 x 0.1 x 0.1 bar.

E = 100, rho = 1, nu = 0.3. Quadratic hexahedra (27 nodes), consistent mass, a symmetric eighth;
Euler-Bernoulli and Timoshenko beams beside it. Needs scikit-fem (`pip install scikit-fem`).
"""

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.sparse.linalg import eigsh
from skfem import Basis, BilinearForm, ElementHex2, ElementVector, MeshHex, asm, condense
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

E, RHO, NU, LENGTH, SIDE = 100.0, 1.0, 0.3, 1.0, 0.1


def solid(along: int, across: int) -> float:
    """Frequency of the solid with that many elements along half the length and half a side."""
    x = np.linspace(0.0, LENGTH / 2, along + 1)  # from the middle to an end
    y = np.linspace(0.0, SIDE / 2, across + 1)
    basis = Basis(MeshHex.init_tensor(x, y, y), ElementVector(ElementHex2()))
    stiffness = asm(linear_elasticity(*lame_parameters(E, NU)), basis)
    mass = asm(BilinearForm(lambda u, v, w: RHO * dot(u, v)), basis)
    # Bending along y, symmetric about the middle: u_x is odd in x and in y, u_y is even in both,
    # u_z is odd in y and in z.
    fixed = np.concatenate(
        [
            basis.get_dofs(lambda p: np.isclose(p[0], 0.0)).all(["u^1"]),
            basis.get_dofs(lambda p: np.isclose(p[1], 0.0)).all(["u^1", "u^3"]),
            basis.get_dofs(lambda p: np.isclose(p[2], 0.0)).all(["u^3"]),
        ]
    )
    k, m, _, _ = condense(stiffness, mass, D=np.unique(fixed))
    values = eigsh(k.tocsc(), 3, m.tocsc(), sigma=10.0, return_eigenvectors=False)
    return float(np.sqrt(min(v for v in values if v > 1e-3)) / (2 * np.pi))


def euler_bernoulli() -> float:
    """Frequency of a slender beam without shear and rotary inertia."""
    root = brentq(lambda b: np.cosh(b) * np.cos(b) - 1.0, 4.0, 5.0)
    return float(root**2 / (2 * np.pi) * np.sqrt(E * SIDE**2 / (12 * RHO)) / LENGTH**2)


def timoshenko() -> float:
    """Frequency with shear (coefficient of Cowper 1966) and rotary inertia: exact determinant."""
    kappa = 10 * (1 + NU) / (12 + 11 * NU)
    area, inertia, shear = SIDE**2, SIDE**4 / 12, E / (2 * (1 + NU))

    def unbalanced(omega: float) -> float:
        # State w, psi, M, Q: w' = Q/(kA G) + psi, psi' = M/EI,
        # M' = -rho I omega^2 psi - Q, Q' = -rho A omega^2 w.
        a = np.array(
            [
                [0, 1, 0, 1 / (kappa * area * shear)],
                [0, 0, 1 / (E * inertia), 0],
                [0, -RHO * inertia * omega**2, 0, -1],
                [-RHO * area * omega**2, 0, 0, 0],
            ]
        )
        across = expm(a * LENGTH)
        return float(np.linalg.det(across[2:, :2]))  # both M and Q vanish at both ends

    omega = 2 * np.pi * euler_bernoulli()
    return float(brentq(unbalanced, 0.8 * omega, 0.9999 * omega) / (2 * np.pi))


if __name__ == "__main__":
    print(f"Euler-Bernoulli {euler_bernoulli():.6f}")
    print(f"Timoshenko      {timoshenko():.6f}")
    for along, across in ((8, 1), (12, 2), (20, 2), (24, 3)):
        print(f"solid, {along} x {across} x {across} elements: {solid(along, across):.6f}")
