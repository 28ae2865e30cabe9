"""Finite-element reference: a liver under a smeared load and under its own weight.

Liver surface `shared/data/meshes/visible_human_liver_female.stl` (beside the repository), cut at
the plane y = y_min + .15 H, u = 0 on the cut; E = 1e5 Pa, small strain. Load: traction -270 Pa
exp(-d^2/r^2) e_y where n_y > 0, d the distance to c = (.078748, .051970, -.003656) m, r = .15 L_x
= .037132 m (total -.7052 N); or the own weight, 9810 N/m^3 along +x, +y, +z. Volume of the cut
body 2.0999e-3 m^3.

How: TetGen mesh of the clipped and capped surface, P2 elements for nu = .3 (their compliance is a
lower bound), Taylor-Hood P2/P1 for (b). `edge`: bisections of the tetrahedra at the rim of the
clamp, whose singularity holds most of the error. (a), compliance in 1e-4 J and u(c) in mm:

| mesh | unknowns | nu = .3, P2 | u(c) |
|---|---|---|---|
| pq10 | 142764 | 7.3132 | (.4640, -1.4247, -1.3384) |
| pq4 | 175212 | 7.3436 | (.4660, -1.4300, -1.3451) |
| pq2 | 265413 | 7.3590 | (.4671, -1.4323, -1.3482) |
| pq10, edge 1 | 228927 | 7.3603 | (.4678, -1.4324, -1.3470) |
| pq10, edge 2 | 302286 | 7.3687 | (.4684, -1.4337, -1.3485) |
| pq10, edge 4 (two-level cg) | 541512 | 7.3744 | (.4689, -1.4346, -1.3493) |
| pq10, all tetrahedra in 8 (two-level cg) | 974607 | 7.3647 | (.4675, -1.4334, -1.3495) |
| pq2, edge 2 (two-level cg) | 534324 | 7.3797 | (.4689, -1.4357, -1.3517) |

Rim and interior errors added up, the limit is 7.39 +- .02. Two-level cg: see liver_fine.py.

(b) P2/P1, compliance in 1e-4 J (nu = .3 as a check: it overshoots, so these are no bounds):

| mesh | nu = .3 | .45 | .49 | .499 |
|---|---|---|---|---|
| pq4 | 7.4226 | 7.4386 | 7.4152 | 7.4298 |
| pq2 | 7.4247 | 7.4489 | 7.4148 | 7.4071 |
| pq10, edge 1 | 7.4240 | 7.4462 | 7.4373 | 7.4061 |
| pq10, edge 2 | 7.4351 | | | |

Plain P2 at nu = .45: 7.3463 on pq10, edge 2, 7.3633 on pq2, edge 2 (lower bounds).

(c) nu = .3, P2: compliance int f.u dV in J, and u(c) in mm:

| mesh | x | y | z |
|---|---|---|---|
| pq4 | .0726353 | .0240674 | .0915524 |
| pq2 | .0728823 | .0241623 | .0918553 |
| pq10, edge 2 | .0731737 | .0242724 | .0922426 |
| u(c), pq10, edge 2 | (5.935, -4.534, -2.166) | (-1.753, 4.795, 4.618) | (-2.357, 7.450, 11.937) |

(d) e_nn of the patch load: mean within r/2 of c -1.9477e-3 (pq4), -1.9514e-3 (pq2), -1.9359e-3
(pq10). c is a vertex of the polyhedron, where faces of different normals meet: -2.22e-3 by area,
-1.7e-3 to -2.6e-3 by face.
"""

import time
from pathlib import Path

import numpy as np
import pyvista as pv
import scipy.sparse as sp
import skfem as sk
import tetgen
from pfem import lame, solve
from skfem.helpers import ddot, div, sym_grad
from skfem.models.elasticity import linear_elasticity

ROOT = Path(__file__).resolve().parents[2]
STL = ROOT.parent / "shared" / "data" / "meshes" / "visible_human_liver_female.stl"
YOUNG, PEAK, WEIGHT = 1e5, 270.0, 1000.0 * 9.81


