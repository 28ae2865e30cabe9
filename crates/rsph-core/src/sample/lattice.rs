//! Where the lattice lies relative to the shape, and how large it may be.

use super::Alignment;
use super::occupy::{Occupied, occupy};
use crate::error::InvalidInput;
use crate::grid::Grid;
use crate::shape::Shape;

/// Most cells that the lattice around a body may have.
pub(super) const MAX_CELLS: f64 = 50e6;

/// Memory of a simulation a cell of the lattice and a particle (bytes), for messages.
const BYTES_PER_CELL: f64 = 150.0;
const BYTES_PER_PARTICLE: f64 = 1000.0;

/// Cells added on each side when the surface is taken.
pub(super) const MARGIN: usize = 2;

/// How far from an integer number of spacings the edge of a body may be for the spacing to be snapped to it: one that is rounded to its
/// last written digit must not make the lattice jump by half a cell.
const SNAP: f64 = 1e-4;
/// The same that is rounding.
const ROUNDING: f64 = 1e-9;
/// How much more than a whole number of cells, in cells, a body may be across and still get that number.
const OVERHANG: f64 = 1e-3;

/// The cells of the body at a spacing that the user gave.
///
/// # Errors
/// `body.spacing` when it is not positive, too small, or gives no particle.
pub(super) fn with_spacing(
    shape: &dyn Shape,
    spacing: f64,
    alignment: &[Alignment],
) -> Result<Occupied, InvalidInput> {
    let refuse =
        |problem: String, remedy: String| Err(InvalidInput::new("body.spacing", spacing, problem, remedy));
    let size = shape.bounds().size();
    let widest = size.iter().take(shape.dimension()).copied().fold(0.0, f64::max);
    if !(spacing.is_finite() && spacing > 0.0) {
        return refuse(
            "the spacing of the particles must be a positive, finite length".into(),
            format!("give a length well below the body's extent {}", short(widest)),
        );
    }
    let cells = cells_around(shape, spacing);
    if cells > MAX_CELLS {
        let particles = shape.volume() / spacing.powi(shape.dimension() as i32);
        let bytes = BYTES_PER_CELL * cells + BYTES_PER_PARTICLE * particles;
        return refuse(
            format!(
                "the lattice would have {cells:.3e} cells, more than the {MAX_CELLS:.0e} that fit, and take \
                 about {:.3e} GB",
                bytes / 1e9
            ),
            format!("the smallest spacing that fits is {}", short(smallest_spacing(shape))),
        );
    }
    let occupied = occupy(shape, lattice(shape, spacing, alignment), None);
    if occupied.cells.is_empty() {
        return refuse(
            format!(
                "no cell of the lattice is filled by a tenth or more: the body ({} x {} x {}) is too small \
                 or too thin for this spacing",
                short(size.x),
                short(size.y),
                short(size.z)
            ),
            format!("try {}", short((shape.volume() / 1000.0).powf(1.0 / shape.dimension() as f64))),
        );
    }
    Ok(occupied)
}

/// The lattice around the shape, the spacing snapped so that an edge of its bounding box which is nearly a whole number of
/// spacings is exactly that. Boxes: from the lower corner. Other shapes: centred. Plane bodies have one
/// layer of cells around z = 0.
pub(super) fn lattice(shape: &dyn Shape, spacing: f64, alignment: &[Alignment]) -> Grid {
    let bounds = shape.bounds();
    let size = bounds.size();
    let mut spacing = spacing;
    if shape.is_box() || alignment.is_empty() {
        // A spacing that divides another shape to rounding stays as it is.
        let least = if shape.is_box() { 0.0 } else { ROUNDING };
        let snapped = size.iter().take(shape.dimension()).find_map(|&s| {
            let n = (s / spacing).round();
            (n >= 1.0 && (s / spacing - n).abs() <= SNAP)
                .then(|| if (s / spacing - n).abs() < least { spacing } else { s / n })
        });
        spacing = snapped.unwrap_or(spacing);
    }
    let mut grid = Grid { origin: bounds.min, spacing, cells: [1; 3] };
    if shape.dimension() == 2 {
        grid.origin.z = -0.5 * spacing;
    }
    for i in 0..shape.dimension() {
        let needed = |length: f64, overhang: f64| ((length / spacing - overhang).ceil() as usize).max(1);
        if let Some(a) = alignment.iter().rev().find(|a| a.axis == i) {
            // The highest lattice plane (a face between cells) at or below the body.
            let plane = a.at + (a.offset - 0.5) * spacing;
            let below = ((bounds.min[i] - plane) / spacing + 1e-9).floor();
            grid.origin[i] = plane + below * spacing;
            grid.cells[i] = needed(bounds.max[i] - grid.origin[i], 1e-6);
        } else {
            grid.cells[i] = needed(size[i], OVERHANG);
            if !shape.is_box() {
                let middle = 0.5 * (bounds.min[i] + bounds.max[i]);
                grid.origin[i] = middle - 0.5 * grid.cells[i] as f64 * spacing;
            }
        }
    }
    grid
}

