"""Markdown tables of the documents from benches/results.json (benches/measure.py).

Each function takes the results of all parts and returns the text of one table.
"""

import operations

MILLION = 1e6
NAMES = {
    "right_hand_side_122": "right-hand side, 122 neighbours",
    "rk4_122": "whole RK4 steps, 122",
    "right_hand_side_26": "right-hand side, 26 neighbours",
    "rk4_26": "whole RK4 steps, 26",
}
RUNS = {"rk4_122": "RK4, 122 neighbours", "rk4_26": "RK4, 26", "static": "to rest, 26"}


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def million(rate: float) -> str:
    """Millions a second with a sensible number of digits."""
    return f"{rate / MILLION:.3g}" if rate < 1e8 else f"{rate / MILLION:.0f}"


def by_body(rows: list[dict]) -> dict[tuple[str, int], dict]:
    """Figures by body and size. Rates are those of one thread and of all."""
    bodies: dict[tuple[str, int], dict] = {}
    for row in rows:
        bodies.setdefault((row["body"], row["size"]), {}).update(row)
    return bodies


def machine(results: dict) -> str:
    """Where and when."""
    parts = results.values()
    dates = sorted({p["date"] for p in parts})
    when = dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"
    processors = ", ".join(sorted({f"{p['processor']}, {p['threads']} threads" for p in parts}))
    simd = {row["simd"] for row in results["speed"]["found"]}
    return f"Measured on {when}: {processors}, vector instructions {', '.join(sorted(simd))}."


def pieces(results: dict) -> str:
    """Rates with one thread and with all."""
    lines = []
    bodies = by_body(results["pieces"]["found"])
    for key, name in NAMES.items():
        for (body, size), row in bodies.items():
            lines.append((name, "50k liver" if body == "liver" else f"{size}³ cube", row[key]))
    for (_, size), row in by_body(results["sums"]["found"]).items():
        lines.append(("V-cycle, 26 neighbours", f"{size}³ cube", row["v_cycle"]))
    rows = [
        [name, body, million(one), million(best), f"{best / one:.2f}"]
        for name, body, (one, best) in lines
    ]
    threads = results["pieces"]["threads"]
    return table(["M updates/s", "body", "1 thread", f"{threads} threads", "ratio"], rows)


def speed(results: dict) -> str:
    """Rates of whole runs."""
    rows = [
        [f"{r['run']}, {r['neighbours']} neighbours", million(r["rate"])]
        for r in results["speed"]["found"]
    ]
    return table(["whole `rsph run` with RK4, files included", "M updates/s"], rows)


def solves(results: dict) -> str:
    """Seconds to rest and milliseconds a frame."""
    found = [*results["solves"]["found"], *results["million"]["found"]]
    still = [r for r in found if r["body"] == "static"]
    head = ["liver to rest, 26 neighbours", *[f"{r['particles']:,.0f}" for r in still]]
    rows = [
        ["iterations", *[f"{r['iterations']:.0f}" for r in still]],
        ["set-up of the solver (s)", *[f"{r['set_up']:.3g}" for r in still]],
        ["solve (s)", *[f"{r['solve']:.3g}" for r in still]],
    ]
    text = table(head, rows)
    moved = [r for r in found if r["body"] == "frames"]
    head = ["frame of 1/30 s, load moves, SDIRK2", *[f"{r['particles']:,.0f}" for r in moved]]
    rows = [
        ["a frame (ms)", *[f"{1e3 * r['frame']:.3g}" for r in moved]],
        ["of that, the new load (ms)", *[f"{1e3 * r['new_load']:.2g}" for r in moved]],
        ["frames a second", *[f"{1 / r['frame']:.0f}" for r in moved]],
    ]
    return text + "\n\n" + table(head, rows)


def limits(results: dict) -> str:
    """The machine's limits and how near each sum comes."""
    lim = results["limits"]["found"]
    rows = [
        ["multiply-adds (G/s)", f"{lim['gfma_one']:.1f}", f"{lim['gfma_all']:.1f}"],
        ["STREAM triad (GB/s)", f"{lim['triad_gb_one']:.1f}", f"{lim['triad_gb_all']:.1f}"],
    ]
    head = ["limit in double precision", "one thread", f"{lim['threads']} threads"]
    text = table(head, rows) + "\n\n"
    sums, bodies = by_body(results["sums"]["found"]), by_body(results["pieces"]["found"])
    body = {**sums["sums", 58], **bodies["cube", 58]}
    rows = []
    for nb, cut in operations.CUTS.items():
        for name, key, count in [
            ("gradient sums", f"gradient_{nb}", operations.gradient(cut)),
            ("adjoint sums", f"adjoint_{nb}", operations.adjoint(cut)),
            ("right-hand side", f"right_hand_side_{nb}", operations.right_hand_side(nb)),
        ]:
            rate = body[key][-1]
            share = rate * count / (lim["gfma_all"] * 1e9)
            rows.append([f"{name}, {nb} neighbours", str(count), million(rate), f"{share:.0%}"])
    head = ["58³ cube", "operations a particle", "M/s", "share of the issue limit"]
    return text + table(head, rows)


