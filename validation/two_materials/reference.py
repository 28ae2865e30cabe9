"""Finite-element reference: a stiff tumour in an organ that is held at one end.

    pip install numpy scipy scikit-fem tetgen pyvista pypardiso
    python reference.py          # about ten minutes, 5 GB of memory

Body: the ellipsoid of half axes 80, 50 and 40 mm around the origin, cut and held (u = 0) at the
plane x = -56 mm. Tumour: the ball of radius 15 mm around (20, 8, -5) mm. E = 5 kPa, in the tumour
50 kPa; density 1000 kg/m^3; the same Poisson's ratio everywhere. Loads: the own weight under an
acceleration along x (`pulled`) or against z (`bent`). Laws: small strain, and the compressible
neo-Hookean one, mu/2 (F:F - 3) - mu ln J + lambda/2 (ln J)^2, under larger accelerations.

How: TetGen meshes with the interface in them and with bisected elements at the rim of the hold,
where strain is singular; quadratic tetrahedra whose curved faces lie on ellipsoid and ball; Newton
on two load steps for large strain. Three meshes in small strain: the first two differ at the rim,
the last two elsewhere. Writes `reference.json` (all meshes), `points.csv` and `line.csv` (the last
mesh); strain is sym grad u in small strain and Hencky's ln V in large strain.
"""

import csv
import json
import sys
import time
from pathlib import Path

import numpy as np
import pyvista as pv
import scipy.sparse as sp
import skfem as sk
import tetgen
from scipy.spatial import ConvexHull, Delaunay, cKDTree

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "references"))
from pfem import lame, solve  # noqa: E402

AXES = np.array([0.08, 0.05, 0.04])
CUT = -0.056
CENTRE, RADIUS = np.array([0.02, 0.008, -0.005]), 0.015
YOUNG, STIFFER, DENSITY = 5e3, 10.0, 1000.0
RATIOS = (0.3, 0.45)
LOADS = {
    "kelvin-voigt": {"pulled": (1.0, 0.0, 0.0), "bent": (0.0, 0.0, -0.2)},
    "neo-hookean": {"pulled": (10.0, 0.0, 0.0), "bent": (0.0, 0.0, -2.0)},
}
STEPS = (0.5, 1.0)
# Numbers of the meshes of each law.
RUNS = {"kelvin-voigt": (0, 1, 2), "neo-hookean": (1,)}
# Elements that are assembled at once.
CHUNK = 1000
# Edges on the ellipsoid and the ball (m), largest volume of a tetrahedron (m^3), bisections of the
# tetrahedra at the rim of the hold, where strain is singular.
MESHES = [(0.008, 2, 1.6e-7, 1), (0.008, 2, 1.6e-7, 3), (0.006, 3, 6e-8, 3)]
POINTS = {
    "far end": (0.08, 0.0, 0.0),
    "top": (0.0, 0.0, 0.04),
    "side": (0.0, 0.05, 0.0),
    "centre of the tumour": tuple(CENTRE),
    "tumour, towards the end": (0.035, 0.008, -0.005),
    "tumour, towards the hold": (0.005, 0.008, -0.005),
    "parenchyma, towards the hold": (-0.03, 0.01, 0.01),
    "parenchyma, below": (0.03, -0.015, -0.015),
}


def fibonacci(n):
    """About evenly spread points on the unit sphere."""
    k = np.arange(n) + 0.5
    x, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    r = np.sqrt(1 - x**2)
    return np.stack([x, r * np.cos(turn), r * np.sin(turn)], 1)


def organ(edge):
    """Triangles of the cut ellipsoid, from the hull of points on the unit sphere."""
    h, cut = edge / AXES.mean(), CUT / AXES[0]
    ball = fibonacci(int(4 * np.pi / (0.87 * h**2)))
    rim_radius = np.sqrt(1 - cut**2)
    turn = 2 * np.pi * np.arange(n := int(2 * np.pi * rim_radius / h)) / n
    rim = np.stack([np.full(n, cut), rim_radius * np.cos(turn), rim_radius * np.sin(turn)], 1)
    points = np.concatenate([rim, ball[ball[:, 0] > cut + 0.5 * h]])
    faces = ConvexHull(points).simplices
    faces = faces[~(faces < n).all(1)]
    k = np.arange(m := int(np.pi * rim_radius**2 / (0.87 * h**2))) + 0.5
    r, turn = rim_radius * np.sqrt(k / m), np.pi * (1 + 5**0.5) * k
    flat = np.stack([r * np.cos(turn), r * np.sin(turn)], 1)[r < rim_radius - 0.6 * h]
    lid = Delaunay(np.concatenate([rim[:, 1:], flat])).simplices
    index = np.concatenate([np.arange(n), len(points) + np.arange(len(flat))])
    inside = np.concatenate([np.full((len(flat), 1), cut), flat], 1)
    return np.concatenate([points, inside]) * AXES, np.concatenate([faces, index[lid]])