/// Number of cells of the lattice with its margin; infinite for a spacing that is far too small.
pub(super) fn cells_around(shape: &dyn Shape, spacing: f64) -> f64 {
    let size = shape.bounds().size();
    size.iter().take(shape.dimension()).map(|s| (s / spacing).ceil() + 2.0 * MARGIN as f64 + 1.0).product()
}

/// The smallest spacing whose lattice fits, rounded up to three digits.
pub(super) fn smallest_spacing(shape: &dyn Shape) -> f64 {
    let size = shape.bounds().size();
    let extent: f64 = size.iter().take(shape.dimension()).product();
    let mut spacing = (extent / MAX_CELLS).powf(1.0 / shape.dimension() as f64);
    while spacing > 0.0 && cells_around(shape, spacing) > MAX_CELLS {
        spacing *= 1.01;
    }
    let digit = 10_f64.powf(spacing.log10().floor() - 2.0);
    (spacing / digit).ceil() * digit
}

/// A length with three significant digits.
pub(super) fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        rounded.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Resolution, sample};
    use crate::shape::{BoxShape, SphereShape};
    use crate::tensor::Vec3;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    #[test]
    fn a_box_snaps_to_whole_cells() {
        let cube = BoxShape::new(Vec3::repeat(1.0), Vec3::repeat(-2.0)).unwrap();
        let body = sample(&cube, Resolution::Spacing(0.14285714), &[]).unwrap();
        assert_eq!((body.cells.len(), body.grid.cells), (343, [7; 3]));
        assert_relative_eq!(body.grid.spacing, 1.0 / 7.0, epsilon = 1e-15);
        assert!(body.fraction.iter().all(|&t| t.to_bits() == 1.0_f64.to_bits()));
        assert_relative_eq!(body.level_set[0], -0.5 / 7.0, epsilon = 1e-12);
    }

    #[test]
    fn a_box_that_does_not_divide_has_partial_cells() {
        let b = BoxShape::new(Vec3::new(1.0, 1.0, 0.8), Vec3::zeros()).unwrap();
        let body = sample(&b, Resolution::Spacing(0.5), &[]).unwrap();
        assert_eq!(body.cells.len(), 8);
        assert_relative_eq!(body.volume(), 0.8, epsilon = 1e-12);
    }

    #[test]
    fn unusable_spacings_say_what_would_work() {
        let ball = SphereShape::new(1.0, Vec3::zeros()).unwrap();
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 100.0, 1e-4, 1e-300] {
            let e = sample(&ball, Resolution::Spacing(bad), &[]).unwrap_err();
            assert_eq!(e.key, "body.spacing", "{bad}");
        }
        let e = sample(&ball, Resolution::Spacing(1e-4), &[]).unwrap_err();
        let smallest: f64 = e.remedy.rsplit(' ').next().unwrap().parse().unwrap();
        assert!(
            cells_around(&ball, smallest) <= MAX_CELLS && cells_around(&ball, 0.97 * smallest) > MAX_CELLS
        );
    }

    #[test]
    fn a_rounded_spacing_leaves_the_lattice_where_it_is() {
        let bar = BoxShape::new(Vec3::new(1.0, 0.4, 0.3), Vec3::zeros()).unwrap();
        let shape = crate::shape::MeshShape::new(bar.surface(), "mesh bar").unwrap().0;
        let at = |dx: f64| sample(&shape, Resolution::Spacing(dx), &[]).unwrap();
        let exact = at(1.0 / 30.0);
        for relative in [-1e-5, -1e-7, 1e-7, 1e-5] {
            let near = at((1.0 + relative) / 30.0);
            assert_eq!((&near.cells, near.volume), (&exact.cells, exact.volume.clone()), "{relative}");
        }
    }

    proptest! {
        /// A plane of cell centres lies where the alignment says, and the grid covers the body.
        #[test]
        fn alignment_is_kept(at in -3.0..3.0_f64, offset in -1.0..1.0_f64, dx in 0.07..0.4_f64, axis in 0..3_usize) {
            let ball = SphereShape::new(1.0, Vec3::new(0.3, -0.2, 0.1)).unwrap();
            let grid = lattice(&ball, dx, &[Alignment { axis, at, offset }]);
            let planes = (grid.centre([0; 3])[axis] - at) / dx - offset;
            prop_assert!((planes - planes.round()).abs() < 1e-6);
            let b = ball.bounds();
            let top = grid.origin + Vec3::from_fn(|i, _| grid.cells[i] as f64) * dx;
            for i in 0..3 {
                let overhang = OVERHANG * dx;
                prop_assert!(grid.origin[i] <= b.min[i] + overhang && top[i] >= b.max[i] - overhang);
            }
        }
    }
}
