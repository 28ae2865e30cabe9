"""Thick walls inflated by a pressure that follows them: the exact radial solution.

A hollow sphere and a tube in plane strain, of radii a = 1 and b = 2, E = 10, free outside. The
pressure is that at which the inner wall has a hoop stretch of 1.2. With the stretches l_r = dr/dR
and l_t = r/R and J = l_r l_t^k (k = 2 for the sphere, 1 for the tube) the nominal stresses are
P_i = mu (l_i - 1/l_i) + lambda ln(J) / l_i (and l_z = 1), and equilibrium is dP_r/dR = -k (P_r -
P_t)/R with P_r(a) = -p l_t(a)^k and P_r(b) = 0. Integrated from the inner wall; the pressure is
found by a root search.

A tube of fibres wound around its axis is inflated to a hoop stretch of 1.1: two families of fibres
of Holzapfel, Gasser and Ogden along the hoop, mu = 3.5, k1 = 10, k2 = 1, kappa = 0.1, whose
nominal stresses are the derivatives of the energy of docs/guide/scenario.md by the stretches.

    python inflated_walls.py

Prints for each wall and Poisson's ratio: p, u(b) (u(a) is 0.2, or 0.1) and the Cauchy hoop
stresses at both walls.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

A, B, YOUNG = 1.0, 2.0, 10.0
MU, K1, K2, KAPPA = 3.5, 10.0, 1.0, 0.1

# From the radial and the hoop stretch to the nominal stresses along them.
Law = Callable[[float, float], tuple[float, float]]


def neo_hookean(k: int, nu: float) -> Law:
    mu = YOUNG / (2 * (1 + nu))
    lam = YOUNG * nu / ((1 + nu) * (1 - 2 * nu))

    def stress(l_r: float, l_t: float) -> tuple[float, float]:
        volume = lam * np.log(l_r * l_t**k)
        return mu * (l_r - 1 / l_r) + volume / l_r, mu * (l_t - 1 / l_t) + volume / l_t

    return stress


def wound(nu: float) -> Law:
    """A tube, with fibres along the hoop."""
    bulk = 2 * MU * (1 + nu) / (3 * (1 - 2 * nu))

    def stress(l_r: float, l_t: float) -> tuple[float, float]:
        j = l_r * l_t
        scale = j ** (-2 / 3)
        i_1, i_4 = scale * (l_r**2 + l_t**2 + 1), scale * l_t**2
        e = max(KAPPA * (i_1 - 3) + (1 - 3 * KAPPA) * (i_4 - 1), 0.0)
        of_fibres = 2 * K1 * e * np.exp(K2 * e**2)

        def along(stretch: float, is_hoop: bool) -> float:
            d_1 = 2 * scale * stretch - 2 / 3 * i_1 / stretch
            d_4 = 2 * scale * stretch * is_hoop - 2 / 3 * i_4 / stretch
            of_ground = MU / 2 * d_1 + bulk * np.log(j) / stretch
            return of_ground + of_fibres * (KAPPA * d_1 + (1 - 3 * KAPPA) * d_4)

        return along(l_r, False), along(l_t, True)

    return stress


def solve(k: int, stress: Law, stretch: float) -> tuple[float, float, float, float]:
    def radial(p_r: float, l_t: float) -> float:
        return brentq(lambda x: stress(x, l_t)[0] - p_r, 0.2, 3.0, xtol=1e-15)

    def rate(radius: float, y: np.ndarray) -> list[float]:
        r, p_r = y
        l_t = r / radius
        l_r = radial(p_r, l_t)
        return [l_r, -k * (p_r - stress(l_r, l_t)[1]) / radius]

    def outer(p: float) -> np.ndarray:
        start = [stretch * A, -p * stretch**k]
        return solve_ivp(rate, (A, B), start, rtol=1e-11, atol=1e-13, method="DOP853").y[:, -1]

    p = brentq(lambda p: outer(p)[1], 0.05, 15.0, xtol=1e-12)
    r_b = outer(p)[0]

    def hoop(radius: float, r: float, p_r: float) -> float:
        l_t = r / radius
        l_r = radial(p_r, l_t)
        return stress(l_r, l_t)[1] * l_t / (l_r * l_t**k)

    return p, r_b - B, hoop(A, stretch * A, -p * stretch**k), hoop(B, r_b, 0.0)


if __name__ == "__main__":
    for name, k in (("sphere", 2), ("tube", 1)):
        for nu in (0.3, 0.45, 0.49, 0.499):
            print(name, nu, *(f"{x:.7g}" for x in solve(k, neo_hookean(k, nu), 1.2)))
    for nu in (0.3, 0.45, 0.49):
        print("wound tube", nu, *(f"{x:.7g}" for x in solve(1, wound(nu), 1.1)))
