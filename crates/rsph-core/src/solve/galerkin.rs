//! The next coarser level of a multigrid hierarchy: P^T A P with trilinear P between grids of twice the
//! distance.

use super::level::Level;
use super::nodes::{NO_NODE, NodeMap, offset, slot};
use crate::tensor::Mat3;
use rayon::prelude::*;
use std::ops::Range;

/// Nodes that one task works on.
const NODES_PER_TASK: usize = 256;

/// From the nodes of a level to those of the next coarser one.
#[derive(Clone, Debug)]
pub struct Coarsening {
    parents: Vec<[u32; 8]>,
    children: Vec<[u32; 27]>,
}

impl Coarsening {
    /// P^T of a field on the finer nodes.
    pub fn restrict(&self, fine: &[f32], coarse: &mut [f32]) {
        coarse.par_chunks_mut(3).with_min_len(NODES_PER_TASK).zip(&self.children).for_each(
            |(b, children)| {
                b.fill(0.0);
                for (s, &child) in children.iter().enumerate().filter(|(_, c)| **c != NO_NODE) {
                    for i in 0..3 {
                        b[i] += WEIGHTS[s] * fine[3 * child as usize + i];
                    }
                }
            },
        );
    }

    /// fine += P coarse in components for which `free` holds.
    pub fn prolong(&self, coarse: &[f32], fine: &mut [f32], free: impl Fn(usize) -> [bool; 3] + Sync) {
        fine.par_chunks_mut(3).zip(&self.parents).with_min_len(NODES_PER_TASK).enumerate().for_each(
            |(node, (x, parents))| {
                let there = parents.iter().filter(|p| **p != NO_NODE);
                let share = 1.0 / there.clone().count() as f32;
                let free = free(node);
                for i in (0..3).filter(|&i| free[i]) {
                    x[i] += share * there.clone().map(|&p| coarse[3 * p as usize + i]).sum::<f32>();
                }
            },
        );
    }
}

impl Level {
    /// The next coarser level, P^T A P with trilinear P between grids of twice the distance; `None` if it
    /// would not be smaller.
    pub fn coarser(&self) -> Option<(Coarsening, Self)> {
        let map = NodeMap::new(self.coordinates().iter().flat_map(|c| parent_places(*c)));
        if 2 * map.coordinates.len() > self.len() {
            return None;
        }
        let fine = NodeMap::new(self.coordinates().iter().copied());
        let children: Vec<[u32; 27]> = map
            .coordinates
            .iter()
            .map(|c| {
                std::array::from_fn(|s| {
                    let o = offset(s);
                    fine.node(std::array::from_fn(|i| 2 * c[i] + o[i]))
                })
            })
            .collect();
        let parents = self
            .coordinates()
            .iter()
            .map(|c| {
                let mut ids = [NO_NODE; 8];
                for (id, place) in ids.iter_mut().zip(parent_places(*c)) {
                    *id = map.node(place);
                }
                ids
            })
            .collect();
        let rows = |node: usize| {
            let mut row = [Mat3::zeros(); 27];
            for (s, &child) in children[node].iter().enumerate().filter(|(_, c)| **c != NO_NODE) {
                let from = offset(s);
                for t in 0..27 {
                    let Some(block) = self.block(child as usize, t) else { continue };
                    let block = block * f64::from(WEIGHTS[s]);
                    let o = offset(t);
                    let [x, y, z] = std::array::from_fn(|i| shares(from[i] + o[i]));
                    for (k, wz) in z.clone() {
                        for (j, wy) in y.clone() {
                            for (i, wx) in x.clone() {
                                row[slot([i, j, k])] += block * (wx * wy * wz);
                            }
                        }
                    }
                }
            }
            row
        };
        let mass: Vec<f64> = (0..map.coordinates.len())
            .flat_map(|node| {
                let mut sum = [0.0; 3];
                for (s, &child) in children[node].iter().enumerate().filter(|(_, c)| **c != NO_NODE) {
                    for i in 0..3 {
                        sum[i] += f64::from(WEIGHTS[s]) * self.mass(3 * child as usize + i);
                    }
                }
                sum
            })
            .collect();
        let level = Self::new(&map, rows, &mass);
        Some((Coarsening { parents, children }, level))
    }
}

/// Weight of the child in each slot: a half for each axis along which it stands aside.
const WEIGHTS: [f32; 27] = {
    let mut weights = [1.0; 27];
    let mut s = 0;
    while s < 27 {
        let aside = (s % 3 != 1) as u8 + (s / 3 % 3 != 1) as u8 + (s / 9 != 1) as u8;
        let mut k = 0;
        while k < aside {
            weights[s] *= 0.5;
            k += 1;
        }
        s += 1;
    }
    weights
};

/// Coarse coordinates, relative to a node, that a fine node `t` grid lines away depends on, with weights.
fn shares(t: i32) -> impl Iterator<Item = (i32, f64)> + Clone {
    let Range { start, end } = t.div_euclid(2)..(t + 1).div_euclid(2) + 1;
    let share = 1.0 / f64::from(end - start);
    (start..end).map(move |c| (c, share))
}

/// Coarse coordinates that the node at `c` depends on.
fn parent_places(c: [i32; 3]) -> impl Iterator<Item = [i32; 3]> + Clone {
    let range = move |i: usize| c[i].div_euclid(2)..(c[i] + 1).div_euclid(2) + 1;
    range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| [x, y, z])))
}