def growth_rows(results: dict) -> list[dict]:
    """Livers by size."""
    large = results.get("growth-large", {"found": []})
    return [*results["growth"]["found"], *large["found"]]


def growth(results: dict) -> str:
    """How the cost of a particle grows."""
    return growth_table(growth_rows(results), results["growth"]["threads"])


def growth_huge(results: dict) -> str:
    """The same in pages of 2 MB."""
    return growth_table(results["growth-huge"]["found"], results["growth-huge"]["threads"])


def growth_table(found: list[dict], threads: int) -> str:
    """Nanoseconds by size."""
    rows = []
    for pool, label in enumerate(["1 thread", f"{threads} threads"]):
        for nb in (122, 26):
            costs = [1e9 / r[f"rk4_{nb}"][pool] for r in found]
            ratios = [f"{costs[-1] / costs[0]:.2f}", f"{max(costs) / min(costs):.2f}"]
            rows.append([f"{nb} neighbours, {label}", *[f"{c:.0f}" for c in costs], *ratios])
    sizes = [f"{r['particles']:,.0f}" for r in found]
    head = ["ns a particle and right-hand side", *sizes, "last / first", "largest / smallest"]
    return table(head, rows)


def memory_rows(results: dict) -> list[dict]:
    """Whole runs by size."""
    parts = [results.get(part, {"found": []}) for part in ("memory", "memory-large")]
    return [row for part in parts for row in part["found"]]


def memory(results: dict) -> str:
    """Memory of the whole program."""
    found = memory_rows(results)
    sizes = sorted({r["particles"] for r in found})
    rows = []
    for key, name in RUNS.items():
        mine = {r["particles"]: r for r in found if r["run"] == key}
        cells = [f"{mine[s]['bytes_per_particle']:,.0f}" if s in mine else "" for s in sizes]
        rows.append([name, *cells])
    return table(["bytes a particle, whole program at its peak", *[f"{s:,}" for s in sizes]], rows)


def instructions(results: dict) -> str:
    """Instructions a particle."""
    rows = []
    for r in results["instructions"]["found"]:
        name = f"{r['piece']}, {r['case']}".replace("_", " ")
        rows.append([name, f"{r['instructions']:,}", f"{r['instructions'] / 20**3:,.0f}"])
    return table(["20³ cube, one thread, AVX2", "instructions", "a particle"], rows)


def peers(results: dict) -> str:
    """Ours beside theirs."""
    found = results["peers"]["found"]
    edges = sorted({r["edge"] for r in found})
    by_place = {(r["program"], r["edge"]): r for r in found}
    names = list(dict.fromkeys(r["program"] for r in found))
    rows, failed = [], []
    for name in names:
        mine = [by_place[name, e] for e in edges]
        version = next((r["version"] for r in mine if "version" in r), "")
        cells = [f"{name} ({version})" if version else name]
        for row in mine:
            if "rate" in row:
                ratio = by_place[names[0], row["edge"]]["rate"] / row["rate"]
                cells.append(f"{row['rate'] / MILLION:.2f} ({ratio:.1f}x)")
            else:
                cells.append("not measured")
                failed.append(f"{name}, {row['edge']}³: {row['error']}.")
        rows.append(cells)
    head = ["M updates/s (how many times as fast the first line is)", *[f"{e}³" for e in edges]]
    return "\n\n".join([table(head, rows), *failed])


TEXTS = {
    "machine": (machine, ["speed"]),
    "pieces": (pieces, ["pieces", "sums"]),
    "speed": (speed, ["speed"]),
    "solves": (solves, ["solves", "million"]),
    "limits": (limits, ["limits", "sums", "pieces"]),
    "growth": (growth, ["growth"]),
    "growth-huge": (growth_huge, ["growth-huge"]),
    "memory": (memory, ["memory"]),
    "instructions": (instructions, ["instructions"]),
    "peers": (peers, ["peers"]),
}
