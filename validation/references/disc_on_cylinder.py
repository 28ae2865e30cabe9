"""Finite-element reference: uniform pressure on a disc of the end of a cylinder, axisymmetric.

Cylinder R = H = 1, E = 1, clamped below (u = 0 on z = 0), side free, pressure 1 on r < .25 of the
top z = 1. Quantity: work int u_z dA over the disc (positive, in the direction of the pressure), in
p^2 R^3 / E.

How: elements Q_p on a tensor grid in (r, z) with layers shrinking towards the rim of the disc, the
top, the side and the clamped edge; displacement elements for nu = .3, mixed Q_p / Q_(p-2) for the
others.

| mesh (degree, layers by ratio, unknowns) | nu = .3 | nu = .45 | nu = .49 | nu = .499 |
|---|---|---|---|---|
| 4, 3 by .15, 3780 | .06241950 | .05409314 | .05129068 | .05062276 |
| 6, 3 by .15, 8478 | .06242344 | .05408614 | .05128312 | .05061509 |
| 6, 6 by .2, 23850 | .06242350 | .05408611 | .05128309 | .05061506 |
| 8, 5 by .15, 31720 | .06242352 | .05408609 | .05128307 | .05061505 |
| 10, 6 by .15, 66150 | .06242352 | .05408609 | .05128308 | .05061506 |

On a mesh without grading at the rim of the disc (h = .0125), degree 1, 2, 3 gives .06232, .062418,
.062422: an earlier value of .062413 most likely comes from such a mesh; it is 1.7e-4 too stiff.
"""

import numpy as np
import scipy.sparse as sp
from pfem import Line, geometric, lame, solve


def work(poisson_ratio: float, p: int, layers: int, ratio: float, mixed: bool) -> tuple[float, int]:
    """Work of the unit pressure over the disc, and the number of unknowns."""
    lam, mu = lame(1.0, poisson_ratio)
    middle = 0.5 * (0.25 + 1.0)
    radial = [0.0, 0.125, *geometric(0.25, 0.125, layers, ratio)]
    radial += geometric(0.25, middle, layers, ratio) + geometric(1.0, middle, layers, ratio)
    r = Line(radial, p, lambda x: x)
    z = Line(geometric(0.0, 0.5, layers, ratio) + geometric(1.0, 0.75, layers, ratio), p)
    hoop = sp.diags(1 / r.points) @ r.value  # u_r / r
    spread = r.slope + hoop  # radial part of the divergence

    def product(left, right, projected=False):
        """Integral of a product of two pairs (function of r, function of z)."""
        make = (
            (lambda line, a, b: line.projected(a, b))
            if projected
            else (lambda line, a, b: line.integral(a, b))
        )
        return sp.kron(make(r, left[0], right[0]), make(z, left[1], right[1]), format="csr")

    rr, tt, rz = (r.slope, z.value), (hoop, z.value), (r.value, z.slope)  # derivatives of u_r
    zz, zr = (r.value, z.slope), (r.slope, z.value)  # and of u_z
    div = (spread, z.value)
    k_rr = mu * (2 * product(rr, rr) + 2 * product(tt, tt) + product(rz, rz)) + lam * product(
        div, div, mixed
    )
    k_zz = mu * (2 * product(zz, zz) + product(zr, zr)) + lam * product(zz, zz, mixed)
    k_rz = mu * product(rz, zr) + lam * product(div, zz, mixed)
    inside = r.value.T @ (r.weights * (r.points < 0.25))
    load = -np.outer(inside, z.at(1.0)).ravel()
    clamp = np.broadcast_to(z.at(0.0)[None, :] > 0, (r.n, z.n))
    free_r = np.nonzero(~(clamp | (r.at(0.0)[:, None] > 0)).ravel())[0]
    free_z = np.nonzero(~clamp.ravel())[0]
    k_rz = k_rz[free_r][:, free_z]
    matrix = sp.bmat([[k_rr[free_r][:, free_r], k_rz], [k_rz.T, k_zz[free_z][:, free_z]]])
    f = np.concatenate([np.zeros(len(free_r)), load[free_z]])
    return 2 * np.pi * float(f @ solve(matrix, f)), len(f)


if __name__ == "__main__":
    for nu in (0.3, 0.45, 0.49, 0.499):
        for p, layers, ratio in (
            (4, 3, 0.15),
            (6, 3, 0.15),
            (6, 6, 0.2),
            (8, 5, 0.15),
            (10, 6, 0.15),
        ):
            value, n = work(nu, p, layers, ratio, nu > 0.4)
            print(
                f"nu {nu}: degree {p}, {layers} layers by {ratio}, {n} unknowns: {value:.8f}",
                flush=True,
            )