class Body:
    """Quadratic tetrahedra of the organ with its tumour, with curved faces."""

    def __init__(self, edge, subdivisions, volume, bisections):
        points, faces = organ(edge)
        ball = pv.Icosphere(radius=RADIUS, center=CENTRE, nsub=subdivisions)
        faces = np.concatenate([faces, ball.faces.reshape(-1, 4)[:, 1:] + len(points)])
        points = np.concatenate([points, ball.points])
        mesher = tetgen.TetGen(points, np.ascontiguousarray(faces, np.int32))
        mesher.tetrahedralize(switches=f"pq1.3/12Ya{volume:g}Q")
        cells = mesher.grid.cells.reshape(-1, 5)[:, 1:]
        straight = sk.MeshTet(
            np.ascontiguousarray(mesher.grid.points.T, float),
            np.ascontiguousarray(cells.T.astype(np.int64)),
        )
        for _ in range(bisections):
            faces = straight.facets[:, straight.boundary_facets()]
            held = (np.abs(straight.p[0, faces] - CUT) < 1e-9).all(0)
            rim = np.intersect1d(faces[:, held], faces[:, ~held])
            straight = straight.refined(np.nonzero(np.isin(straight.t, rim).any(0))[0])
        middle = straight.p[:, straight.t].mean(1)
        self.in_tumour = np.linalg.norm(middle - CENTRE[:, None], axis=0) < RADIUS
        mesh = sk.MeshTet2.from_mesh(straight)
        self.nodes = mesh.dofs.element_dofs
        x = mesh.doflocs.copy()
        on_organ, on_ball = (self.of_facets(straight, mesh, kind) for kind in ("organ", "ball"))
        at_cut = np.abs(x[0] - CUT) < 1e-9
        # On the rim within its plane, else along the ray from the centre.
        scale = np.sqrt(np.sum((x / AXES[:, None]) ** 2, 0))
        rim = on_organ & at_cut
        around = np.sqrt(np.sum((x[1:] / AXES[1:, None]) ** 2, 0) / (1 - (CUT / AXES[0]) ** 2))
        x[1:, rim] /= around[rim]
        skin = on_organ & ~at_cut
        x[:, skin] /= scale[skin]
        arm = x - CENTRE[:, None]
        x[:, on_ball] = (CENTRE[:, None] + arm * RADIUS / np.linalg.norm(arm, axis=0))[:, on_ball]
        self.mesh = sk.MeshTet2(x, mesh.t)
        self.basis = sk.Basis(self.mesh, sk.ElementVector(sk.ElementTetP2()), intorder=4)
        self.free = np.setdiff1d(
            np.arange(self.basis.N),
            np.concatenate([3 * np.nonzero(at_cut)[0] + k for k in range(3)]),
        )
        scalar = sk.Basis(self.mesh, sk.ElementTetP2(), intorder=4)
        self.slopes = np.stack([np.asarray(shape[0].grad) for shape in scalar.basis])
        self.dx = np.asarray(self.basis.dx)
        self.dofs = (3 * self.nodes.T[:, :, None] + np.arange(3)).reshape(-1, 30)
        self.tree = cKDTree(x[:, self.nodes[:4]].mean(1).T)

    def of_facets(self, straight, mesh, kind):
        """Nodes on curved faces: of the surface but not of the cut, or between the materials."""
        neighbours = straight.f2t
        if kind == "ball":
            tumour = np.where(neighbours >= 0, self.in_tumour[neighbours], False)
            facets = np.nonzero((neighbours[1] >= 0) & (tumour[0] != tumour[1]))[0]
        else:
            facets = straight.boundary_facets()
            flat = (np.abs(straight.p[0, straight.facets[:, facets]] - CUT) < 1e-9).all(0)
            facets = facets[~flat]
        chosen = np.zeros(mesh.doflocs.shape[1], bool)
        chosen[straight.facets[:, facets]] = True
        pairs = np.sort(straight.facets[:, facets][[[0, 1, 0], [1, 2, 2]]].reshape(2, -1), 0)
        size = straight.nvertices
        edges = np.sort(straight.edges, 0)
        keys = edges[0].astype(np.int64) * size + edges[1]
        wanted = np.isin(keys, pairs[0].astype(np.int64) * size + pairs[1])
        chosen[size + np.nonzero(wanted)[0]] = True
        return chosen

    def weight(self, acceleration):
        """Nodal forces of the own weight."""
        return sk.asm(
            sk.LinearForm(lambda v, w: sum(DENSITY * a * v[k] for k, a in enumerate(acceleration))),
            self.basis,
        )

    def forces_and_stiffness(self, nu, u):
        """Inner forces and tangent of the neo-Hookean law, at u = 0 that of small strain."""
        factor = np.where(self.in_tumour, STIFFER, 1.0)[:, None]
        lam, mu = (modulus * factor for modulus in lame(YOUNG, nu))
        unit = np.eye(3)
        forces, blocks = np.zeros(self.basis.N), np.empty((len(factor), 30, 30))
        for first in range(0, len(factor), CHUNK):
            part = slice(first, first + CHUNK)
            slopes = self.slopes[:, :, part].transpose(2, 3, 0, 1)
            of_nodes = u[self.dofs[part]].reshape(-1, 1, 10, 3)
            f = unit + np.swapaxes(of_nodes, 2, 3) @ slopes
            it, ln_j = np.swapaxes(np.linalg.inv(f), 2, 3), np.log(np.linalg.det(f))
            volumetric, shear, dx = lam[part], mu[part], self.dx[part]
            stress = shear[..., None, None] * (f - it) + (volumetric * ln_j)[..., None, None] * it
            inner = np.einsum("eqaJ,eqiJ,eq->eai", slopes, stress, dx, optimize=True)
            np.add.at(forces, self.dofs[part], inner.reshape(-1, 30))
            # dP_iJ / dF_kL
            tangent = np.einsum("eq,ik,JL->eqiJkL", shear * np.ones_like(dx), unit, unit)
            tangent += np.einsum("eq,eqiL,eqkJ->eqiJkL", shear - volumetric * ln_j, it, it)
            tangent += np.einsum("eq,eqiJ,eqkL->eqiJkL", volumetric * np.ones_like(dx), it, it)
            wide = np.einsum("eqaJ,ik->eqiJak", slopes, unit).reshape(*dx.shape, 9, 30)
            right = tangent.reshape(*dx.shape, 9, 9) @ (wide * dx[..., None, None])
            blocks[part] = (np.swapaxes(wide, 2, 3) @ right).sum(1)
        rows = np.broadcast_to(self.dofs[:, :, None], blocks.shape)
        upper = rows <= np.swapaxes(rows, 1, 2)
        entries = (blocks[upper], (rows[upper], np.swapaxes(rows, 1, 2)[upper]))
        return forces, sp.coo_matrix(entries, shape=(self.basis.N,) * 2).tocsr()

    def solved(self, stiffness, loads, definite=True):
        """Displacements of the free nodes for the upper triangle of a stiffness."""
        matrix = stiffness[self.free][:, self.free]
        u = np.zeros_like(loads)
        u[self.free] = solve(matrix, loads[self.free], definite).reshape(u[self.free].shape)
        return u

    def linear(self, nu, loads):
        """Displacements in small strain for the nodal forces in columns."""
        return self.solved(self.forces_and_stiffness(nu, self.basis.zeros())[1], loads)

    def neo_hookean(self, nu, load):
        """Displacement in large strain."""
        u, free = self.basis.zeros(), self.free
        for share in STEPS:
            for _ in range(20):
                inner, stiffness = self.forces_and_stiffness(nu, u)
                residual = share * load - inner
                if np.linalg.norm(residual[free]) < 1e-7 * np.linalg.norm(load[free]):
                    break
                u += self.solved(stiffness, residual, definite=False)
            else:
                raise RuntimeError("Newton did not converge")
        return u

    def at(self, u, point):
        """Displacement and displacement gradient at a point, by the map of its tetrahedron."""
        element, best = sk.ElementTetP2(), None
        for cell in self.tree.query(point, 60)[1]:
            nodes = self.nodes[:, cell]
            x, local = self.mesh.doflocs[:, nodes], np.full((3, 1), 0.25)
            for _ in range(20):
                values = [element.lbasis(local, i) for i in range(10)]
                shape = np.array([v[0].item() for v in values])
                slopes = np.array([np.ravel(v[1]) for v in values])
                jacobian = x @ slopes
                local = local + np.linalg.solve(jacobian, point - x @ shape)[:, None]
            outside = -min(local.min(), 1 - local.sum())
            if best is None or outside < best[0]:
                of_nodes = np.stack([u[3 * nodes + k] for k in range(3)])
                gradient = of_nodes @ slopes @ np.linalg.inv(jacobian)
                best = outside, of_nodes @ shape, gradient
            if outside < 1e-9:
                break
        return best[1], best[2]


