//! Mirror planes that lie on cell faces. What stands behind one is the image of what stands before it,
//! and an image lies on the lattice too: the passes of a sweep take the sums of the row or plane that is
//! mirrored, with a sign for each component.

/// Largest number of folds: both ends of each axis.
pub const MAX_FOLDS: usize = 6;

/// A mirror plane on a cell face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fold {
    /// Normal axis 0, 1, 2.
    pub axis: usize,
    /// Index along the axis of the first cell above it.
    pub face: isize,
    /// Whether the body lies above it.
    pub above: bool,
    /// Sign with which each component of a vector is mirrored.
    pub sign: [f64; 3],
}

/// All folds of a lattice, by axis, with their numbers, which count from 1.
#[derive(Clone, Debug, Default)]
pub struct Folds([Vec<(usize, Fold)>; 3]);

impl Folds {
    /// These, [`MAX_FOLDS`] at most: others are left out.
    pub fn new(folds: &[Fold]) -> Self {
        let numbered = || (1..=MAX_FOLDS).zip(folds.iter().copied());
        Self(std::array::from_fn(|axis| numbered().filter(|(_, fold)| fold.axis == axis).collect()))
    }

    /// The cell whose image stands in `cell` along `axis`, and the number of the fold between them: the
    /// cell itself and 0 where there is none.
    #[inline(always)]
    pub fn source(&self, axis: usize, cell: isize) -> (isize, usize) {
        for (number, fold) in &self.0[axis] {
            if (cell < fold.face) == fold.above {
                return (2 * fold.face - 1 - cell, *number);
            }
        }
        (cell, 0)
    }

    /// Signs of the components by number of the fold.
    pub fn signs(&self) -> Signs {
        let mut signs = [[1.0; 3]; MAX_FOLDS + 1];
        for (number, fold) in self.0.iter().flatten() {
            signs[*number] = fold.sign;
        }
        signs
    }

    /// The folds along x.
    #[inline(always)]
    pub fn along_x(&self) -> impl Iterator<Item = &Fold> {
        self.0[0].iter().map(|(_, fold)| fold)
    }
}

/// Signs of the components by number of the fold; number 0 is none.
pub type Signs = [[f64; 3]; MAX_FOLDS + 1];
