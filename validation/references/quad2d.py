"""Plane elements of any degree on mapped grids (not a case by itself; see plate_with_hole.py and
le1.py).

A block is the unit square (s, t) with a grid, mapped to the plane by a given smooth function, so
curved edges are exact. Blocks are joined at coincident nodes. Displacement elements Q_p with
Gauss-Lobatto nodes.
"""

import numpy as np
import scipy.sparse as sp
from pfem import lagrange, lobatto, solve


class Plane:
    """Blocks of mapped Q_p elements with the stiffness `c` for (e_xx, e_yy, gamma_xy)."""

    def __init__(self, blocks, p: int, c: np.ndarray):
        """`blocks`: (s breaks, t breaks, mapping); mapping(s, t) gives x, y, x_s, x_t, y_s, y_t."""
        self.p, self.c = p, c
        self.cells, points = [], []
        ref = (lobatto(p) + 1) / 2
        for sb, tb, mapping in blocks:
            for i in range(len(sb) - 1):
                for j in range(len(tb) - 1):
                    s = sb[i] + (sb[i + 1] - sb[i]) * ref
                    t = tb[j] + (tb[j + 1] - tb[j]) * ref
                    x, y = mapping(np.repeat(s, p + 1), np.tile(t, p + 1))[:2]
                    points.append(np.stack([x, y], 1))
                    self.cells.append((sb[i], sb[i + 1], tb[j], tb[j + 1], mapping))
        points = np.concatenate(points)
        _, first, inverse = np.unique(
            np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True
        )
        self.nodes, self.dofs = points[first], inverse.reshape(len(self.cells), -1)

    def shape(self, cell, a, b):
        """Positions, values, derivatives in x and y, Jacobian at the points (a, b) of [-1, 1]^2."""
        s0, s1, t0, t1, mapping = cell
        va, da = lagrange(self.p, a)
        vb, db = lagrange(self.p, b)
        value = np.einsum("qi,qj->qij", va, vb).reshape(len(a), -1)
        ds = np.einsum("qi,qj->qij", da, vb).reshape(len(a), -1) * 2 / (s1 - s0)
        dt = np.einsum("qi,qj->qij", va, db).reshape(len(a), -1) * 2 / (t1 - t0)
        x, y, xs, xt, ys, yt = mapping(s0 + (s1 - s0) * (a + 1) / 2, t0 + (t1 - t0) * (b + 1) / 2)
        jac = (xs * yt - xt * ys)[:, None]
        dx = (yt[:, None] * ds - ys[:, None] * dt) / jac
        dy = (xs[:, None] * dt - xt[:, None] * ds) / jac
        return x, y, value, dx, dy, jac[:, 0] * (s1 - s0) * (t1 - t0) / 4

    @staticmethod
    def strain(dx, dy):
        """Strain-displacement matrices (q, 3, 2 n)."""
        zero = np.zeros_like(dx)
        return np.stack([np.concatenate(r, 1) for r in ((dx, zero), (zero, dy), (dy, dx))], 1)

    def stiffness(self):
        """Global stiffness matrix; the unknowns are all u_x, then all u_y."""
        g, w = np.polynomial.legendre.leggauss(self.p + 3)
        a, b, w = np.repeat(g, len(g)), np.tile(g, len(g)), np.outer(w, w).ravel()
        n, rows, cols, data = len(self.nodes), [], [], []
        for cell, dofs in zip(self.cells, self.dofs, strict=False):
            _, _, _, dx, dy, jac = self.shape(cell, a, b)
            m = self.strain(dx, dy)
            k = np.einsum("qai,ab,qbj,q->ij", m, self.c, m, w * np.abs(jac), optimize=True)
            d = np.concatenate([dofs, dofs + n])
            rows.append(np.repeat(d, len(d)))
            cols.append(np.tile(d, len(d)))
            data.append(k.ravel())
        return sp.csr_matrix(
            (np.concatenate(data), (np.concatenate(rows), np.concatenate(cols))), (2 * n, 2 * n)
        )

    def edge_load(self, on_edge, traction):
        """Nodal forces of traction(x, y, nx, ny) on the edges of constant s where on_edge(x, y)."""
        g, w = np.polynomial.legendre.leggauss(self.p + 3)
        n, f = len(self.nodes), np.zeros(2 * len(self.nodes))
        for cell, dofs in zip(self.cells, self.dofs, strict=False):
            for side in (-1.0, 1.0):
                s0, s1, t0, t1, mapping = cell
                x, y, value, *_ = self.shape(cell, np.full(len(g), side), g)
                if not np.all(on_edge(x, y)):
                    continue
                s = np.full(len(g), s1 if side > 0 else s0)
                _, _, xs, xt, ys, yt = mapping(s, t0 + (t1 - t0) * (g + 1) / 2)
                turn = (
                    np.sign(xs * yt - xt * ys) * side
                )  # outward: (y_t, -x_t), turned along increasing s
                tx, ty = traction(x, y, turn * yt, -turn * xt)  # the normal carries the arc length
                np.add.at(f, dofs, value.T @ (tx * w * (t1 - t0) / 2))
                np.add.at(f, dofs + n, value.T @ (ty * w * (t1 - t0) / 2))
        return f

    def solve(self, f, fix_x, fix_y):
        """Displacement, with u_x = 0 and u_y = 0 at the flagged nodes."""
        free = np.nonzero(~np.concatenate([fix_x, fix_y]))[0]
        u = np.zeros(len(f))
        u[free] = solve(self.stiffness()[free][:, free], f[free])
        return u

    def stress(self, u, x: float, y: float) -> np.ndarray:
        """Stress (xx, yy, xy) at the node at (x, y), one row for each of its elements."""
        node = np.argmin((self.nodes[:, 0] - x) ** 2 + (self.nodes[:, 1] - y) ** 2)
        assert np.hypot(*(self.nodes[node] - (x, y))) < 1e-6
        s, n, out = lobatto(self.p), len(self.nodes), []
        for cell, dofs in zip(self.cells, self.dofs, strict=False):
            for k in np.nonzero(dofs == node)[0]:
                i, j = divmod(k, self.p + 1)
                _, _, _, dx, dy, _ = self.shape(cell, s[i : i + 1], s[j : j + 1])
                out.append(self.c @ self.strain(dx, dy)[0] @ np.concatenate([u[dofs], u[dofs + n]]))
        return np.array(out)


def stiffness(young_modulus: float, nu: float, plane_strain: bool) -> np.ndarray:
    """Stiffness for (e_xx, e_yy, gamma_xy)."""
    if plane_strain:
        young_modulus, nu = young_modulus / (1 - nu**2), nu / (1 - nu)
    return young_modulus / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
