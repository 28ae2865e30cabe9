//! Bodies for the tests of the operator.
#![allow(dead_code)]

use rsph_core::boundary::fixed::Fixed;
use rsph_core::boundary::mirror::{Mirror, MirrorPlane};
use rsph_core::dynamics::elastic::Elastic;
use rsph_core::grid::Grid;
use rsph_core::lattice::Lattice;
use rsph_core::material::KelvinVoigt;
use rsph_core::tensor::Vec3;
use std::sync::Arc;

/// A reproducible stream of numbers in [-0.5, 0.5).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }

    pub fn column(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// Relaxation time of the test bodies.
pub const T: f64 = 0.2;

/// A solid with its positions.
pub struct TestBody {
    pub elastic: Elastic,
    pub positions: Vec<Vec3>,
    pub spacing: f64,
}

/// A body of the cells for which `fraction` is positive, with E = 100, nu = `nu`.
pub fn body(
    cells: [usize; 3],
    spacing: f64,
    smoothing: f64,
    hourglass: f64,
    nu: f64,
    planes: Vec<MirrorPlane>,
    fraction: impl Fn(&Vec3) -> f64,
) -> TestBody {
    let grid = Grid { origin: Vec3::zeros(), spacing, cells };
    let mut occupied = Vec::new();
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                if fraction(&grid.centre([i, j, k])) > 0.0 {
                    occupied.push([i, j, k]);
                }
            }
        }
    }
    let positions: Vec<Vec3> = occupied.iter().map(|c| grid.centre(*c)).collect();
    let volume: Vec<f64> = positions.iter().map(|x| fraction(x) * spacing.powi(3)).collect();
    let lattice = Lattice::new(&grid, &occupied, smoothing);
    let mirror = Mirror::new(&lattice, &positions, planes, |_| true);
    let material = Arc::new(KelvinVoigt::new(1.0, 100.0, nu, T).unwrap());
    let elastic = Elastic::new(lattice, &volume, mirror, Fixed::default(), material, hourglass);
    TestBody { elastic, positions, spacing }
}

/// A clamp at z = 0.
pub fn clamp() -> MirrorPlane {
    MirrorPlane { axis: 2, at: 0.0, fix: [true; 3], motion: None }
}

/// The cube of n^3 particles clamped at z = 0.
pub fn clamped_cube(n: usize, smoothing: f64, hourglass: f64, nu: f64) -> TestBody {
    body([n; 3], 1.0 / n as f64, smoothing, hourglass, nu, vec![clamp()], |_| 1.0)
}

/// A ball with cut cells, some of them small: a body with nothing flat.
pub fn ball(smoothing: f64) -> TestBody {
    let (n, dx) = (11, 0.1);
    body([n; 3], dx, smoothing, 0.1, 0.3, Vec::new(), move |x| {
        let depth = 0.47 - (x - Vec3::repeat(0.55)).norm();
        let f = (depth / dx + 0.5).clamp(0.0, 1.0);
        if f < 0.1 { 0.0 } else { f }
    })
}

/// Conjugate gradients for K u = f.
pub fn solve(elastic: &mut Elastic, load: &[f64]) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut x = vec![0.0; load.len()];
    let mut r = load.to_vec();
    elastic.fixed.zero(&mut r, load.len() / 3);
    let mut p = r.clone();
    let mut q = vec![0.0; load.len()];
    let mut rr = dot(&r, &r);
    let goal = 1e-18 * rr;
    while rr > goal {
        elastic.force_of(&p, &mut q);
        let alpha = -rr / dot(&p, &q);
        for i in 0..x.len() {
            x[i] += alpha * p[i];
            r[i] += alpha * q[i];
        }
        let next = dot(&r, &r);
        for i in 0..x.len() {
            p[i] = r[i] + next / rr * p[i];
        }
        rr = next;
    }
    x
}
