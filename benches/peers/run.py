#!/usr/bin/env python3
"""Runs the same right-hand side in rsph, Taichi and PySPH and prints one table.

    python3 benches/peers/run.py [--json] [--edges 37 58]

The other programs are installed from their packages into target/peers. What can not be installed or
run is said in the table.
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
PROGRAMS = {
    "Taichi, weights kept": ["taichi_csr.py"],
    "Taichi, kernel evaluated": ["taichi_csr.py", "evaluate"],
    "PySPH": ["pysph_rhs.py"],
}


def say(text: str) -> None:
    """Progress, apart from results."""
    print(text, file=sys.stderr)


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


def ours(edges: list[int], threads: int) -> dict[int, dict]:
    """Our rates by edge: the whole right-hand side, and the pairs of irregular sets."""
    words = [str(e) for e in edges]
    command = ["cargo", "bench", "--quiet", "-p", "rsph-core", "--bench", "rates", "--"]
    command += ["cube", *words, "pairs", *words]
    env = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
    out = subprocess.run(command, cwd=ROOT, env=env, check=True, stdout=subprocess.PIPE, text=True)
    rates: dict[int, dict] = {}
    for row in json.loads(out.stdout.strip().splitlines()[-1])["rows"]:
        rates.setdefault(row["size"], {}).update(row)
    return rates


def theirs(script: list[str], edge: int, threads: int) -> dict:
    """What another program prints, or why it does not."""
    env = {**os.environ, "THREADS": str(threads), "OMP_NUM_THREADS": str(threads)}
    command = [python(), str(HERE / script[0]), str(edge), *script[1:]]
    out = subprocess.run(command, env=env, capture_output=True, text=True)
    for line in reversed(out.stdout.splitlines()):
        if line.startswith("{"):
            return json.loads(line)
    return {"error": (out.stderr.strip().splitlines() or ["nothing printed"])[-1]}


def main() -> None:
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--edges", type=int, nargs="+", default=[37, 58])
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    options = parser.parse_args()
    rows = []
    for edge in options.edges:
        # Side by side in time: the machine's mood changes.
        own = ours([edge], options.threads)[edge]
        rows.append({"edge": edge, "program": "rsph", "rate": own["right_hand_side_122"]})
        rows.append({"edge": edge, "program": "rsph, neighbour pairs", "rate": own["pairs"]})
        for name, script in PROGRAMS.items():
            say(f"{name}, {edge}^3")
            rows.append({"edge": edge, "program": name, **theirs(script, edge, options.threads)})
    if options.json:
        print(json.dumps(rows))
        return
    print(f"Right-hand sides, 122 neighbours, double precision, {options.threads} threads")
    for row in rows:
        if "rate" in row:
            ours_rate = next(r["rate"] for r in rows if r["edge"] == row["edge"])
            figures = f"{row['rate'] / 1e6:6.2f} M/s   {ours_rate / row['rate']:5.1f} x"
        else:
            figures = row["error"]
        print(f"{row['edge']}^3  {row['program']:24} {figures}")


if __name__ == "__main__":
    main()
