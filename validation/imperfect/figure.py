"""Makes figure.png from the section that `rsph validate imperfect` left in out/validation."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).parent
SECTION = HERE.parents[1] / "out" / "validation" / "imperfect_liver.csv"


def main() -> None:
    table = np.genfromtxt(SECTION, delimiter=",", names=True)
    x, y = np.unique(table["x"]), np.unique(table["y"])
    fields = [table[name].reshape(len(y), len(x)) for name in table.dtype.names[2:]]
    titles = ["all triangles as they are", "parts that lie on each other counted once"]
    figure, axes = plt.subplots(1, 2, figsize=(10.5, 3.9), sharey=True, layout="constrained")
    for axis, field, title in zip(axes, fields, titles, strict=True):
        shown = axis.pcolormesh(
            100 * x, 100 * y, field, cmap="RdBu_r", vmin=-3.5, vmax=3.5, shading="nearest"
        )
        axis.contour(100 * x, 100 * y, field, levels=[0.5], colors="k", linewidths=0.8)
        axis.contour(
            100 * x, 100 * y, field, levels=[0.25], colors="0.4", linewidths=0.6, linestyles=":"
        )
        axis.set(title=title, xlabel="x (cm)", aspect="equal")
    axes[0].set_ylabel("y (cm)")
    figure.colorbar(shown, ax=axes, label="winding number", shrink=0.85)
    figure.savefig(HERE / "figure.png", dpi=110)


if __name__ == "__main__":
    main()
