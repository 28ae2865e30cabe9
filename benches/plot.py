#!/usr/bin/env python3
"""From benches/results.json (benches/measure.py) to the tables and plots of the documents.

Fills what stands between `<!-- results: NAME -->` and `<!-- end -->` in docs/performance.md and
README.md, and draws docs/images/roofline.png and docs/images/growth.png. Needs matplotlib.
"""

import json
import re
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import operations

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
DOCUMENTS = [ROOT / "docs" / "performance.md", ROOT / "README.md"]
MILLION = 1e6


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def rates(results: dict, threads: int) -> dict[tuple[str, int], dict]:
    """Figures by body and size."""
    measured = next(r for r in results["rates"] if r["threads"] == threads)
    found: dict[tuple[str, int], dict] = {}
    for row in measured["rows"]:
        found.setdefault((row["body"], row["size"]), {}).update(row)
    return found


def million(rate: float) -> str:
    """Millions with a sensible number of digits."""
    return f"{rate / MILLION:.1f}" if rate < 1e8 else f"{rate / MILLION:.0f}"


def machine(results: dict) -> str:
    """Where, when and how loaded."""
    load = f"{results['load_before']:.1f} before and {results['load_after']:.1f} after"
    return (
        f"Measured on {results['date']}: {results['processor']}, {results['cores']} cores; "
        f"load average {load} (1 to {results['cores']} when nothing else runs)."
    )


def limits(results: dict) -> str:
    """The machine's limits and how near each sum comes."""
    lim = results["limits"]
    at_best = rates(results, results["cores"])
    rows = [
        [
            "multiply-adds in double precision",
            f"{lim['gfma_one']:.1f}",
            f"{lim['gfma_all']:.1f} G/s",
        ],
        ["STREAM triad", f"{lim['triad_gb_one']:.1f}", f"{lim['triad_gb_all']:.1f} GB/s"],
    ]
    text = table(["limit", "one thread", "all threads"], rows) + "\n\n"
    parts = []
    for nb, cut in operations.CUTS.items():
        body = {**at_best["sums", 58], **at_best["cube", 58]}
        kinds = [
            ("gradient sums", f"gradient_{nb}", operations.gradient(cut)),
            ("adjoint sums", f"adjoint_{nb}", operations.adjoint(cut)),
            ("right-hand side", f"right_hand_side_{nb}", operations.right_hand_side(nb)),
        ]
        for name, key, count in kinds:
            share = body[key] * count / (lim["gfma_all"] * 1e9)
            parts.append(
                [f"{name}, {nb} neighbours", str(count), million(body[key]), f"{share:.0%}"]
            )
    head = ["58³ cube, all threads", "operations a particle", "M/s", "share of the issue limit"]
    return text + table(head, parts)


def pieces(results: dict) -> str:
    """Rates with one thread and with all."""
    one, best = rates(results, 1), rates(results, results["cores"])
    names = {
        "right_hand_side_122": "right-hand side, 122 neighbours",
        "rk4_122": "whole RK4 steps, 122",
        "right_hand_side_26": "right-hand side, 26 neighbours",
        "rk4_26": "whole RK4 steps, 26",
    }
    bodies = [("cube", 20), ("cube", 37), ("cube", 58), ("liver", 50_000)]
    rows = []
    for key, name in names.items():
        for body in bodies:
            before, now = one[body][key], best[body][key]
            label = "50k liver" if body[0] == "liver" else f"{body[1]}³ cube"
            rows.append([name, label, million(before), million(now), f"{now / before:.2f}"])
    for n in (37, 58):
        before, now = one["pairs", n], best["pairs", n]
        for key, name in [("pairs", "pairs"), ("pairs_hourglass", "pairs, hourglass")]:
            label = f"{n}³, {before['neighbours']:.0f} on average"
            ratio = f"{now[key] / before[key]:.2f}"
            rows.append([name, label, million(before[key]), million(now[key]), ratio])
    head = ["M updates/s", "body", "1 thread", f"{results['cores']} threads", "ratio"]
    return table(head, rows)


def peers(results: dict) -> str:
    """Ours beside theirs."""
    edges = sorted({r["edge"] for r in results["peers"]})
    programs = list(dict.fromkeys(r["program"] for r in results["peers"]))
    # The first word names the program: measured rows carry its version too.
    by_place = {(r["edge"], r["program"]): r for r in results["peers"]}
    rows = []
    for program in programs:
        cells = [program]
        for edge in edges:
            row = by_place.get((edge, program), {})
            if "rate" in row:
                ratio = by_place[edge, programs[0]]["rate"] / row["rate"]
                cells.append(f"{row['rate'] / MILLION:.2f} ({ratio:.1f}x)")
            else:
                cells.append("not measured: " + row.get("error", "no row"))
        rows.append(cells)
    return table(["M updates/s (rsph is so many times faster)", *[f"{e}³" for e in edges]], rows)


