//! Which offsets a kernel sum visits. Neighbours lie at whole-number offsets o, and the weight of one
//! depends on |o|^2 only: whether it counts is decided by a largest |o|^2, the *cut*.

/// A cut, known to the compiler where that pays.
pub trait Stencil: Copy + Send + Sync {
    /// Largest |o|^2 with a weight.
    fn cut(self) -> usize;

    /// Largest |o| along an axis.
    fn reach(self) -> usize;
}

/// A cut known when compiling: the loops over offsets unroll.
#[derive(Clone, Copy, Debug)]
pub struct Fixed<const CUT: usize>;

impl<const CUT: usize> Stencil for Fixed<CUT> {
    #[inline(always)]
    fn cut(self) -> usize {
        CUT
    }

    #[inline(always)]
    fn reach(self) -> usize {
        const { CUT.isqrt() }
    }
}

/// Any other cut.
#[derive(Clone, Copy, Debug)]
pub struct Any(pub usize);

impl Stencil for Any {
    fn cut(self) -> usize {
        self.0
    }

    fn reach(self) -> usize {
        self.0.isqrt()
    }
}
