"""Finite-element reference: a clamped beam under an end shear and under its own weight.

Beam 1 x 1 x 4 (z along the beam), E = 1, u = 0 on z = 0, other faces free, small strain. (a)
Uniform traction 1 in x on the end z = 4: compliance = mean u_x of the end. (b) Body force 1 in x
(nu = .3): compliance int f.u dV, and the mean u_x of the end under it (by reciprocity the work of
the load (a) in this field).

How: a quarter of the beam (symmetric in y, antisymmetric in x), elements Q_p on a tensor grid
whose layers shrink towards the clamped face, the free side faces and (fewer) the end face;
displacement elements for nu = .3, mixed Q_p / Q_(p-2) for the others (see pfem.py).

| degree, layers, unknowns | (a) nu = .3 | .45 | .49 | .499 | (b) compliance | (b) u_x, end |
|---|---|---|---|---|---|---|
| 3, 3 + 1, 14070 | 264.12018 | 259.72910 | 257.98321 | 257.54927 | 663.75151 | 400.46400 |
| 4, 3 + 1, 32680 | 264.12871 | 259.68901 | 257.92674 | 257.48832 | 663.78749 | 400.48072 |
| 5, 3 + 1, 63050 | 264.12965 | 259.68564 | 257.92183 | 257.48298 | 663.79128 | 400.48254 |
| 4, 4 + 2, 60528 | 264.12906 | | | 257.48911 | 663.78875 | 400.48132 |

Earlier values for nu = .3, 264.05 and 400.3, are .03 % and .05 % stiffer; 400.3 is the mean
displacement of the end under the own weight and not the compliance.
"""

import time

import numpy as np
from pfem import Box, Line, geometric

LENGTH = 4.0


def compliances(
    poisson_ratio: float,
    p: int,
    layers: int,
    ratio: float,
    end_layers: int,
    mixed: bool,
    weight: bool,
):
    """Works of the end shear and (if asked for) the own weight in each other's fields, unknowns."""
    side = Line([0.0, *geometric(0.5, 0.0, layers, ratio)], p)
    grid = [
        *geometric(0.0, 0.5, layers, ratio),
        1.0,
        2.0,
        3.0,
        *geometric(LENGTH, 3.5, end_layers, ratio),
    ]
    axis = Line(grid, p)
    total = [line.total() for line in (side, side, axis)]
    loads = [np.einsum("i,j,k->ijk", *total[:2], axis.at(LENGTH))]
    if weight:
        loads.append(np.einsum("i,j,k->ijk", *total))
    body = Box([side, side, axis], 1.0, poisson_ratio, mixed)
    zero = np.zeros(body.shape)
    clamp = axis.at(0.0)[None, None, :] > 0
    x0, y0 = side.at(0.0)[:, None, None] > 0, side.at(0.0)[None, :, None] > 0
    # x = 0: antisymmetric, u_y = u_z = 0; y = 0: symmetric, u_y = 0
    works, n = body.compliances(
        [[f, zero, zero] for f in loads], [clamp, clamp | x0 | y0, clamp | x0]
    )
    return 4 * works, n


if __name__ == "__main__":
    for nu in (0.3, 0.45, 0.49, 0.499):
        runs = [(3, 3, 1, 0.2), (4, 3, 1, 0.2), (5, 3, 1, 0.2)]
        if nu in (0.3, 0.499):
            runs.append((4, 4, 2, 0.2))  # more layers
        for p, layers, end_layers, ratio in runs:
            start = time.time()
            works, n = compliances(nu, p, layers, ratio, end_layers, nu > 0.4, nu == 0.3)
            text = f"shear compliance {works[0, 0]:.5f}"
            if len(works) > 1:
                text += f", weight compliance {works[1, 1]:.5f}"
                text += f", weight, mean u_x of the end {works[0, 1]:.5f}"
            print(
                f"nu {nu}: degree {p}, {layers} + {end_layers} layers by {ratio}, "
                f"{n} unknowns: {text}"
                f" ({time.time() - start:.0f} s)",
                flush=True,
            )