def program(results: dict) -> str:
    """Memory of the whole program."""
    sizes = sorted({r["particles"] for r in results["program"]})
    names = {"rk4_122": "RK4, 122 neighbours", "rk4_26": "RK4, 26", "static": "static, 26"}
    rows = []
    for key, name in names.items():
        mine = {r["particles"]: r for r in results["program"] if r["run"] == key}
        cells = [f"{mine[s]['bytes_per_particle']:.0f}" if s in mine else "" for s in sizes]
        rows.append([name, *cells])
    return table(["bytes a particle, whole program at its peak", *[f"{s:,}" for s in sizes]], rows)


def roofline(results: dict) -> None:
    """Rate against operations per byte, under the machine's roof."""
    lim = results["limits"]
    figure, axes = plt.subplots(figsize=(6, 4))
    bandwidth, peak = lim["triad_gb_all"], lim["gfma_all"]
    intensity = [0.05, peak / bandwidth, 50]
    axes.loglog(intensity, [min(peak, bandwidth * x) for x in intensity], "k-", label="machine")
    best = rates(results, results["cores"])
    marks = {("cube", 37): "o", ("cube", 58): "s", ("liver", 50_000): "^"}
    for body, mark in marks.items():
        for nb, colour in [(122, "tab:blue"), (26, "tab:orange")]:
            count = operations.right_hand_side(nb)
            rate = best[body][f"right_hand_side_{nb}"] * count / 1e9
            name = f"{body[0]} {body[1]}, {nb} neighbours"
            axes.plot(count / operations.BYTES, rate, mark, color=colour, label=name)
    axes.set_xlabel("operations per byte from and to memory")
    axes.set_ylabel("G operations/s")
    axes.set_title("Right-hand sides under the roof")
    axes.legend(fontsize=7)
    axes.grid(alpha=0.3, which="both")
    figure.tight_layout()
    figure.savefig(IMAGES / "roofline.png", dpi=110)


def growth(results: dict) -> None:
    """Time and memory a particle against the number of particles."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.4))
    for nb in (122, 26):
        # A body is measured once for each smoothing; the number of particles is the same.
        points = [(r["particles"], 1e9 / r[f"rk4_{nb}"]) for r in results["growth"]]
        left.semilogx(*zip(*points, strict=True), "o-", label=f"{nb} neighbours")
    left.set_xlabel("particles")
    left.set_ylabel("ns a particle and right-hand side")
    left.set_ylim(bottom=0)
    left.set_title("Whole RK4 steps of the liver")
    left.legend()
    for key in ("rk4_122", "rk4_26", "static"):
        points = [
            (r["particles"], r["bytes_per_particle"]) for r in results["program"] if r["run"] == key
        ]
        right.loglog(*zip(*points, strict=True), "o-", label=key)
    right.set_xlabel("particles")
    right.set_ylabel("bytes a particle at the peak")
    right.set_title("Memory of the whole program")
    right.legend()
    for axes in (left, right):
        axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(IMAGES / "growth.png", dpi=110)


def spread(results: dict) -> str:
    """How the cost of a particle grows."""
    rows = []
    for nb in (122, 26):
        costs = [1e9 / r[f"rk4_{nb}"] for r in results["growth"]]
        cells = [f"{c:.0f}" for c in costs]
        rows.append([f"{nb} neighbours", *cells, f"{max(costs) / min(costs):.2f}"])
    sizes = [f"{r['particles']:,.0f}" for r in results["growth"]]
    return table(["ns a particle and right-hand side", *sizes, "largest / smallest"], rows)


def main() -> None:
    """Fills the documents and draws."""
    mpl.use("Agg")
    results = json.loads((ROOT / "benches" / "results.json").read_text())
    texts = {
        "machine": machine(results),
        "limits": limits(results),
        "pieces": pieces(results),
        "growth": spread(results),
        "memory": program(results),
        "roofline": "![Rates under the roof of bandwidth and arithmetic](images/roofline.png)",
        "growth plot": "![Time and memory a particle by size](images/growth.png)",
    }
    if "peers" in results:
        texts["peers"] = peers(results)
    for path in DOCUMENTS:
        text = path.read_text()
        for name, new in texts.items():
            pattern = rf"(<!-- results: {name} -->\n).*?(<!-- end -->)"
            text = re.sub(pattern, lambda m, new=new: f"{m[1]}{new}\n{m[2]}", text, flags=re.DOTALL)
        path.write_text(text)
    roofline(results)
    growth(results)


if __name__ == "__main__":
    main()
