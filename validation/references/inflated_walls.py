"""Thick walls inflated by a pressure that follows them: the exact radial solution.

A hollow sphere and a tube in plane strain, of radii a = 1 and b = 2, E = 10, free outside. The
pressure is that at which the inner wall has a hoop stretch of 1.2. With the stretches l_r = dr/dR
and l_t = r/R and J = l_r l_t^k (k = 2 for the sphere, 1 for the tube) the nominal stresses are
P_i = mu (l_i - 1/l_i) + lambda ln(J) / l_i (and l_z = 1), and equilibrium is dP_r/dR = -k (P_r -
P_t)/R with P_r(a) = -p l_t(a)^k and P_r(b) = 0. Integrated from the inner wall; the pressure is
found by a root search.

    python inflated_walls.py

Prints for each wall and Poisson's ratio: p, u(b) (u(a) is 0.2) and the Cauchy hoop stresses at
both walls.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

A, B, YOUNG, STRETCH = 1.0, 2.0, 10.0, 1.2


def solve(k: int, nu: float) -> tuple[float, float, float, float]:
    mu = YOUNG / (2 * (1 + nu))
    lam = YOUNG * nu / ((1 + nu) * (1 - 2 * nu))

    def stress(x: float, others: float, along: float) -> float:
        """P along a stretch, with the stretches `x` and the product of the others."""
        return mu * (along - 1 / along) + lam * np.log(x * others) / along

    def radial(p_r: float, l_t: float) -> float:
        return brentq(lambda x: stress(x, l_t**k, x) - p_r, 1e-2, 10.0, xtol=1e-15)

    def rate(radius: float, y: np.ndarray) -> list[float]:
        r, p_r = y
        l_t = r / radius
        l_r = radial(p_r, l_t)
        return [l_r, -k * (p_r - stress(l_r, l_t**k, l_t)) / radius]

    def outer(p: float) -> np.ndarray:
        start = [STRETCH * A, -p * STRETCH**k]
        return solve_ivp(rate, (A, B), start, rtol=1e-11, atol=1e-13, method="DOP853").y[:, -1]

    p = brentq(lambda p: outer(p)[1], 0.05, 20.0, xtol=1e-12)
    r_b = outer(p)[0]

    def hoop(radius: float, r: float, p_r: float) -> float:
        l_t = r / radius
        l_r = radial(p_r, l_t)
        return stress(l_r, l_t**k, l_t) * l_t / (l_r * l_t**k)

    return p, r_b - B, hoop(A, STRETCH * A, -p * STRETCH**k), hoop(B, r_b, 0.0)


if __name__ == "__main__":
    for name, k in (("sphere", 2), ("tube", 1)):
        for nu in (0.3, 0.45, 0.49, 0.499):
            print(name, nu, *(f"{x:.7g}" for x in solve(k, nu)))
