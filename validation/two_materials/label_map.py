"""The body of `reference.py` as a segmentation: `tumour.nii.gz`, 1 parenchyma, 2 tumour.

    pip install numpy nibabel
    python label_map.py

Voxels of 1 mm in the axes of the body; the label of a voxel is what fills more than half of it.
"""

from itertools import product
from pathlib import Path

import nibabel as nib
import numpy as np

AXES = np.array([80.0, 50.0, 40.0])
CENTRE, RADIUS = np.array([20.0, 8.0, -5.0]), 15.0
SIDE, RIM, PARTS = 1.0, 3, 4

count = 2 * (np.ceil(AXES / SIDE).astype(int) + RIM)
origin = -0.5 * SIDE * (count - 1)
middle = [o + SIDE * np.arange(n) for o, n in zip(origin, count, strict=True)]
offsets = SIDE * ((np.arange(PARTS) + 0.5) / PARTS - 0.5)
organ, tumour = np.zeros(count), np.zeros(count)
for offset in product(offsets, repeat=3):
    x, y, z = np.meshgrid(*(m + d for m, d in zip(middle, offset, strict=True)), indexing="ij")
    organ += (x / AXES[0]) ** 2 + (y / AXES[1]) ** 2 + (z / AXES[2]) ** 2 <= 1.0
    tumour += (x - CENTRE[0]) ** 2 + (y - CENTRE[1]) ** 2 + (z - CENTRE[2]) ** 2 <= RADIUS**2
labels = (organ > PARTS**3 / 2).astype(np.uint8)
labels[tumour > PARTS**3 / 2] = 2
affine = np.diag([SIDE, SIDE, SIDE, 1.0])
affine[:3, 3] = origin
image = nib.Nifti1Image(labels, affine)
image.header.set_xyzt_units("mm")
nib.save(image, Path(__file__).with_name("tumour.nii.gz"))
volumes = [float((labels == k).sum()) * SIDE**3 * 1e-9 for k in (1, 2)]
print(f"parenchyma {volumes[0]:.6e} m^3, tumour {volumes[1]:.6e} m^3")
