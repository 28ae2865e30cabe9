//! The external body force f_ext of Eq. (2): an acceleration such as gravity.

use crate::region::Region;
use crate::tensor::Vec3;

/// m a on every particle inside `region`, component by component; `None` when it holds none.
pub fn body_force(
    mass: &[f64],
    positions: &[Vec3],
    region: &Region,
    acceleration: &Vec3,
    tolerance: f64,
) -> Option<Vec<f64>> {
    let n = mass.len();
    let mut force = vec![0.0; 3 * n];
    let mut any = false;
    for (a, x) in positions.iter().enumerate().filter(|(_, x)| region.contains(x, tolerance)) {
        any = true;
        debug_assert!(x.iter().all(|c| c.is_finite()));
        for i in 0..3 {
            force[i * n + a] = mass[a] * acceleration[i];
        }
    }
    any.then_some(force)
}
