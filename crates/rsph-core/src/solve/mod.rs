//! Linear systems of the solid: (m M + c K) x = b by conjugate gradients, preconditioned by one
//! V-cycle of geometric multigrid. No fine matrix is assembled; sums have a fixed order, so that results do
//! not depend on the number of threads.

pub mod blocks;
pub mod cg;
pub mod direct;
pub mod galerkin;
pub mod hexahedra;
pub mod initial_guess;
pub mod jacobi;
pub mod level;
pub mod linear;
pub mod multigrid;
pub mod newton;
pub mod nodes;
pub mod operator;
pub mod rigid;
pub mod spectrum;
pub mod sums;
pub mod transfer;
