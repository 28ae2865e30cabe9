//! What every load becomes: a force on each particle, which may depend on the displacement, times a factor that depends on
//! time.

use super::follower::Follower;
use crate::setup::Curve;
use crate::tensor::Vec3;

/// A pattern of forces on the particles with its course in time.
#[derive(Clone, Debug)]
pub struct NodalLoad {
    pattern: Pattern,
    /// The factor.
    pub curve: Curve,
}

/// Forces on particles at factor 1.
#[derive(Clone, Debug)]
enum Pattern {
    /// On all, component by component (3 n values).
    All(Vec<f64>),
    /// On some, in rising order: loads on the surface of a large body leave most particles alone.
    Some(Vec<(u32, Vec3)>),
    /// On some, and they follow the deformed surface.
    Following(Box<Follower>),
}

impl Pattern {
    /// The forces on some particles, in rising order, where they are not on all.
    fn some(&self) -> Result<&[(u32, Vec3)], &[f64]> {
        match self {
            Self::All(force) => Err(force),
            Self::Some(some) => Ok(some),
            Self::Following(follower) => Ok(follower.forces()),
        }
    }
}

impl NodalLoad {
    /// The force on each particle at factor 1, component by component (3 n values).
    pub fn new(force: Vec<f64>, curve: Curve) -> Self {
        let n = force.len() / 3;
        let at = |a: usize| Vec3::new(force[a], force[n + a], force[2 * n + a]);
        let loaded = |a: &usize| at(*a) != Vec3::zeros();
        let count = (0..n).filter(loaded).count();
        let pattern = if 2 * count < n {
            let mut some = Vec::with_capacity(count);
            some.extend((0..n).filter(loaded).map(|a| (a as u32, at(a))));
            Pattern::Some(some)
        } else {
            Pattern::All(force)
        };
        Self { pattern, curve }
    }

    /// A load that follows the deformed surface.
    pub fn following(follower: Follower, curve: Curve) -> Self {
        Self { pattern: Pattern::Following(Box::new(follower)), curve }
    }

    /// Whether any of the loads depends on the displacement.
    pub fn any_follows(loads: &[Self]) -> bool {
        loads.iter().any(|load| matches!(load.pattern, Pattern::Following(_)))
    }

    /// Takes the forces at the displacement u, component by component, of the loads that depend on it.
    pub fn follow(loads: &mut [Self], u: &[f64]) {
        followers(loads).for_each(|(follower, _)| follower.follow(u));
    }

    /// Takes the displacement u, where that share of the loads of time `t` acts, as the state of [`Self::add_tangent`];
    /// without u there is none, and the tangent is zero.
    pub fn linearise(loads: &mut [Self], t: f64, share: f64, u: Option<&[f64]>) {
        followers(loads).for_each(|(follower, curve)| match u {
            Some(u) => follower.linearise(share * curve.at(t), u),
            None => follower.leave_out(),
        });
    }

    /// Adds `scale` D x to y, with D the symmetric part of the derivative of the forces by the displacement.
    pub fn add_tangent(loads: &mut [Self], scale: f64, x: &[f64], y: &mut [f64]) {
        followers(loads).for_each(|(follower, _)| follower.tangent(scale, x, y));
    }

    /// Adds the loads at time `t` on the particles from `first` on to their `forces`, a list for each
    /// component; `n` is the number of all particles.
    pub fn add(loads: &[Self], t: f64, n: usize, first: usize, forces: [&mut [f64]; 3]) {
        Self::add_times(loads, |curve| curve.at(t), n, first, forces);
    }