class Liver:
    """Tetrahedra (these TetGen switches) of the liver above its clamp plane, refined `near` times
    around c and `edge` times along the edge of the clamped face."""

    def __init__(self, switches: str, near: int = 0, edge: int = 0):
        surface = pv.read(STL).clean()
        low, high = np.array(surface.bounds).reshape(3, 2).T
        size = high - low
        self.clamp_height = low[1] + 0.15 * size[1]
        candidates = np.asarray(surface.points, float)
        candidates = candidates[candidates[:, 0] > low[0] + 0.6 * size[0]]
        self.c, self.r = candidates[np.argmax(candidates[:, 1])], 0.15 * size[0]
        cut = (
            surface.clip_closed_surface(normal=(0, 1, 0), origin=(0, self.clamp_height, 0))
            .triangulate()
            .clean()
        )
        mesher = tetgen.TetGen(cut)
        mesher.tetrahedralize(switches=switches + "Q")
        grid = mesher.grid
        cells = grid.cells.reshape(-1, 5)[:, 1:]
        mesh = sk.MeshTet(
            np.ascontiguousarray(grid.points.T, float),
            np.ascontiguousarray(cells.T.astype(np.int64)),
        )
        for k in range(near):
            centre = mesh.p[:, mesh.t].mean(1)
            close = np.linalg.norm(centre - self.c[:, None], axis=0) < self.r * 0.8 * 0.6**k
            mesh = mesh.refined(np.nonzero(close)[0])
        for _ in range(edge):
            faces = mesh.facets[:, mesh.boundary_facets()]
            clamped = (mesh.p[1, faces] < self.clamp_height + 1e-7).all(0)
            rim = np.intersect1d(faces[:, clamped], faces[:, ~clamped])
            mesh = mesh.refined(np.nonzero(np.isin(mesh.t, rim).any(0))[0])
        self.mesh = mesh
        self.element = sk.ElementVector(sk.ElementTetP2())
        self.basis = sk.Basis(mesh, self.element, intorder=2)
        self.facets = sk.FacetBasis(mesh, self.element, facets=mesh.boundary_facets(), intorder=6)
        self.free = np.nonzero(self.basis.doflocs[1] > self.clamp_height + 1e-7)[0]
        self.vertex = np.argmin(np.linalg.norm(mesh.p - self.c[:, None], axis=0))
        assert np.linalg.norm(mesh.p[:, self.vertex] - self.c) < 1e-9
        self.volume = float(np.sum(self.basis.dx))

    def patch(self):
        """Nodal forces of the smeared load."""

        def load(v, w):
            d2 = sum((w.x[i] - self.c[i]) ** 2 for i in range(3))
            return -PEAK * np.exp(-d2 / self.r**2) * (w.n[1] > 0) * v[1]

        return sk.asm(sk.LinearForm(load), self.facets)

    def weight(self, axis: int):
        """Nodal forces of the own weight along +axis."""
        return sk.asm(sk.LinearForm(lambda v, w: WEIGHT * v[axis]), self.basis)

    def displacement(self, loads, nu: float):
        """Displacements for the nodal forces in the columns of `loads`, by P2 elements."""
        stiffness = sk.asm(linear_elasticity(*lame(YOUNG, nu)), self.basis).tocsr()
        stiffness = stiffness[self.free][:, self.free]
        u = np.zeros_like(loads)
        u[self.free] = solve(stiffness, loads[self.free]).reshape(len(self.free), -1)
        return u

    def displacement_mixed(self, loads, nu: float):
        """The same by Taylor-Hood elements P2/P1."""
        lam, mu = lame(YOUNG, nu)
        pressure = self.basis.with_element(sk.ElementTetP1())
        shear = sk.asm(
            sk.BilinearForm(lambda u, v, w: 2 * mu * ddot(sym_grad(u), sym_grad(v))), self.basis
        )
        volume = sk.asm(sk.BilinearForm(lambda u, q, w: div(u) * q), self.basis, pressure)
        mass = sk.asm(sk.BilinearForm(lambda p, q, w: p * q / lam), pressure)
        volume = volume.tocsr()[:, self.free]
        matrix = sp.bmat(
            [[shear.tocsr()[self.free][:, self.free], volume.T], [volume, -mass]], format="csr"
        )
        right = np.concatenate([loads[self.free], np.zeros((pressure.N, loads.shape[1]))])
        u = np.zeros_like(loads)
        u[self.free] = solve(matrix, right, definite=False).reshape(right.shape)[: len(self.free)]
        return u

    def at_c(self, u):
        """Displacement of c in mm."""
        return 1e3 * u[self.basis.nodal_dofs[:, self.vertex]]

    def normal_strain(self, u):
        """n.e.n on the loaded surface: at c, where several faces meet, their mean by area, least
        and greatest value; and the means over the surface within r/2, r/4, r/8 of c."""
        faces = self.mesh.boundary_facets()

        def sample(facets, **rule):
            basis = sk.FacetBasis(self.mesh, self.element, facets=facets, **rule)
            strain = np.asarray(sym_grad(basis.interpolate(u)))
            n, x = np.asarray(basis.normals), np.asarray(basis.global_coordinates())
            distance = np.linalg.norm(x - self.c[:, None, None], axis=0)
            return np.einsum("ijfq,ifq,jfq->fq", strain, n, n), n, distance, basis.dx

        enn, n, distance, dx = sample(faces, intorder=10)
        means = []
        for part in (2, 4, 8):
            w = dx * (n[1] > 0) * (distance < self.r / part)
            means.append(float((w * enn).sum() / w.sum()))
        around = faces[(self.mesh.facets[:, faces] == self.vertex).any(0)]
        corners = (np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), np.full(3, 1 / 6))
        enn, n, distance, dx = sample(around, quadrature=corners)
        here = distance < 1e-9
        return (
            float((enn * dx)[here].sum() / dx[here].sum()),
            enn[here].min(),
            enn[here].max(),
            means,
        )


