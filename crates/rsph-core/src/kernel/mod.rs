//! Interpolation kernels. One kernel a file.

mod lambda_4_2;
mod lambda_6_4;
mod m4_prime;
mod quartic_spline;
mod remesh;

pub use quartic_spline::QuarticSpline;
pub use remesh::{MAX_WEIGHTS, RemeshKernel};
