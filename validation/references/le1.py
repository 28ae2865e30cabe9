"""Finite-element reference: elliptic membrane (NAFEMS LE1), plane stress and plane strain.

Quarter of an elliptic ring between (x/2)^2 + y^2 = 1 and (x/3.25)^2 + (y/2.75)^2 = 1 (m), E = 210
GPa, nu = .3; outward pressure of 10 MPa on the outer ellipse, inner ellipse free; u_x = 0 on x =
0, u_y = 0 on y = 0. In three dimensions (plane strain): a slice with u_z = 0 on both faces.
Quantities: sigma_yy at D = (2, 0); u_x of D; work of the load per metre of thickness (the
quarter).

How: elements Q_p on a grid of n x n mapped elements, exact ellipses.

| | degree, grid | sigma_yy(D), MPa | sigma_xx(D), MPa (exact: 0) | u_x(D), um | work, J/m |
|---|---|---|---|---|---|
| plane stress | 2, 8 x 8 | 93.345698 | 3.342674 | -101.971531 | 12164.9364 |
| | 2, 32 x 32 | 92.758054 | .372376 | -102.207758 | 12167.4613 |
| | 6, 4 x 4 | 92.663982 | .030278 | -102.208216 | 12167.4719 |
| | 8, 6 x 6 | 92.658239 | .000181 | -102.208503 | 12167.4719 |
| | 10, 6 x 6 | 92.658181 | .000004 | -102.208503 | 12167.4719 |
| plane strain | 2, 8 x 8 | 94.145119 | 4.245745 | -92.787918 | 10287.6175 |
| | 2, 32 x 32 | 92.848134 | .471086 | -93.009146 | 10290.2160 |
| | 6, 4 x 4 | 92.670382 | .036988 | -93.009444 | 10290.2270 |
| | 8, 6 x 6 | 92.658280 | .000222 | -93.009738 | 10290.2270 |
| | 10, 6 x 6 | 92.658182 | .000005 | -93.009738 | 10290.2270 |

The published target is 92.7 MPa (plane stress). The stresses in the plane are the same in plane
strain: with tractions and symmetry planes alone they do not depend on the elastic constants.
"""

import numpy as np
from quad2d import Plane, stiffness


def quarter(s, t):
    """Inner ellipse at s = 0, outer at s = 1; t = 0 on the x axis, t = 1 on the y axis."""
    angle = t * np.pi / 2
    a, b, c, d = 2 + 1.25 * s, 1 + 1.75 * s, np.cos(angle), np.sin(angle)
    return a * c, b * d, 1.25 * c, -a * d * np.pi / 2, 1.75 * d, b * c * np.pi / 2


def run(p: int, n: int, plane_strain: bool, pressure: float = 10e6, young_modulus: float = 210e9):
    """Stress and u_x at D, work of the load, number of unknowns, total load."""
    grid = np.linspace(0, 1, n + 1)
    body = Plane([(grid, grid, quarter)], p, stiffness(young_modulus, 0.3, plane_strain))
    x, y = body.nodes.T
    f = body.edge_load(
        lambda x, y: np.abs((x / 3.25) ** 2 + (y / 2.75) ** 2 - 1) < 1e-9,
        lambda x, y, nx, ny: (pressure * nx, pressure * ny),
    )
    u = body.solve(f, x < 1e-9, y < 1e-9)
    d = np.argmin(np.hypot(x - 2, y))
    return body.stress(u, 2.0, 0.0).mean(0), u[d], float(f @ u), len(f), f.reshape(2, -1).sum(1)


if __name__ == "__main__":
    for plane_strain in (False, True):
        for p, n in ((2, 8), (2, 32), (6, 4), (8, 6), (10, 6)):
            s, ux, work, unknowns, force = run(p, n, plane_strain)
            print(
                f"plane {'strain' if plane_strain else 'stress'}: degree {p}, {n} x {n} elements,"
                f" {unknowns} unknowns: sigma_yy(D) {s[1] / 1e6:.6f} MPa"
                f" (sigma_xx {s[0] / 1e6:.6f}), u_x(D) {ux * 1e6:.6f} um,"
                f" work per thickness {work:.7f} J/m, load {force}",
                flush=True,
            )
