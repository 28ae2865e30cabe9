//! Which offsets a kernel sum visits. Neighbours lie at whole-number offsets o, and the weight of one
//! depends on |o|^2 only: whether it counts is decided by a largest |o|^2, the *cut*.

/// A cut, known to the compiler where that pays.
pub trait Stencil: Copy + Send + Sync {
    /// Largest |o|^2 with a weight.
    fn cut(self) -> usize;

    /// Largest |o| along an axis.
    fn reach(self) -> usize;

    /// Visits the offsets 0 to reach along an axis.
    fn for_each_distance(self, visit: impl FnMut(usize));

    /// Visits the offsets -reach to reach along an axis.
    fn for_each_offset(self, visit: impl FnMut(isize));
}

/// A cut below 16, known when compiling: the offsets are written out one by one, since loops around that much work
/// are not unrolled, and what is summed stays in registers.
#[derive(Clone, Copy, Debug)]
pub struct Fixed<const CUT: usize>;

impl<const CUT: usize> Stencil for Fixed<CUT> {
    #[inline(always)]
    fn cut(self) -> usize {
        CUT
    }

    #[inline(always)]
    fn reach(self) -> usize {
        const {
            assert!(CUT < 16);
            CUT.isqrt()
        }
    }

    #[inline(always)]
    fn for_each_distance(self, mut visit: impl FnMut(usize)) {
        visit(0);
        if self.reach() >= 1 {
            visit(1);
        }
        if self.reach() >= 2 {
            visit(2);
        }
        if self.reach() >= 3 {
            visit(3);
        }
    }

    #[inline(always)]
    fn for_each_offset(self, mut visit: impl FnMut(isize)) {
        if self.reach() >= 3 {
            visit(-3);
        }
        if self.reach() >= 2 {
            visit(-2);
        }
        if self.reach() >= 1 {
            visit(-1);
        }
        self.for_each_distance(
            #[inline(always)]
            |d| visit(d as isize),
        );
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

    #[inline(always)]
    fn for_each_distance(self, mut visit: impl FnMut(usize)) {
        for d in 0..=self.reach() {
            visit(d);
        }
    }

    #[inline(always)]
    fn for_each_offset(self, mut visit: impl FnMut(isize)) {
        let reach = self.reach() as isize;
        for d in -reach..=reach {
            visit(d);
        }
    }
}
