"""Finite-element reference: the clamped unit cube under tension, up to nearly incompressible.

Unit cube, E = 1, u = 0 on z = 0, uniform traction 1 in +z on z = 1, other faces free, small strain.
Quantity: E times the mean u_z of the top face, which is the compliance (work of the load).

How: a quarter of the cube (two symmetry planes), elements Q_p on a tensor grid whose layers shrink
by a ratio towards the clamped face and towards the free side faces, where the clamped edge is
singular; displacement elements for nu = .3, mixed Q_p / Q_(p-2) for the others (see pfem.py).

| mesh (degree, layers by ratio, unknowns) | nu = .3 | nu = .45 | nu = .49 | nu = .499 |
|---|---|---|---|---|
| 3, 4 by .25, 13248 | .9705293 | .9279719 | .9119521 | .9080031 |
| 4, 4 by .25, 30744 | .9705450 | .9277680 | .9116703 | .9077004 |
| 5, 4 by .25, 59280 | .9705463 | .9277584 | .9116568 | .9076858 |
| 6, 3 by .15, 54750 | .9705463 | .9277585 | .9116569 | .9076859 |

Displacement elements bound the compliance from below: .9277484 (nu = .45) and .9116358 (nu = .49)
with degree 5, 3 layers by .15; so values rounded to .9276 and .9115 (and .9075) are slightly too
stiff.
"""

import time

import numpy as np
from pfem import Box, Line, geometric


def compliance(
    poisson_ratio: float, p: int, layers: int, ratio: float, mixed: bool
) -> tuple[float, int]:
    """Work of the unit load on the whole cube, and the number of unknowns."""
    side = Line([0.0, *geometric(0.5, 0.0, layers, ratio)], p)
    height = Line([1.0, 0.5, *geometric(0.0, 0.5, layers, ratio)], p)
    body = Box([side, side, height], 1.0, poisson_ratio, mixed)
    zero = np.zeros(body.shape)
    top = np.einsum("i,j,k->ijk", side.total(), side.total(), height.at(1.0))
    clamp = height.at(0.0)[None, None, :] > 0
    middle = side.at(0.0) > 0
    fixed = [clamp | middle[:, None, None], clamp | middle[None, :, None], clamp]
    work, n = body.compliances([[zero, zero, top]], fixed)
    return 4 * float(work[0, 0]), n


if __name__ == "__main__":
    for nu in (0.3, 0.45, 0.49, 0.499):
        for p, layers, ratio in ((3, 4, 0.25), (4, 4, 0.25), (5, 4, 0.25), (6, 3, 0.15)):
            start = time.time()
            value, n = compliance(nu, p, layers, ratio, nu > 0.4)
            print(
                f"nu {nu}: degree {p}, {layers} layers by {ratio}, {n} unknowns: "
                f"{value:.7f} ({time.time() - start:.0f} s)",
                flush=True,
            )
