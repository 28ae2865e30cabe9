//! Interpolation kernels. One kernel a file.

mod quartic_spline;

pub use quartic_spline::QuarticSpline;
