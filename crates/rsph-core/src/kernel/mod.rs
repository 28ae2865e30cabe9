//! Interpolation kernels. One kernel a file.

mod lambda_4_2;
mod lambda_6_4;
mod m4_prime;
mod quartic_spline;
mod remesh;

pub use m4_prime::weights_and_slopes as m4_prime_weights_and_slopes;
pub use quartic_spline::QuarticSpline;
pub use remesh::{MAX_WEIGHTS, RemeshKernel};
