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
    /// Of the kernel with smoothing length `h`.
    pub fn new(spacing: f64, h: f64) -> Self {
        let kernel = QuarticSpline::<3>::new(h);
        let mut weights = Self { spacing, cut: 0, by_square: [0.0; MAX_CUT + 1] };
        for square in 1..=MAX_CUT {
            let r = (square as f64).sqrt() * spacing;
            // Neighbours at the very edge of the support have weight zero.
            if r < kernel.support() * (1.0 - 1e-9) {
                weights.by_square[square] = kernel.gradient_weight(r);
                weights.cut = square;
            }
        }
        weights
    }
}
