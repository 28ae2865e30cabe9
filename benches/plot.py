#!/usr/bin/env python3
"""From benches/results.json (benches/measure.py) to the tables and plots of the documents.

Fills what stands between `<!-- results: NAME -->` and `<!-- end -->` in docs/performance.md, and
draws docs/images/roofline.png and docs/images/growth.png. What has not been measured stays as it
is. Needs matplotlib.
"""

import json
import re
import sys
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import operations
import tables
from matplotlib.axes import Axes

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
DOCUMENT = ROOT / "docs" / "performance.md"
# Told apart without colours: by lines, and by filled and open marks.
BLUE, ORANGE = "#1f4e79", "#d98200"
SIZE = {"dpi": 110}


def roofline(results: dict) -> None:
    """Rate against operations per byte, under the machine's roof."""
    lim = results["limits"]["found"]
    figure, axes = plt.subplots(figsize=(6.4, 4.2))
    for key, style in [("all", "k-"), ("one", "k--")]:
        bandwidth, peak = lim[f"triad_gb_{key}"], lim[f"gfma_{key}"]
        intensity = [0.05, peak / bandwidth, 20]
        label = "one thread" if key == "one" else f"{lim['threads']} threads"
        roof = [min(peak, bandwidth * x) for x in intensity]
        axes.loglog(intensity, roof, style, lw=1.2, label=f"roof, {label}")
    bodies = tables.by_body(results["pieces"]["found"])
    marks = {("cube", 20): "v", ("cube", 37): "o", ("cube", 58): "s", ("liver", 50_000): "^"}
    for body, mark in marks.items():
        name = "50k liver" if body[0] == "liver" else f"{body[1]}³ cube"
        for nb, colour in [(122, BLUE), (26, ORANGE)]:
            count = operations.right_hand_side(nb)
            for rate, fill in zip(
                bodies[body][f"right_hand_side_{nb}"], ["none", colour], strict=True
            ):
                label = name if nb == 122 and fill == colour else None
                place = count / operations.BYTES
                axes.plot(place, rate * count / 1e9, mark, mec=colour, mfc=fill, ls="", label=label)
    for nb, side in [(122, "left"), (26, "right")]:
        place = operations.right_hand_side(nb) / operations.BYTES
        axes.annotate(f"{nb} neighbours", (place, 2.4), fontsize=8, ha=side)
    axes.set_xlim(0.1, 20)
    axes.set_ylim(2, 200)
    axes.set_xlabel("operations per byte from and to memory")
    axes.set_ylabel("10⁹ operations / s")
    axes.set_title("Right-hand sides under the roof (open marks: one thread)", fontsize=10)
    axes.legend(fontsize=7, loc="lower right")
    axes.grid(alpha=0.3, which="both")
    figure.tight_layout()
    figure.savefig(IMAGES / "roofline.png", **SIZE)


def growth(results: dict) -> None:
    """Time and memory a particle against the number of particles."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.6))
    lines = {122: (BLUE, "o"), 26: (ORANGE, "s")}
    styles = [("--", "none", "1 thread"), ("-", None, f"{results['growth']['threads']} threads")]
    found = tables.growth_rows(results)
    for pool, (line, fill, threads) in enumerate(styles):
        for nb, (colour, mark) in lines.items():
            places = [r["particles"] for r in found]
            costs = [1e9 / r[f"rk4_{nb}"][pool] for r in found]
            label = f"{nb} neighbours, {threads}"
            left.semilogx(places, costs, line + mark, color=colour, mfc=fill or colour, label=label)
    left.set_ylabel("ns a particle and right-hand side")
    left.set_title("Whole RK4 steps of the liver", fontsize=10)
    marks = {"rk4_122": (BLUE, "o-"), "rk4_26": (ORANGE, "s--"), "static": ("0.35", "^:")}
    for key, (colour, mark) in marks.items():
        runs = [r for r in tables.memory_rows(results) if r["run"] == key]
        places, bytes_ = ([r[what] for r in runs] for what in ("particles", "bytes_per_particle"))
        right.loglog(places, bytes_, mark, color=colour, label=tables.RUNS[key])
    right.set_ylabel("bytes a particle at the peak")
    right.set_title("Memory of the whole program", fontsize=10)
    left.set_ylim(bottom=0)
    for axes in (left, right):
        finish(axes)
    figure.tight_layout()
    figure.savefig(IMAGES / "growth.png", **SIZE)


def finish(axes: Axes) -> None:
    """What both plots of growth have."""
    axes.set_xlabel("particles")
    axes.legend(fontsize=7)
    axes.grid(alpha=0.3)


PLOTS = {
    "roofline": (roofline, ["limits", "pieces"]),
    "growth": (growth, ["growth"]),
}


def main() -> None:
    """Fills the documents and draws."""
    mpl.use("Agg")
    results = json.loads((ROOT / "benches" / "results.json").read_text())

    def lacks(name: str, parts: list[str]) -> list[str]:
        missing = [part for part in parts if part not in results]
        if missing:
            print(f"{name} stays as it is: not measured: {', '.join(missing)}", file=sys.stderr)
        return missing

    texts = {
        name: make(results)
        for name, (make, parts) in tables.TEXTS.items()
        if not lacks(name, parts)
    }
    text = DOCUMENT.read_text()
    for name, new in texts.items():
        pattern = rf"(<!-- results: {name} -->\n).*?(<!-- end -->)"
        text = re.sub(pattern, lambda m, new=new: f"{m[1]}{new}\n{m[2]}", text, flags=re.DOTALL)
    DOCUMENT.write_text(text)
    for name, (draw, parts) in PLOTS.items():
        if not lacks(f"plot of {name}", parts):
            draw(results)


if __name__ == "__main__":
    main()
