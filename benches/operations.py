"""Vector operations of the two kernel sums, counted from their passes (crates/rsph-core/src/ops).

An operation is an addition, multiplication or multiply-add of one lane; each takes one issue slot.
"""

# Largest |o|^2 of the offsets by number of neighbours.
CUTS = {122: 9, 26: 3}
# At each particle between the sums: stress of a linear solid and T (dynamics/solid/linear.rs).
POINTWISE = 12 + 27 + 6 + 12 + 6 + 2 + 27 + 18 + 6
# Bytes of a right-hand side that come from or go to memory, if caches keep what a sweep needs:
# spread 56 + 24, gradient 24 + 88 + 96, adjoint 72 + 24, forces 112 + 24, and 48 to copy v; results
# are read before they are written (192).
BYTES = 80 + 208 + 96 + 136 + 48 + 192


def squares(cut: int) -> list[int]:
    """All m = j^2 + k^2 that a row within the stencil has."""
    return sorted({j * j + k * k for j in range(10) for k in range(10) if j * j + k * k <= cut})


def reach(cut: int) -> int:
    """Largest offset along an axis."""
    return int(cut**0.5)


def taps(cut: int, m: int, odd: bool) -> int:
    """Operations of the sum along x of a row at m."""
    inside = sum(m + i * i <= cut for i in range(1, reach(cut) + 1))
    return inside if odd else 1 + inside


def gradient(cut: int) -> int:
    """Operations a particle of the sums w q (x) X and w q."""
    r = reach(cut)
    along_x = 3 * r + sum(taps(cut, m, False) for m in squares(cut))
    along_x += sum(taps(cut, m, True) for m in squares(cut) if m < cut)
    rows = [j * j + k * k for j in range(-r, r + 1) for k in range(r + 1)]
    along_y = sum(2 * (m <= cut) + (m < cut) for m in rows)
    along_z = sum(2 + 2 * (k * k < cut) for k in range(-r, r + 1))
    return 3 * (along_x + along_y + along_z)


def adjoint(cut: int) -> int:
    """Operations a particle of the sum w T X."""
    r = reach(cut)
    along_x = 2 * r + sum(taps(cut, m, True) for m in squares(cut) if m < cut)
    along_x += 2 * (r + sum(taps(cut, m, False) for m in squares(cut) if m > 0))
    rows = [(j, k, j * j + k * k) for j in range(-r, r + 1) for k in range(r + 1)]
    along_y = sum((m < cut) + (j != 0 and m <= cut) + (k != 0 and m <= cut) for j, k, m in rows)
    along_z = sum(1 + (k != 0) for k in range(-r, r + 1))
    return 3 * (along_x + along_y + along_z)


def right_hand_side(neighbours: int) -> int:
    """Operations a particle of a whole right-hand side (spreading and adding forces: 20)."""
    cut = CUTS[neighbours]
    return gradient(cut) + adjoint(cut) + POINTWISE + 20


def plain(neighbours: int) -> int:
    """Operations of the same sums taken neighbour by neighbour: 12 and 9 multiply-adds each."""
    return 21 * neighbours + POINTWISE + 20


if __name__ == "__main__":
    for count, largest in CUTS.items():
        print(f"{count} neighbours: gradient {gradient(largest)}, adjoint {adjoint(largest)},")
        print(
            f"  right-hand side {right_hand_side(count)} (neighbour by neighbour {plain(count)}),"
        )
        print(f"  {BYTES} bytes from and to memory")
