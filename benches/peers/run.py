#!/usr/bin/env python3
"""Runs the same right-hand side in rsph, Taichi and PySPH and prints one table.

    python3 benches/peers/run.py [--json] [--edges 20 37 58]

The other programs are installed from their packages into target/peers, or taken from the virtual
environment that RSPH_PEERS names. What can not be installed or run is said in the table.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
VENV = Path(os.environ.get("RSPH_PEERS", ROOT / "target" / "peers"))
# PySPH compiles itself: it wants its own libraries there before, not NumPy 2 or Cython 0.29.
PACKAGES = [
    ["numpy<2", "cython>=3,<3.1", "setuptools<70", "wheel"],
    ["taichi==1.7.4"],
    ["--no-build-isolation", "cyarray", "compyle"],
    ["--no-build-isolation", "pysph==1.0b2"],
]
OURS = {
    "rsph": "right_hand_side_122",
    "rsph, whole RK4 steps": "rk4_122",
}
PROGRAMS = {
    "Taichi, weights kept": ["taichi_csr.py"],
    "Taichi, kernel evaluated": ["taichi_csr.py", "evaluate"],
    "PySPH": ["pysph_rhs.py"],
}


# Seconds that a program may take at one size, compilation included.
PATIENCE = 120


def say(text: str) -> None:
    """Progress, apart from results."""
    print(text, file=sys.stderr, flush=True)


def python() -> str:
    """The interpreter with the other programs; made if it is not there."""
    interpreter = VENV / "bin" / "python"
    if not interpreter.exists():
        base = shutil.which("python3.11") or sys.executable
        say(f"installing into {VENV} (PySPH takes minutes)")
        subprocess.run([base, "-m", "venv", VENV], check=True)
        for packages in PACKAGES:
            command = [interpreter, "-m", "pip", "install", "--quiet", *packages]
            if subprocess.run(command).returncode:
                say(f"not installed: {' '.join(packages)}")
    return str(interpreter)


def ours(edge: int, threads: int) -> dict:
    """Our rates: right-hand side and steps."""
    command = ["cargo", "bench", "--quiet", "--locked", "-p", "rsph-core", "--bench", "rates", "--"]
    command += ["cube", str(edge)]
    env = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    out = subprocess.run(command, cwd=ROOT, env=env, check=True, stdout=subprocess.PIPE, text=True)
    rates: dict = {}
    for row in json.loads(out.stdout.strip().splitlines()[-1])["rows"]:
        rates.update(row)
    return rates


def theirs(script: list[str], edge: int, threads: int) -> dict:
    """What another program prints, or why it does not."""
    env = {**os.environ, "THREADS": str(threads), "OMP_NUM_THREADS": str(threads)}
    command = [python(), str(HERE / script[0]), str(edge), *script[1:]]
    try:
        out = subprocess.run(command, env=env, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return {"error": f"not done after {PATIENCE} s"}
    for line in reversed(out.stdout.splitlines()):
        if line.startswith("{"):
            return json.loads(line)
    return {"error": (out.stderr.strip().splitlines() or ["nothing printed"])[-1]}


def cell(row: dict, own: float) -> str:
    """A rate in millions, and how many times as fast ours is."""
    return f"{row['rate'] / 1e6:.2f} ({own / row['rate']:.1f}x)" if "rate" in row else "-"


def table(rows: list[dict]) -> str:
    """Programs down, sizes across; what could not be measured below."""
    by_place = {(row["program"], row["edge"]): row for row in rows}
    names, edges = ([*dict.fromkeys(key[i] for key in by_place)] for i in (0, 1))
    lines = ["".join([f"{'':34}", *(f"{f'{edge}^3':>16}" for edge in edges)])]
    for name in names:
        mine = [by_place[name, edge] for edge in edges]
        version = next((row["version"] for row in mine if "version" in row), "")
        own = [by_place[names[0], edge]["rate"] for edge in edges]
        cells = [f"{cell(*pair):>16}" for pair in zip(mine, own, strict=True)]
        lines.append("".join([f"{name} {version}".ljust(34), *cells]))
    failed = [row for row in rows if "error" in row]
    return "\n".join(lines + [f"{r['program']}, {r['edge']}^3: {r['error']}" for r in failed])


def main() -> None:
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--edges", type=int, nargs="+", default=[20, 37, 58])
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    options = parser.parse_args()
    rows = []
    for edge in options.edges:
        # Side by side in time: the machine's mood changes.
        say(f"rsph, {edge}^3")
        own = ours(edge, options.threads)
        for name, key in OURS.items():
            rows.append({"edge": edge, "program": name, "rate": own[key][-1]})
        for name, script in PROGRAMS.items():
            say(f"{name}, {edge}^3")
            rows.append({"edge": edge, "program": name, **theirs(script, edge, options.threads)})
    if options.json:
        print(json.dumps(rows))
        return
    print(
        f"Million particle updates a second, 122 neighbours, double precision, {options.threads} "
        "threads\n(in brackets: how many times as fast the first line is)\n"
    )
    print(table(rows))


if __name__ == "__main__":
    main()
