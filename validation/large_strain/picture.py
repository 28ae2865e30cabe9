"""Picture of the plane block at 40 % stretch before and after a remesh.

    pip install numpy h5py matplotlib
    cargo build --release && python validation/large_strain/picture.py target/release/rsph

Runs scenarios/block_large_strain.toml with one remesh near its end and draws the frames on both
sides of it.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).resolve().parent
SCENARIO = HERE.parents[1] / "scenarios" / "block_large_strain.toml"


def run(program: str, folder: Path, *edits: str) -> Path:
    sets = [part for edit in edits for part in ("--set", edit)]
    command = [program, "run", str(SCENARIO), "--output", str(folder), "--quiet", *sets]
    subprocess.run(command, check=True)
    return folder


def frames(path: Path) -> list[dict[str, np.ndarray]]:
    with h5py.File(path) as f:
        root = f["VTKHDF"]
        counts, starts = root["NumberOfPoints"][:], root["Steps/PointOffsets"][:]
        part = [slice(s, s + n) for s, n in zip(starts, counts, strict=True)]
        stress = root["PointData/von_mises"]
        return [{"x": root["Points"][p], "stress": stress[p]} for p in part]


def main() -> None:
    program = sys.argv[1] if len(sys.argv) > 1 else "rsph"
    with tempfile.TemporaryDirectory() as temporary:
        once = run(program, Path(temporary) / "once", "time.until=0.02")
        dt = json.loads((once / "summary.json").read_text())["dt"]
        # Between the frames at t = 7.8 and t = 8.
        steps = round(7.9 / dt)
        moments = frames(
            run(program, Path(temporary) / "block", f"remesh.every={steps}") / "particles.vtkhdf"
        )[-2:]
    figure, axes = plt.subplots(1, 2, figsize=(7.2, 4.4), sharey=True, layout="constrained")
    top = max(m["stress"].max() for m in moments)
    for axis, moment, title in zip(axes, moments, ("before", "after"), strict=True):
        x = moment["x"]
        dots = axis.scatter(
            x[:, 0], x[:, 1], c=moment["stress"], s=9, vmin=0, vmax=top, cmap="viridis"
        )
        axis.set_title(f"{title} the remesh: {len(x)} particles", fontsize=10)
        axis.set_aspect("equal")
    figure.colorbar(dots, ax=axes, label="von Mises stress", shrink=0.8)
    figure.savefig(HERE / "figure.png", dpi=90)


if __name__ == "__main__":
    main()
