"""Draws figure.png, after Fig. 4 of the paper, from the curves of `rsph validate fsi_1d`.

python validation/fsi_1d/figure.py out/validation/fsi_1d.csv
"""

import csv
import sys
from collections import defaultdict
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
TIMES = {"0": "0", "0.5": "0.5", "1": "1.0", "2": "2.0"}
STYLES = {"fluid": ("b--", 1.4), "solid": ("b-", 1.4), "ALE": ("r-.", 1.0)}
LABELS = {"fluid": "particles, fluid", "solid": "particles, solid", "ALE": "ALE, advective"}


def main(curves: str) -> None:
    points: dict[tuple[str, str], list[tuple[float, float]]] = defaultdict(list)
    with open(curves, newline="") as file:
        for name, x, u in list(csv.reader(file))[1:]:
            time, part = name.removeprefix("t = ").split(", ")
            points[time, part].append((float(x), float(u)))
    figure, axes = plt.subplots(
        2, 2, figsize=(9, 6), sharex=True, sharey=True, layout="constrained"
    )
    for ax, (time, file) in zip(axes.flat, TIMES.items(), strict=True):
        with open(HERE / "reference" / f"ref_t{file}.csv", newline="") as rows:
            exact = [(float(r["x"]), float(r["u"])) for r in csv.DictReader(rows)]
        ax.plot(*zip(*exact, strict=True), color="0.75", lw=3, label="reference")
        for part, (style, width) in STYLES.items():
            ax.plot(*zip(*points[time, part], strict=True), style, lw=width, label=LABELS[part])
        ax.set_title(f"t = {time}")
    axes[0, 1].legend(fontsize=8)
    for ax in axes[1]:
        ax.set_xlabel("x")
    for ax in axes[:, 0]:
        ax.set_ylabel("velocity")
    figure.savefig(HERE / "figure.png", dpi=80)


if __name__ == "__main__":
    main(sys.argv[1])
