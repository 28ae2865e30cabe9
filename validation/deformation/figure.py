"""Draws figure.png: Figs. 1 to 3 of the paper from the program's own output.

Run at the root of the repository, with the program built: python validation/deformation/figure.py
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

ROOT = Path(__file__).resolve().parents[2]
TIMES = (0.4, 0.6, 0.8)


def surfaces(program: str, name: str, folder: Path) -> dict[float, np.ndarray]:
    """Triangles (N, 3, 3) of the surface at each of TIMES."""
    scenario = str(ROOT / "scenarios" / f"{name}.toml")
    command = [
        program,
        "run",
        scenario,
        "--set",
        "output.every=0.2",
        "--output",
        str(folder),
        "--quiet",
    ]
    subprocess.run([program, "run", scenario, *edits], check=True)
    found = {}
    with h5py.File(folder / "surface.vtkhdf") as file:
        root = file["VTKHDF"]
        steps, polygons = root["Steps"], root["Polygons"]
        points = np.concatenate([[0], np.cumsum(root["NumberOfPoints"][:])])
        indices = np.concatenate([[0], np.cumsum(polygons["NumberOfConnectivityIds"][:])])
        for k, time in enumerate(steps["Values"][:]):
            wanted = [t for t in TIMES if abs(t - time) < 1e-9]
            if wanted:
                x = root["Points"][points[k] : points[k + 1]]
                corners = polygons["Connectivity"][indices[k] : indices[k + 1]]
                found[wanted[0]] = x[corners].reshape(-1, 3, 3)
    return found


def main() -> None:
    program = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target" / "release" / "rsph")
    with tempfile.TemporaryDirectory() as folder:
        columns = {
            "without remeshing": surfaces(program, "deformation", Path(folder) / "without"),
            "with remeshing": surfaces(program, "deformation_remeshed", Path(folder) / "with"),
        }
    figure, axes = plt.subplots(3, 2, figsize=(6, 8), subplot_kw={"projection": "3d"})
    for column, (title, by_time) in enumerate(columns.items()):
        for row, time in enumerate(TIMES):
            ax = axes[row, column]
            mesh = Poly3DCollection(by_time[time], facecolors="#6699cc", shade=True)
            ax.add_collection3d(mesh)
            ax.set(xlim=(0, 1), ylim=(0, 1), zlim=(0, 1), xticks=[], yticks=[], zticks=[])
            ax.set_title(f"{title}, T = {time}", fontsize=8)
            ax.view_init(elev=20, azim=-60)
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name("figure.png"), dpi=80)


if __name__ == "__main__":
    main()
