"""Finite-element reference: square plate with a circular hole under tension, plane strain.

Square |x|, |y| < 4 a, hole of radius a at the centre, uniform tension S along x on x = +-4 a, the
edges y = +-4 a and the hole free, E = 1, nu = .3. In three dimensions: thickness t = a, the faces
z = 0 and z = t held in z only (u_z = 0), which is plane strain at any thickness. Quantities: peak
sigma_xx at (0, a) over S; sigma_yy at (a, 0) over S; mean u_x of the face x = 4 a (relative to the
symmetry plane x = 0), in S a / E.

How: a quarter of the plate, elements Q_p on a grid graded towards the hole, exact circle.

| degree, elements, unknowns | peak sigma_xx / S | sigma_yy(a, 0) / S | mean u_x E / (S a) |
|---|---|---|---|
| 2, 144, 1250 | 3.5928518 | -1.4808713 | 4.2854356 |
| 2, 576, 4802 | 3.5855613 | -1.4765872 | 4.2854884 |
| 2, 2304, 18818 | 3.5837726 | -1.4755309 | 4.2854922 |
| 6, 36, 2738 | 3.5832166 | -1.4752093 | 4.2854925 |
| 8, 64, 8450 | 3.5832160 | -1.4752088 | 4.2854925 |
| 10, 100, 20402 | 3.5832160 | -1.4752088 | 4.2854925 |

The stresses in the plane do not depend on nu, nor on plane strain or plane stress (traction load,
no net force on the hole). Plane stress has mean u_x = 4.7093324.
"""

import numpy as np
from quad2d import Plane, stiffness

HALF = 4.0  # half-width over the radius of the hole


def lower(s, t):
    """Polar sector from 0 to 45 degrees: from the hole (s = 0) to the side x = 4 (s = 1)."""
    angle = t * np.pi / 4
    c, d, k = np.cos(angle), np.sin(angle), np.pi / 4
    x1, y1, y1t = HALF, HALF * np.tan(angle), HALF * k / c**2
    return (
        (1 - s) * c + s * x1,
        (1 - s) * d + s * y1,
        x1 - c,
        -(1 - s) * d * k,
        y1 - d,
        (1 - s) * c * k + s * y1t,
    )


def upper(s, t):
    """Polar sector from 45 to 90 degrees, the mirror image of the lower one."""
    y, x, ys, yt, xs, xt = lower(s, 1 - t)
    return x, y, xs, -xt, ys, -yt


def run(p: int, n: int, ratio: float, poisson_ratio: float = 0.3, plane_strain: bool = True):
    """Peak sigma_xx, sigma_yy at (1, 0), mean u_x of the loaded side (S = E = a = 1), unknowns."""
    s = np.cumsum(np.concatenate([[0.0], ratio ** np.arange(2 * n)]))
    s /= s[-1]
    t = np.linspace(0, 1, n + 1)
    body = Plane([(s, t, lower), (s, t, upper)], p, stiffness(1.0, poisson_ratio, plane_strain))
    x, y = body.nodes.T
    f = body.edge_load(lambda x, y: np.abs(x - HALF) < 1e-9, lambda x, y, nx, ny: (nx, ny))
    u = body.solve(f, x < 1e-9, y < 1e-9)
    return (
        body.stress(u, 0.0, 1.0).mean(0)[0],
        body.stress(u, 1.0, 0.0).mean(0)[1],
        float(f @ u) / HALF,
        len(f),
    )


if __name__ == "__main__":
    for p, n, ratio in (
        (2, 6, 1.25),
        (2, 12, 1.12),
        (2, 24, 1.06),
        (6, 3, 1.5),
        (8, 4, 1.4),
        (10, 5, 1.3),
    ):
        peak, side, mean, unknowns = run(p, n, ratio)
        print(
            f"degree {p}, {4 * n * n} elements, {unknowns} unknowns: peak sigma_xx / S {peak:.7f},"
            f" sigma_yy(a, 0) / S {side:.7f}, mean u_x E / (S a) {mean:.7f}",
            flush=True,
        )
    print(
        "plane stress, for comparison:",
        *(f"{v:.7f}" for v in run(10, 5, 1.3, plane_strain=False)[:3]),
    )
