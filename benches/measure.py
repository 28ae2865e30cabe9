#!/usr/bin/env python3
"""Measures what docs/performance.md says and writes it to benches/results.json.

    python3 benches/measure.py [--quick] [--no-peers] && python3 benches/plot.py

Needs cargo, and for the other programs (benches/peers) python3.11 and a C compiler. `--quick`
leaves out bodies of more than a million particles.
"""

import argparse
import datetime
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
CARGO = ["cargo", "bench", "--quiet", "-p", "rsph-core", "--bench"]
LIVER = str(ROOT / "scenarios" / "liver_load.toml")


def bench(name: str, *words: str, threads: int | None = None) -> dict:
    """What a benchmark prints as JSON."""
    env = dict(os.environ)
    if threads:
        env["RAYON_NUM_THREADS"] = str(threads)
    command = [*CARGO, name, "--", *words]
    out = subprocess.run(command, cwd=ROOT, env=env, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(out.stdout.strip().splitlines()[-1])


def program(*sets: str) -> dict:
    """Peak memory (bytes) and summary of a run of the liver."""
    rsph = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "rsph"
    with tempfile.TemporaryDirectory() as folder:
        command = [str(rsph), "run", LIVER, "--quiet", "--output", folder + "/run"]
        for value in sets:
            command += ["--set", value]
        child = subprocess.Popen(command)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            sys.exit(f"failed: {' '.join(command)}")
        summary = json.loads((Path(folder) / "run" / "summary.json").read_text())
    return {"memory": usage.ru_maxrss * 1024, **summary}


def whole_program(particles: int) -> list[dict]:
    """Memory and time of whole runs: RK4 (about 20 steps) and straight to rest."""
    size = f"body.particles={particles}"
    # The stable step shrinks with the square of the spacing: 5 microseconds at 10,000 particles.
    until = 20 * 5e-6 * (1e4 / particles) ** (2 / 3)
    runs = {
        "rk4_122": ["solver.smoothing=1.25", "solver.hourglass=0.1"],
        "rk4_26": [],
        "static": ["solver.mode=static"],
    }
    rows = []
    for name, sets in runs.items():
        if name != "static":
            sets = [*sets, "time.integrator=rk4", f"time.until={until}", f"output.every={until}"]
        run = program(size, *sets)
        rows.append(
            {
                "run": name,
                "particles": run["particles"],
                "bytes_per_particle": run["memory"] / run["particles"],
                "steps": run["steps"],
                "seconds": run["wall_seconds"],
            }
        )
        print(rows[-1])
    return rows


def processor() -> str:
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(x.split(":")[1].strip() for x in lines if x.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


def main() -> None:
    """Measures everything."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="no more than a million particles")
    parser.add_argument("--no-peers", action="store_true", help="only our own program")
    options = parser.parse_args()

    threads = os.cpu_count() or 1
    results: dict = {
        "date": datetime.date.today().isoformat(),
        "processor": processor(),
        "cores": threads,
        "load_before": os.getloadavg()[0],
    }
    results["limits"] = bench("limits")
    print(results["limits"])
    results["rates"] = []
    for count in sorted({1, threads}):
        words = [
            "cube",
            "20",
            "37",
            "58",
            "liver",
            "50000",
            "sums",
            "20",
            "37",
            "58",
            "pairs",
            "37",
            "58",
        ]
        results["rates"].append(bench("rates", *words, threads=count))
        print(results["rates"][-1])
    sizes = [10_000, 30_000, 100_000, 300_000, 1_000_000]
    if not options.quick:
        sizes.append(4_000_000)
    results["growth"] = bench("rates", "liver", *map(str, sizes))["rows"]
    build = ["cargo", "build", "--quiet", "--release"]
    subprocess.run(build, cwd=ROOT, check=True)
    memory = [10_000, 100_000, 1_000_000] + ([] if options.quick else [4_000_000])
    results["program"] = [row for size in memory for row in whole_program(size)]
    if not options.no_peers:
        peers = [sys.executable, str(HERE / "peers" / "run.py"), "--json"]
        out = subprocess.run(peers, check=True, stdout=subprocess.PIPE, text=True)
        results["peers"] = json.loads(out.stdout.strip().splitlines()[-1])
    results["load_after"] = os.getloadavg()[0]
    (HERE / "results.json").write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()