def hencky(gradient):
    """ln V of displacement gradients (3, 3, ...)."""
    f = np.moveaxis(gradient, (0, 1), (-2, -1)) + np.eye(3)
    squares, axes = np.linalg.eigh(f @ np.swapaxes(f, -1, -2))
    strain = (axes * (0.5 * np.log(squares))[..., None, :]) @ np.swapaxes(axes, -1, -2)
    return np.moveaxis(strain, (-2, -1), (0, 1))


def small(gradient):
    """sym grad u."""
    return 0.5 * (gradient + np.swapaxes(gradient, 0, 1))


def readings(body, u, strain_of):
    """Means over body and tumour, strains in the tumour (components xx, yy, zz, xy, yz, xz)."""
    field, dx = body.basis.interpolate(u), np.asarray(body.basis.dx)
    strain = strain_of(np.asarray(field.grad))
    inside = body.in_tumour
    principal = np.linalg.eigvalsh(np.moveaxis(strain, (0, 1), (-2, -1)))

    def mean(values, cells):
        return float((values * dx)[cells].sum() / dx[cells].sum())

    everywhere = np.ones_like(inside)
    components = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]
    return {
        "mean_displacement": [mean(np.asarray(field)[k], everywhere) for k in range(3)],
        "tumour_mean_displacement": [mean(np.asarray(field)[k], inside) for k in range(3)],
        "tumour_mean_strain": [mean(strain[i, j], inside) for i, j in components],
        "tumour_mean_largest_principal_strain": mean(principal[..., 2], inside),
        "tumour_peak_principal_strain": float(principal[inside][..., 2].max()),
        "tumour_least_principal_strain": float(principal[inside][..., 0].min()),
    }


