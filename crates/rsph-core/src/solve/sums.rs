//! Vector updates and inner products in chunks of fixed length, so that a sum has the same order for any
//! number of threads.

use rayon::prelude::*;

/// Values of one partial sum.
pub const CHUNK: usize = 4096;
/// Fewest chunks of a task: a smaller one costs less than to hand it over.
const CHUNKS_PER_TASK: usize = 4;

/// Partial sums, allocated once.
#[derive(Clone, Debug)]
pub struct Sums {
    partial: Vec<f64>,
}

impl Sums {
    /// For vectors of `len` values.
    pub fn new(len: usize) -> Self {
        Self { partial: vec![0.0; len.div_ceil(CHUNK)] }
    }

    /// x . y
    pub fn dot(&mut self, x: &[f64], y: &[f64]) -> f64 {
        (&mut self.partial, x.par_chunks(CHUNK), y.par_chunks(CHUNK))
            .into_par_iter()
            .with_min_len(CHUNKS_PER_TASK)
            .for_each(|(sum, x, y)| *sum = plain_dot(x, y));
        self.partial.iter().sum()
    }

    /// |x|
    pub fn norm(&mut self, x: &[f64]) -> f64 {
        self.dot(x, x).sqrt()
    }

    /// x += alpha p, r -= alpha q; returns r . r
    pub fn advance(&mut self, alpha: f64, x: &mut [f64], p: &[f64], r: &mut [f64], q: &[f64]) -> f64 {
        let n = CHUNK;
        (&mut self.partial, x.par_chunks_mut(n), p.par_chunks(n), r.par_chunks_mut(n), q.par_chunks(n))
            .into_par_iter()
            .with_min_len(CHUNKS_PER_TASK)
            .for_each(|(sum, x, p, r, q)| {
                for (((x, p), r), q) in x.iter_mut().zip(p).zip(r.iter_mut()).zip(q) {
                    *x += alpha * p;
                    *r -= alpha * q;
                }
                *sum = plain_dot(r, r);
            });
        self.partial.iter().sum()
    }
}

/// y = a x + b y; where b is 0, y may hold anything.
pub fn combine(a: f64, x: &[f64], b: f64, y: &mut [f64]) {
    y.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).with_min_len(CHUNKS_PER_TASK).for_each(|(y, x)| {
        if b == 0.0 {
            y.iter_mut().zip(x).for_each(|(y, x)| *y = a * x);
        } else {
            y.iter_mut().zip(x).for_each(|(y, x)| *y = a * x + b * *y);
        }
    });
}

/// Eight running sums: short dependency chains, and an order that does not depend on the compiler.
pub fn plain_dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sum = [0.0; 8];
    let (xs, ys) = (x.chunks_exact(8), y.chunks_exact(8));
    let rest: f64 = xs.remainder().iter().zip(ys.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in xs.zip(ys) {
        for i in 0..8 {
            sum[i] += x[i] * y[i];
        }
    }
    sum.iter().sum::<f64>() + rest
}

/// A reproducible field of numbers in [-0.5, 0.5), as a start for eigenvalue estimates.
pub fn noise(values: &mut [f64]) {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    for v in values {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        *v = (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
    }
}
