#!/usr/bin/env python3
"""Measures what docs/performance.md says and keeps it in benches/results.json.

    python3 benches/measure.py build            # everything that has to be compiled
    python3 benches/measure.py limits pieces    # these parts; what others measured stays
    python3 benches/measure.py                  # all parts, a quarter of an hour
    python3 benches/plot.py                     # tables and plots of the documents

Needs cargo; for the instruction counts valgrind, for other programs (benches/peers) python3.11 and
a C compiler. A part that can not be measured says what is missing, and the others go on.
"""

import argparse
import datetime
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
RESULTS = HERE / "results.json"
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
BENCH = ["cargo", "bench", "--quiet", "--locked", "-p", "rsph-core", "--bench"]
SCENARIOS = ROOT / "scenarios"
THREADS = os.cpu_count() or 1
WIDE = ["solver.smoothing=1.25"]
NARROW = ["solver.smoothing=0.8"]
SIZES = ["10000", "30000", "100000", "300000", "1000000"]
HUGE_PAGES = {"GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"}
RK4 = ["time.integrator=rk4", "time.dt=auto"]


class NotMeasuredError(Exception):
    """Why a part can not be measured here."""


def output(command: list[str], env: dict | None = None) -> str:
    """What a command prints; what it says on the way goes to the terminal."""
    done = subprocess.run(command, cwd=ROOT, env=env, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise NotMeasuredError(f"`{' '.join(command)}` failed (exit {done.returncode})")
    return done.stdout


def rates(*words: str, env: dict | None = None) -> list[dict]:
    """Rows of the benchmark `rates`."""
    return json.loads(output([*BENCH, "rates", "--", *words], env).splitlines()[-1])["rows"]


def run(scenario: str, *sets: str) -> dict:
    """Summary of a run of the whole program, with its largest memory in bytes."""
    with tempfile.TemporaryDirectory() as folder:
        command = [str(TARGET / "release" / "rsph"), "run", str(SCENARIOS / scenario), "--quiet"]
        command += ["--output", folder + "/run"]
        for value in sets:
            command += ["--set", value]
        child = subprocess.Popen(command)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            raise NotMeasuredError(f"`{' '.join(command)}` failed (exit {child.returncode})")
        summary = json.loads((Path(folder) / "run" / "summary.json").read_text())
    return {"memory": usage.ru_maxrss * 1024, **summary}


def build() -> None:
    """Compiles everything, so that no part does it while it is timed."""
    output([*BENCH[:-1], "--benches", "--no-run"])
    output(["cargo", "build", "--quiet", "--locked", "--release", "-p", "rsph-cli"])


def limits() -> dict:
    """What the machine can do."""
    return json.loads(output([*BENCH, "limits"]).splitlines()[-1])


def pieces() -> list[dict]:
    """Right-hand sides and steps of RK4."""
    return rates("cube", "20", "37", "58", "liver", "50000")


def sums() -> list[dict]:
    """Kernel sums, a V-cycle."""
    return rates("sums", "20", "37", "58")


def solves() -> list[dict]:
    """Bodies taken to rest, and frames with a load that moves."""
    return rates("static", "20000", "60000", "frames", "5000", "20000", "40000")


def million() -> list[dict]:
    """A body of a million particles taken to rest."""
    return rates("static", "1000000")


def speed() -> list[dict]:
    """Whole runs with files: 200 steps, three frames."""
    rows = []
    for name, scenario, size in [
        ("58³ cube", "tensile_liver.toml", 58**3),
        ("50k liver", "liver_load.toml", 50_000),
    ]:
        for neighbours, sets in [(122, WIDE), (26, NARROW)]:
            words = [f"body.particles={size}", *sets, *RK4]
            dt = run(scenario, *words, "time.until=1e-9", "output.every=1e-9")["dt_limit"]
            until = 200 * dt
            done = run(scenario, *words, f"time.until={until}", f"output.every={until / 2}")
            rate = done["particle_updates_per_second"]
            rows.append({"run": name, "neighbours": neighbours, "rate": rate})
            rows[-1]["simd"] = done["simd"]
    return rows


def growth() -> list[dict]:
    """Steps of livers of 10,000 to a million particles."""
    return rates("liver", *SIZES)


def growth_huge() -> list[dict]:
    """The same in memory pages of 2 MB, which the C library asks for if it is told to."""
    return rates("liver", *SIZES, env={**os.environ, **HUGE_PAGES})


def growth_large() -> list[dict]:
    """Steps of a liver of four million particles."""
    return rates("liver", "4000000")


def whole_program(particles: int) -> list[dict]:
    """Largest memory of whole runs with files: some tens of steps of RK4, and straight to rest."""
    # The stable step shrinks with the square of the spacing: 2 microseconds at 10,000 particles.
    until = 20 * 2e-6 * (1e4 / particles) ** (2 / 3)
    steps = [*RK4, f"time.until={until}", f"output.every={until}"]
    rows = []
    for name, sets in [
        ("rk4_122", [*WIDE, *steps]),
        ("rk4_26", [*NARROW, *steps]),
        ("static", [*NARROW, "solver.mode=static"]),
    ]:
        done = run("liver_load.toml", f"body.particles={particles}", *sets)
        size = done["particles"]
        rows.append({"run": name, "particles": size, "bytes_per_particle": done["memory"] / size})
        rows[-1].update(steps=done["steps"], seconds=done["wall_seconds"])
    return rows


def memory() -> list[dict]:
    """Memory up to a million particles."""
    return [row for size in (10_000, 100_000, 1_000_000) for row in whole_program(size)]


def memory_large() -> list[dict]:
    """Memory with four million particles."""
    return whole_program(4_000_000)


def runner() -> Path:
    """Folder of gungraun-runner in the version of the library, installed if it is not there."""
    lock = (ROOT / "Cargo.lock").read_text()
    found = re.search(r'name = "gungraun-runner"\nversion = "(.*)"', lock)
    if found is None:
        raise NotMeasuredError("Cargo.lock names no gungraun-runner")
    home = TARGET / f"gungraun-{found[1]}"
    if not (home / "bin" / "gungraun-runner").exists():
        print(f"installing gungraun-runner {found[1]} into {home}", file=sys.stderr)
        package = ["gungraun-runner", "--version", found[1]]
        output(["cargo", "install", "--quiet", "--locked", "--root", str(home), *package])
    return home / "bin"


def instructions() -> list[dict]:
    """Instructions of every piece (benches/instructions.rs)."""
    if shutil.which("valgrind") is None:
        raise NotMeasuredError(
            "valgrind is not installed: install the package `valgrind` of your system (Linux)"
        )
    env = {**os.environ, "PATH": f"{runner()}{os.pathsep}{os.environ.get('PATH', '')}"}
    command = [*BENCH, "instructions", "--", "--output-format=json"]
    rows = []
    for row in map(json.loads, output(command, env).splitlines()):
        count = row["profiles"][0]["data"]["total"]["metrics"]["Ir"]["values"]["new"]
        rows.append({"piece": row["function_name"], "case": row["id"], "instructions": count})
    return rows


def peers() -> list[dict]:
    """The same right-hand side in other programs."""
    command = [sys.executable, str(HERE / "peers" / "run.py"), "--json"]
    return json.loads(output(command).splitlines()[-1])


# In the order of docs/performance.md.
PARTS = [
    limits,
    pieces,
    sums,
    solves,
    million,
    speed,
    growth,
    growth_huge,
    growth_large,
    memory,
    memory_large,
    instructions,
    peers,
]


def processor() -> str:
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(x.split(":")[1].strip() for x in lines if x.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


def main() -> int:
    """Measures the parts asked for, all of them if none is."""
    parts = {part.__name__.replace("_", "-"): part for part in PARTS}
    listed = "\n".join(f"  {name:14}{part.__doc__}" for name, part in parts.items())
    parser = argparse.ArgumentParser(
        description=__doc__,
        epilog="parts:\n" + listed,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("part", nargs="*", choices=[*parts, "build", []], metavar="PART")
    chosen = parser.parse_args().part
    if not chosen or "build" in chosen:
        build()
    failed = 0
    for name in [n for n in parts if n in chosen or not chosen]:
        print(f"{name}: {parts[name].__doc__}", file=sys.stderr, flush=True)
        load, start = os.getloadavg()[0], time.monotonic()
        try:
            found = parts[name]()
        except NotMeasuredError as why:
            print(f"{name}: not measured: {why}", file=sys.stderr)
            failed = 1
            continue
        seconds = time.monotonic() - start
        # Read now and written at once: others may measure too, and the next part may fail.
        results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
        results[name] = {
            "date": datetime.date.today().isoformat(),
            "processor": processor(),
            "threads": THREADS,
            "load_before": load,
            "seconds": round(seconds),
            "found": found,
        }
        RESULTS.write_text(json.dumps(results, indent=1) + "\n")
        print(f"{name}: {seconds:.0f} s", file=sys.stderr)
    return failed


if __name__ == "__main__":
    sys.exit(main())
