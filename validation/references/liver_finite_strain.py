"""Finite-element reference: the liver of `liver.py` hanging by its cut, neo-Hookean.

E = 5 kPa, own weight 9810 N/m^3 along +y: strains of 20 % over much of it, 40 % at their worst.
Energy mu/2 (F:F - 3) - mu ln J + lambda/2 (ln J)^2; quadratic tetrahedra for nu = .3, Taylor-Hood
P2/P1 with the pressure lambda ln J as an unknown for .3, .45 and .49. Newton on four load steps.
Prints int f.u dV over the total force: the mean displacement along y in mm.

    python liver_finite_strain.py pq10          # or pq4, pq2
"""

import sys
import time

import numpy as np
import scipy.sparse as sp
import skfem as sk
from liver import Liver
from pfem import lame, solve
from skfem.helpers import ddot, det, grad, inv, mul, transpose

YOUNG = 5e3
STEPS = (0.25, 0.5, 0.75, 1.0)


def kinematics(w):
    f = w["u"].grad + np.eye(3)[:, :, None, None]
    return f, transpose(inv(f)), det(f)


def displacement(body: Liver, load, nu: float):
    lam, mu = lame(YOUNG, nu)

    @sk.LinearForm
    def internal(v, w):
        f, it, j = kinematics(w)
        return ddot(mu * (f - it) + lam * np.log(j) * it, grad(v))

    @sk.BilinearForm
    def stiffness(du, v, w):
        _, it, j = kinematics(w)
        df = grad(du)
        turned = mul(it, mul(transpose(df), it))
        return ddot(mu * (df + turned) + lam * (ddot(it, df) * it - np.log(j) * turned), grad(v))

    u, free = body.basis.zeros(), body.free
    for share in STEPS:
        for _ in range(20):
            field = body.basis.interpolate(u)
            residual = share * load - internal.assemble(body.basis, u=field)
            if np.linalg.norm(residual[free]) < 1e-6 * np.linalg.norm(load[free]):
                break
            matrix = stiffness.assemble(body.basis, u=field).tocsr()[free][:, free]
            u[free] += solve(matrix, residual[free], definite=False).ravel()
        else:
            raise RuntimeError("Newton did not converge")
    return u


def displacement_mixed(body: Liver, load, nu: float):
    lam, mu = lame(YOUNG, nu)
    basis, pressure = body.basis, body.basis.with_element(sk.ElementTetP1())

    @sk.LinearForm
    def internal(v, w):
        f, it, _ = kinematics(w)
        return ddot(mu * (f - it) + w["p"] * it, grad(v))

    @sk.LinearForm
    def constraint(q, w):
        _, _, j = kinematics(w)
        return (np.log(j) - w["p"] / lam) * q

    @sk.BilinearForm
    def uu(du, v, w):
        _, it, _ = kinematics(w)
        df = grad(du)
        turned = mul(it, mul(transpose(df), it))
        return ddot(mu * (df + turned) - w["p"] * turned, grad(v))

    @sk.BilinearForm
    def up(dp, v, w):
        _, it, _ = kinematics(w)
        return dp * ddot(it, grad(v))

    mass = sk.asm(sk.BilinearForm(lambda p, q, w: -p * q / lam), pressure)
    n = basis.N
    free = np.concatenate([body.free, n + np.arange(pressure.N)])
    u, p = basis.zeros(), pressure.zeros()
    for share in STEPS:
        for _ in range(20):
            fields = {"u": basis.interpolate(u), "p": pressure.interpolate(p)}
            residual = np.concatenate(
                [
                    share * load - internal.assemble(basis, **fields),
                    -constraint.assemble(pressure, **fields),
                ]
            )
            if np.linalg.norm(residual[free]) < 1e-6 * np.linalg.norm(load[body.free]):
                break
            coupling = up.assemble(pressure, basis, **fields)
            matrix = sp.bmat(
                [[uu.assemble(basis, **fields), coupling], [coupling.T, mass]], format="csr"
            )
            step = np.zeros(n + pressure.N)
            step[free] = solve(matrix[free][:, free], residual[free], definite=False).ravel()
            u, p = u + step[:n], p + step[n:]
        else:
            raise RuntimeError("Newton did not converge")
    return u


def main(switches: str):
    start = time.time()
    body = Liver(switches)
    load = body.weight(1)
    total = 9810 * body.volume

    def report(name, nu, u):
        mean, spent = 1e3 * load @ u / total, time.time() - start
        print(f"{switches} {name} nu {nu}: mean u_y {mean:.4f} mm ({spent:.0f} s)", flush=True)

    report("P2", 0.3, displacement(body, load, 0.3))
    for nu in (0.49, 0.45, 0.3):
        report("P2/P1", nu, displacement_mixed(body, load, nu))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "pq10")
