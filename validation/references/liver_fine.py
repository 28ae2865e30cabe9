"""The liver of liver.py on meshes too large for a direct solver: P2 elements.

Conjugate gradients with an additive two-level preconditioner: the diagonal, and a direct solve of
the linear (P1) elements on the same mesh. Compliances in J; they bound the exact ones from below.

| mesh | unknowns | patch, nu = .3 | u(c), mm | patch, nu = .45 | weight x, nu = .3 |
|---|---|---|---|---|---|
| pq10 | 142764 | 7.313204e-4 | (.4640, -1.4247, -1.3384) | | |
| pq10, all in 8 | 974607 | 7.364677e-4 | (.4675, -1.4334, -1.3495) | | 7.298459e-2 |
| pq10, edge 4 | 541512 | 7.374387e-4 | (.4689, -1.4346, -1.3493) | | |
| pq2, edge 2 | 534324 | 7.379662e-4 | (.4689, -1.4357, -1.3517) | 7.363255e-4 | |

u(c) at nu = .45 on pq2, edge 2: (.4820, -1.4398, -1.3732) mm.
"""

import numpy as np
import scipy.sparse as sp
import skfem as sk
from liver import PEAK, WEIGHT, YOUNG, Liver, vector
from pfem import lame
from pypardiso import PyPardisoSolver


class FineLiver:
    """Scalar P2 matrices, loads (patch; weight x, y, z) and the P1 prolongation on one mesh."""

    def __init__(self, switches: str, edge: int, halvings: int):
        body = Liver(switches, 0, edge)
        c, r, floor = body.c, body.r, body.clamp_height + 1e-7
        mesh = body.mesh.refined(halvings) if halvings else body.mesh
        del body
        basis = sk.Basis(mesh, sk.ElementTetP2(), intorder=2)
        facets = sk.FacetBasis(mesh, basis.elem, facets=mesh.boundary_facets(), intorder=6)

        def patch(v, w):
            d2 = sum((w.x[i] - c[i]) ** 2 for i in range(3))
            return -PEAK * np.exp(-d2 / r**2) * (w.n[1] > 0) * v

        def product(i, j):  # test function derived in i, trial function in j
            return sk.asm(sk.BilinearForm(lambda u, v, w: u.grad[j] * v.grad[i]), basis).tocsr()

        upper = {(i, j): product(i, j) for i in range(3) for j in range(i, 3)}
        lower = {(j, i): m.T.tocsr() for (i, j), m in upper.items() if i != j}
        self.products = {**upper, **lower}
        self.n = n = basis.N
        self.loads = np.zeros((3 * n, 4))
        self.loads[n : 2 * n, 0] = sk.asm(sk.LinearForm(patch), facets)
        for k in range(3):
            weight = sk.asm(sk.LinearForm(lambda v, w: WEIGHT * v), basis)
            self.loads[k * n : (k + 1) * n, k + 1] = weight
        self.free = np.nonzero(np.tile(basis.doflocs[1] > floor, 3))[0]
        vertex, edge_dofs, ends = basis.nodal_dofs[0], basis.edge_dofs[0], mesh.edges
        ne, nv = len(edge_dofs), mesh.nvertices
        rows = np.concatenate([vertex, edge_dofs, edge_dofs])
        columns = np.concatenate([np.arange(nv), ends[0], ends[1]])
        values = np.concatenate([np.ones(nv), np.full(2 * ne, 0.5)])
        linear = sp.csr_matrix((values, (rows, columns)), (n, nv))[:, mesh.p[1] > floor]
        self.linear = sp.block_diag([linear] * 3, format="csr")[self.free]
        at = vertex[np.argmin(np.linalg.norm(mesh.p - c[:, None], axis=0))]
        self.at_c = np.array([at, n + at, 2 * n + at])

    def solve(self, nu: float, loads=(0,), tolerance: float = 2e-5):
        """Print compliance and u(c) of the loads with these numbers."""
        lam, mu = lame(YOUNG, nu)
        trace = sum(mu * self.products[k, k] for k in range(3))
        blocks = [
            [mu * self.products[j, i] + lam * self.products[i, j] for j in range(3)]
            for i in range(3)
        ]
        for k in range(3):
            blocks[k][k] = blocks[k][k] + trace
        matrix = sp.bmat(blocks, format="csr")[self.free][:, self.free]
        coarse = sp.triu(self.linear.T @ matrix @ self.linear, format="csr")
        coarse.sort_indices()
        direct = PyPardisoSolver(mtype=2)
        direct.factorize(coarse)
        diagonal = matrix.diagonal()

        def precondition(x):
            return x / diagonal + self.linear @ direct.solve(coarse, self.linear.T @ x)

        operator = sp.linalg.LinearOperator(matrix.shape, precondition)
        for k in loads:
            f = self.loads[self.free, k]
            x, info = sp.linalg.cg(matrix, f, rtol=tolerance, maxiter=1000, M=operator)
            u = np.zeros(3 * self.n)
            u[self.free] = x
            name = ("patch", "weight x", "weight y", "weight z")[k]
            print(
                f"  {len(f)} unknowns, nu {nu}, {name}: compliance {f @ x:.6e} J, "
                f"u(c) {vector(1e3 * u[self.at_c])} mm, cg {info}",
                flush=True,
            )
        direct.free_memory(everything=True)


if __name__ == "__main__":  # up to 5 GB of memory
    for mesh in (("pq10", 0, 0), ("pq10", 4, 0), ("pq2", 2, 0), ("pq10", 0, 1)):
        print("switches, edge, halvings:", *mesh, flush=True)
        body = FineLiver(*mesh)
        body.solve(0.3)
        if mesh[0] == "pq2":
            body.solve(0.45)
