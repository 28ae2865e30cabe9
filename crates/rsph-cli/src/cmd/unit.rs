//! The unit of length of a mesh file, which most formats do not say.

use rsph_core::grid::Bounds;
use std::ops::Range;
use std::path::Path;

/// Sizes of organs, and of what is cut out of them, in metres.
const ORGANS: Range<f64> = 0.005..2.0;

/// From the coordinates of a mesh to metres, by its format, or as the size of organs suggests; `None` if neither tells.
pub fn scale_to_metres(path: &Path, bounds: &Bounds) -> Option<f64> {
    let size = bounds.size().max();
    if is_gltf(path) {
        Some(1.0)
    } else {
        [0.001, 1.0].into_iter().find(|scale| ORGANS.contains(&(scale * size)))
    }
}

/// Whether the file is glTF, which is in metres.
pub fn is_gltf(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb") || e.eq_ignore_ascii_case("gltf"))
}