def vector(v):
    """Three numbers for the tables."""
    return "(" + ", ".join(f"{x:.4f}" for x in v) + ")"


def compressible(switches: str, near: int, edge: int, weights: bool):
    """Parts (a), (c), (d) on one mesh."""
    start = time.time()
    body = Liver(switches, near, edge)
    loads = [body.patch()] + ([body.weight(k) for k in range(3)] if weights else [])
    loads = np.stack(loads, 1)
    u = body.displacement(loads, 0.3)
    print(
        f"{switches}, near {near}, edge {edge}: {body.mesh.nelements} tetrahedra, "
        f"{len(body.free)} unknowns, volume {body.volume:.7e} m3, "
        f"c {body.c}, r {body.r:.6f}, total load {loads[:, 0].sum():.5f} N",
        flush=True,
    )
    for k in range(loads.shape[1]):
        print(
            f"  nu 0.3, {('patch', 'weight x', 'weight y', 'weight z')[k]}: "
            f"compliance {u[:, k] @ loads[:, k]:.6e} J, u(c) {vector(body.at_c(u[:, k]))} mm"
        )
    here, least, most, means = body.normal_strain(u[:, 0])
    print(
        f"  patch: e_nn at c {here:.5e} (faces {least:.4e} to {most:.4e}), "
        f"mean within r/2, r/4, r/8: {', '.join(f'{m:.5e}' for m in means)}"
        f" ({time.time() - start:.0f} s)",
        flush=True,
    )


def mixed(switches: str, edge: int, ratios=(0.3, 0.45, 0.49, 0.499)):
    """Part (b) on one mesh; nu = .3 as a check of the mixed form."""
    body = Liver(switches, 0, edge)
    load = body.patch()[:, None]
    for nu in ratios:
        start = time.time()
        u = body.displacement_mixed(load, nu)
        print(
            f"{switches}, edge {edge}: {body.mesh.nelements} tetrahedra, "
            f"{len(body.free)} + {body.mesh.nvertices} unknowns, mixed, nu {nu}, patch: "
            f"compliance {u[:, 0] @ load[:, 0]:.6e} J, u(c) {vector(body.at_c(u[:, 0]))} mm"
            f" ({time.time() - start:.0f} s)",
            flush=True,
        )


if __name__ == "__main__":  # up to 5 GB of memory
    for switches, edge in (("pq4", 0), ("pq2", 0), ("pq10", 1), ("pq10", 2)):
        compressible(switches, 0, edge, True)
    for switches, edge in (("pq4", 0), ("pq2", 0), ("pq10", 1), ("pq10", 2)):
        mixed(switches, edge)
    compressible("pq4", 2, 0, False)
