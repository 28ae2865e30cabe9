"""Small finite-element kit of the reference scripts in this folder (not a case by itself).

Tensor grids with Lagrange elements of any degree p (Gauss-Lobatto nodes). On a tensor grid every
block of the stiffness matrix is a sum of Kronecker products of one-dimensional matrices, so `Line`
holds all there is to integrate. Meshes are graded geometrically towards singular edges.

Nearly incompressible materials use a mixed displacement-pressure form, Q_p / Q_(p-2) with a
discontinuous pressure (inf-sup stable, also on such edge-graded tensor grids). The pressure is
eliminated element by element: the volumetric term is lambda |P div u|^2 with the L2 projection P
on the pressure space, and the matrix stays symmetric positive definite.

Needs numpy, scipy and pypardiso (the sparse Cholesky factorisation of MKL).
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

import numpy as np
import scipy.sparse as sp
from pypardiso import PyPardisoSolver


def lame(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """First Lame parameter and shear modulus."""
    lam = young_modulus * poisson_ratio / (1 + poisson_ratio) / (1 - 2 * poisson_ratio)
    return lam, young_modulus / 2 / (1 + poisson_ratio)


def solve(matrix, loads, definite: bool = True):
    """Solve a symmetric system (definite or not) for one or more right-hand sides."""
    solver = PyPardisoSolver(mtype=2 if definite else -2)
    if not definite:
        solver.set_iparm(10, 1)  # scaling and
        solver.set_iparm(13, 1)  # weighted matching for saddle points
    upper = sp.triu(matrix, format="csr")
    upper.sort_indices()
    solver.factorize(upper)
    solution = solver.solve(upper, np.ascontiguousarray(loads))
    solver.free_memory(everything=True)
    return solution


def geometric(edge: float, far: float, layers: int, ratio: float = 0.15) -> list[float]:
    """Grid points from `far` to `edge`, both included, shrinking by `ratio` towards `edge`."""
    return [far] + [edge + (far - edge) * ratio**k for k in range(1, layers + 1)] + [edge]


def lobatto(p: int) -> np.ndarray:
    """Gauss-Lobatto nodes of degree p on [-1, 1]."""
    inner = np.polynomial.legendre.Legendre.basis(p).deriv().roots()
    return np.concatenate([[-1.0], np.sort(inner.real), [1.0]])


def lagrange(p: int, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and derivatives (len(s), p + 1) of the Lagrange polynomials on these nodes."""
    leg = np.polynomial.legendre
    coefficients = np.linalg.inv(
        leg.legvander(lobatto(p), p)
    )  # nodal values -> Legendre coefficients
    derivative = leg.legvander(s, p - 1) @ leg.legder(np.eye(p + 1), axis=0)
    return leg.legvander(s, p) @ coefficients, derivative @ coefficients


class Line:
    """Continuous elements of degree p on the grid `breaks`, quadrature, broken pressure space.

    `weight(x)` multiplies the measure (the radius, for axisymmetric problems).
    """

    def __init__(self, breaks, p: int, weight=lambda x: 1.0 + 0.0 * x):
        breaks = np.unique(np.round(np.asarray(breaks, float), 14))
        ne, (s, ws) = len(breaks) - 1, np.polynomial.legendre.leggauss(p + 2)
        value, slope = lagrange(p, s)
        h = np.diff(breaks)
        self.p, self.breaks, self.n = p, breaks, ne * p + 1
        self.points = (breaks[:-1, None] + h[:, None] * (s + 1) / 2).ravel()
        self.nodes = np.append(
            (breaks[:-1, None] + h[:, None] * (lobatto(p)[:-1] + 1) / 2).ravel(), breaks[-1]
        )
        self.weights = (h[:, None] / 2 * ws).ravel() * weight(self.points)
        rows = np.repeat(np.arange(ne * len(s)).reshape(ne, -1, 1), p + 1, 2).ravel()
        cols = np.broadcast_to(
            (np.arange(ne) * p)[:, None, None] + np.arange(p + 1), (ne, len(s), p + 1)
        ).ravel()

        def gather(a):
            return sp.csr_matrix((a.ravel(), (rows, cols)), (ne * len(s), self.n))

        self.value = gather(np.broadcast_to(value, (ne, *value.shape)))
        self.slope = gather(slope[None] * (2 / h)[:, None, None])
        # pressure: degree p - 2 in every element, orthonormal in the weighted measure
        psi = np.polynomial.legendre.legvander(s, max(p - 2, 0))
        blocks = []
        for w in self.weights.reshape(ne, -1):
            blocks.append(psi @ np.linalg.inv(np.linalg.cholesky(psi.T @ (w[:, None] * psi))).T)
        self.psi = sp.block_diag(blocks, format="csr")

    def integral(self, left, right):
        """Matrix of the integrals of left_i right_j."""
        return (left.T @ sp.diags(self.weights) @ right).tocsr()

    def projected(self, left, right):
        """The same with both functions projected on the pressure space."""
        return (self.integral(self.psi, left).T @ self.integral(self.psi, right)).tocsr()

    def at(self, x: float) -> np.ndarray:
        """Unit vector of the node at x."""
        return (np.abs(self.nodes - x) < 1e-12).astype(float)

    def total(self) -> np.ndarray:
        """Integrals of the basis functions."""
        return self.value.T @ self.weights


class Box:
    """Isotropic elastic body on the tensor grid of three lines; unknown (component, ix, iy, iz)."""

    def __init__(self, lines, young_modulus: float, poisson_ratio: float, mixed: bool):
        lam, mu = lame(young_modulus, poisson_ratio)
        self.lines, self.shape = lines, tuple(line.n for line in lines)
        functions = [(line.value, line.slope) for line in lines]

        def product(test, trial, projected=False):
            """Kronecker product; test, trial: the directions in which the factors are derived."""
            factors = []
            for d, line in enumerate(lines):
                make = line.projected if projected else line.integral
                factors.append(make(functions[d][d == test], functions[d][d == trial]))
            return sp.kron(sp.kron(factors[0], factors[1]), factors[2], format="csr")

        gradient = sum(mu * product(k, k) for k in range(3))
        self.blocks = {}
        for i in range(3):
            for j in range(i, 3):
                block = mu * product(j, i) + lam * product(i, j, mixed)
                self.blocks[i, j] = (block + gradient if i == j else block).tocsr()

    def compliances(self, loads, fixed) -> tuple[np.ndarray, int]:
        """Works of the loads (three arrays of nodal forces each) in each other's fields, unknowns.

        `fixed[i]` is the boolean array of the nodes where component i is zero.
        """
        free = [np.nonzero(~np.broadcast_to(f, self.shape).ravel())[0] for f in fixed]
        upper = [[sp.csr_matrix((len(free[i]), len(free[j]))) for j in range(3)] for i in range(3)]
        for (i, j), block in self.blocks.items():
            block = block[free[i]][:, free[j]]
            upper[i][j] = sp.triu(block) if i == j else block
        self.blocks.clear()
        matrix = sp.bmat(upper, format="csr")
        del upper
        f = np.stack(
            [np.concatenate([load[i].ravel()[free[i]] for i in range(3)]) for load in loads], 1
        )
        u = solve(matrix, f)
        return f.T @ u.reshape(f.shape), len(f)