    /// Adds the loads, each times that factor.
    fn add_times(
        loads: &[Self],
        factor: impl Fn(&Curve) -> f64,
        n: usize,
        first: usize,
        forces: [&mut [f64]; 3],
    ) {
        let [x, y, z] = forces;
        let here = first..first + x.len();
        for load in loads {
            let factor = factor(&load.curve);
            if factor == 0.0 {
                continue;
            }
            match load.pattern.some() {
                Err(force) => {
                    for (i, sum) in [&mut *x, &mut *y, &mut *z].into_iter().enumerate() {
                        for (sum, f) in sum.iter_mut().zip(&force[i * n + first..]) {
                            *sum += factor * f;
                        }
                    }
                }
                Ok(some) => {
                    let from = some.partition_point(|(a, _)| (*a as usize) < here.start);
                    let inside = some[from..].iter().take_while(|(a, _)| (*a as usize) < here.end);
                    for (a, f) in inside {
                        let a = *a as usize - first;
                        (x[a], y[a], z[a]) = (x[a] + factor * f.x, y[a] + factor * f.y, z[a] + factor * f.z);
                    }
                }
            }
        }
    }

    /// Sum of all loads at time `t` into `total`, component by component.
    pub fn sum(loads: &[Self], t: f64, total: &mut [f64]) {
        Self::sum_times(loads, |curve| curve.at(t), total);
    }

    /// Sum of all loads into `total`, each at the largest magnitude that it has at any time.
    pub fn sum_of_peaks(loads: &[Self], total: &mut [f64]) {
        Self::sum_times(loads, Curve::peak, total);
    }

    fn sum_times(loads: &[Self], factor: impl Fn(&Curve) -> f64, total: &mut [f64]) {
        total.fill(0.0);
        let n = total.len() / 3;
        let (x, yz) = total.split_at_mut(n);
        let (y, z) = yz.split_at_mut(n);
        Self::add_times(loads, factor, n, 0, [x, y, z]);
    }

    /// Whether any of the loads acts on each of `n` particles; nothing if there are no loads.
    pub fn acting_on(loads: &[Self], n: usize) -> Vec<bool> {
        let mut marked = vec![false; if loads.is_empty() { 0 } else { n }];
        for load in loads {
            match load.pattern.some() {
                Err(force) => force.iter().enumerate().for_each(|(k, f)| marked[k % n] |= *f != 0.0),
                Ok(some) => some.iter().for_each(|(a, _)| marked[*a as usize] = true),
            }
        }
        marked
    }

    /// Total force at factor 1.
    pub fn total(&self) -> Vec3 {
        match self.pattern.some() {
            Err(force) => {
                let n = force.len() / 3;
                Vec3::from_fn(|i, _| force[i * n..(i + 1) * n].iter().sum())
            }
            Ok(some) => some.iter().map(|(_, f)| f).sum(),
        }
    }
}

/// The loads that depend on the displacement, with their curves.
fn followers(loads: &mut [NodalLoad]) -> impl Iterator<Item = (&mut Follower, &Curve)> {
    loads.iter_mut().filter_map(|load| match &mut load.pattern {
        Pattern::Following(follower) => Some((&mut **follower, &load.curve)),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Loads on few and on all particles add up, in pieces as in one.
    #[test]
    fn pieces_make_the_whole() {
        let n = 10;
        let mut few = vec![0.0; 3 * n];
        (few[3], few[n + 3], few[2 * n + 7]) = (1.0, -2.0, 4.0);
        let all: Vec<f64> = (0..3 * n).map(|i| i as f64).collect();
        let [curve, same] = [Curve::default(), Curve::default()];
        let loads = [NodalLoad::new(few.clone(), curve), NodalLoad::new(all.clone(), same)];
        assert!(matches!(loads[0].pattern, Pattern::Some(_)) && matches!(loads[1].pattern, Pattern::All(_)));
        assert_eq!(loads[0].total(), Vec3::new(1.0, -2.0, 4.0));
        let mut whole = vec![0.0; 3 * n];
        NodalLoad::sum(&loads, 0.0, &mut whole);
        assert!((0..3 * n).all(|i| whole[i] == few[i] + all[i]));
        for (first, len) in [(0, 4), (4, 4), (8, 2)] {
            let [mut x, mut y, mut z] = [vec![0.0; len], vec![0.0; len], vec![0.0; len]];
            NodalLoad::add(&loads, 0.0, n, first, [&mut x, &mut y, &mut z]);
            assert_eq!((&x[..], &y[..]), (&whole[first..first + len], &whole[n + first..n + first + len]));
            assert_eq!(z[..], whole[2 * n + first..2 * n + first + len]);
        }
    }
}
