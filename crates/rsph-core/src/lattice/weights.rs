//! The kernel on the lattice: weights by squared distance.

use crate::kernel::QuarticSpline;

/// Largest reach of the kernel, in cells: h = 2 dx.
pub const MAX_REACH: usize = 4;
/// Largest |o|^2 that a kernel may see.
pub const MAX_CUT: usize = (MAX_REACH + 1) * (MAX_REACH + 1) - 1;

/// Weights of a kernel on the lattice.
#[derive(Clone, Debug)]
pub struct Weights {
    /// Spacing dx.
    pub spacing: f64,
    /// Largest |o|^2 with a weight.
    pub cut: usize,
    /// w(r) = -W'(r)/r by |o|^2 = r^2 / dx^2; zero for the particle itself and beyond the support.
    pub by_square: [f64; MAX_CUT + 1],
}

impl Weights {
    /// Of the kernel with smoothing length `h` in 3 or 2 dimensions.
    ///
    /// A body in the plane is one layer of a body that goes on along z for ever and moves alike everywhere: its weights
    /// are the sums over all layers, of the height dx, and those of a cell of height one.
    pub fn new(spacing: f64, h: f64, dimension: usize) -> Self {
        let kernel = QuarticSpline::<3>::new(h);
        let mut weights = Self { spacing, cut: 0, by_square: [0.0; MAX_CUT + 1] };
        let weight = |square: usize| {
            let r = (square as f64).sqrt() * spacing;
            // Neighbours at the very edge of the support have weight zero.
            if r < kernel.support() * (1.0 - 1e-9) { kernel.gradient_weight(r) } else { 0.0 }
        };
        for square in 1..=MAX_CUT {
            weights.by_square[square] = if dimension == 2 {
                let beside = |k: usize| 2.0 * weight(square + k * k);
                spacing * (weight(square) + (1..=MAX_REACH).map(beside).sum::<f64>())
            } else {
                weight(square)
            };
            if weights.by_square[square] > 0.0 {
                weights.cut = square;
            }
        }
        weights
    }
}