def main():
    results, points, line = {"meshes": [], "cases": {}}, [], []
    for law, loads in LOADS.items():
        strain_of = small if law == "kelvin-voigt" else hencky
        for number in RUNS[law]:
            body, start = Body(*MESHES[number]), time.time()
            if number == len(results["meshes"]):
                tumour = float(body.dx[body.in_tumour].sum())
                sizes = {"tetrahedra": int(body.mesh.nelements), "unknowns": len(body.free)}
                sizes |= {"volume": float(body.dx.sum()), "tumour_volume": tumour}
                results["meshes"].append(sizes)
            for nu in RATIOS:
                forces = {name: body.weight(a) for name, a in loads.items()}
                if law == "kelvin-voigt":
                    columns = body.linear(nu, np.stack(list(forces.values()), 1)).T
                else:
                    columns = [body.neo_hookean(nu, force) for force in forces.values()]
                for name, u in zip(forces, columns, strict=True):
                    case = f"{law}, nu {nu}, {name}"
                    here = readings(body, u, strain_of)
                    here["compliance"] = float(forces[name] @ u)
                    results["cases"].setdefault(case, []).append(here)
                    at = {key: body.at(u, np.array(x))[0] for key, x in POINTS.items()}
                    here["points"] = {key: value.tolist() for key, value in at.items()}
                    print(f"{case} ({time.time() - start:.0f} s): {here}", flush=True)
                    if number != RUNS[law][-1]:
                        continue
                    points += [[law, nu, name, key, *POINTS[key], *at[key]] for key in POINTS]
                    line += [[law, nu, name, *row] for row in along_the_line(body, u, strain_of)]
                write(results, points, line)


def along_the_line(body, u, strain_of):
    """Displacement and strain along x through the centre of the tumour."""
    for x in np.linspace(-0.05, 0.075, 126):
        where = np.array([x, *CENTRE[1:]])
        if np.sum((where / AXES) ** 2) < 1.0:
            shift, gradient = body.at(u, where)
            e = strain_of(gradient)
            yield [x, *shift, e[0, 0], e[1, 1], e[2, 2], e[0, 2]]


def write(results, points, line):
    """The files of what is known so far."""
    (HERE / "reference.json").write_text(json.dumps(results, indent=1) + "\n")
    for file, header, rows in (
        ("points.csv", "law,nu,load,point,x,y,z,u_x,u_y,u_z", points),
        ("line.csv", "law,nu,load,x,u_x,u_y,u_z,e_xx,e_yy,e_zz,e_xz", line),
    ):
        with (HERE / file).open("w", newline="") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(header.split(","))
            writer.writerows([[f"{v:.6g}" if isinstance(v, float) else v for v in r] for r in rows])


if __name__ == "__main__":
    main()
