//! What the sums over neighbours read of a point, packed so that one neighbour is one or two cache lines, and
//! arithmetic on four numbers at once. The compiler turns it into vector instructions of whatever set the sum
//! runs with.

use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// Points that a thread packs at once.
const CHUNK: usize = 1024;

/// Three components and one more number.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Quad(pub [f64; 4]);

impl Quad {
    /// `v` and `last`.
    #[inline(always)]
    pub fn new(v: &Vec3, last: f64) -> Self {
        Self([v.x, v.y, v.z, last])
    }

    /// The first three.
    #[inline(always)]
    pub fn vector(self) -> Vec3 {
        Vec3::new(self.0[0], self.0[1], self.0[2])
    }

    /// self - other
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        let mut difference = self;
        for i in 0..4 {
            difference.0[i] -= other.0[i];
        }
        difference
    }

    /// self += factor other
    #[inline(always)]
    pub fn add(&mut self, factor: f64, other: Self) {
        for i in 0..4 {
            self.0[i] += factor * other.0[i];
        }
    }
}

/// The columns of a matrix, with a number beside each.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Columns(pub [Quad; 3]);

impl Columns {
    /// `m` and `beside`.
    #[inline(always)]
    pub fn new(m: &Mat3, beside: &Vec3) -> Self {
        Self(std::array::from_fn(|j| Quad([m[(0, j)], m[(1, j)], m[(2, j)], beside[j]])))
    }

    /// The matrix.
    #[inline(always)]
    pub fn matrix(&self) -> Mat3 {
        Mat3::from_fn(|i, j| self.0[j].0[i])
    }

    /// self += z (x) x
    #[inline(always)]
    pub fn add_product(&mut self, z: Quad, x: [f64; 3]) {
        for j in 0..3 {
            self.0[j].add(x[j], z);
        }
    }
}

/// A point of a gradient: (place, volume) and (value, 0).
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Sample {
    /// Place and volume.
    pub place: Quad,
    /// Value.
    pub value: Quad,
}

/// A point of a force.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Source {
    /// T beside xi.
    pub tensor: Columns,
    /// (z, V).
    pub value: Quad,
}

/// Packed points, kept to avoid allocation.
#[derive(Clone, Debug, Default)]
pub struct Packed {
    samples: Vec<Sample>,
    sources: Vec<Source>,
    springs: Vec<Columns>,
}

/// The first `len` of `list`, made by `of`.
fn pack<T: Copy + Default + Send>(list: &mut Vec<T>, len: usize, of: impl Fn(usize) -> T + Sync) -> &[T] {
    list.resize(len, T::default());
    list.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(p, packed)| *packed = of(p));
    list
}

impl Packed {
    /// A field at places.
    pub(super) fn samples(&mut self, place: &[Vec3], volume: &[f64], value: &[Vec3]) -> &[Sample] {
        pack(&mut self.samples, place.len(), |p| Sample {
            place: Quad::new(&place[p], volume[p]),
            value: Quad::new(&value[p], 0.0),
        })
    }

    /// What points pull with, and their hourglass springs if `springs` says so.
    pub(super) fn sources(
        &mut self,
        len: usize,
        source: impl Fn(usize) -> Source + Sync,
        springs: Option<impl Fn(usize) -> Columns + Sync>,
    ) -> (&[Source], &[Columns]) {
        let springs = match springs {
            Some(of) => pack(&mut self.springs, len, of),
            None => &[],
        };
        (pack(&mut self.sources, len, source), springs)
    }
}
