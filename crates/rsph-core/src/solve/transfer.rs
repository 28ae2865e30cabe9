//! Between particles and the nodes of the first coarse level: trilinear interpolation on blocks of two
//! cells a side.

use super::hexahedra::corner;
use super::nodes::{NO_NODE, NodeMap, offset};
use crate::dynamics::solid::Solid;
use crate::lattice::NO_PARTICLE;
use crate::tensor::Vec3;
use rayon::prelude::*;

/// Cells along the edge of a block.
pub const BLOCK: usize = 2;
const NODES_PER_TASK: usize = 128;
const BLOCKS_PER_TASK: usize = 128;
const PARTICLES_PER_TASK: usize = 1024;

/// The blocks of a body and what they connect.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// Which block is where.
    blocks: NodeMap,
    /// The nodes: corners of blocks that hold a particle.
    pub nodes: NodeMap,
    /// The eight nodes of every block, x fastest.
    pub nodes_of: Vec<[u32; 8]>,
    /// The eight particles of every block, x fastest.
    pub particles_of: Vec<[u32; 8]>,
    /// The eight blocks around every node: block k has the node as its corner 7 - k.
    pub blocks_of: Vec<[u32; 8]>,
    block_and_place: Vec<(u32, u8)>,
    /// Weight of the particle in place k for corner c: `weights[k][c]`.
    weights: [[f64; 8]; 8],
    /// Work space: the corners or particles of every block, x y z, with a block of zeros at its end.
    of_block: Vec<[f32; 24]>,
}

impl Transfer {
    /// The blocks of `solid`'s lattice.
    pub fn new(solid: &Solid) -> Self {
        let lattice = &solid.lattice;
        let cells: Vec<[usize; 3]> = (0..lattice.len()).map(|a| lattice.coordinates(a)).collect();
        let block_place = |c: &[usize; 3]| c.map(|x| (x / BLOCK) as i32);
        let blocks = NodeMap::new(cells.iter().map(block_place));
        let mut particles_of = vec![[NO_PARTICLE; 8]; blocks.coordinates.len()];
        let block_and_place: Vec<(u32, u8)> = cells
            .iter()
            .enumerate()
            .map(|(a, c)| {
                let block = blocks.node(block_place(c));
                let place = c[0] % BLOCK + 2 * (c[1] % BLOCK) + 4 * (c[2] % BLOCK);
                particles_of[block as usize][place] = a as u32;
                (block, place as u8)
            })
            .collect();
        // In the plane the upper corners of a block are its lower ones.
        let at = |c: &[i32; 3], k: usize| {
            let o = corner(k);
            std::array::from_fn(|i| if i < lattice.dimension { c[i] + o[i] as i32 } else { c[i] })
        };
        let nodes = NodeMap::new(blocks.coordinates.iter().flat_map(|c| (0..8).map(move |k| at(c, k))));
        let nodes_of: Vec<[u32; 8]> =
            blocks.coordinates.iter().map(|c| std::array::from_fn(|k| nodes.node(at(c, k)))).collect();
        let mut blocks_of = vec![[NO_NODE; 8]; nodes.coordinates.len()];
        for (block, corners) in nodes_of.iter().enumerate() {
            for (k, &node) in corners.iter().enumerate() {
                blocks_of[node as usize][7 - k] = block as u32;
            }
        }
        let weights = std::array::from_fn(|place| {
            std::array::from_fn(|k| {
                let (p, c) = (corner(place), corner(k));
                let share = |i: usize| if p[i] == c[i] { 0.75 } else { 0.25 };
                share(0) * share(1) * share(2)
            })
        });
        let of_block = vec![[0.0; 24]; particles_of.len() + 1];
        Self { blocks, nodes, nodes_of, particles_of, blocks_of, block_and_place, weights, of_block }
    }

    /// The corners of the block nearest to the place `x` of the lattice of `solid`, with their trilinear weights at
    /// the place in the block that is nearest to it; `None` far from all blocks.
    pub fn corners_at(&self, solid: &Solid, x: &Vec3) -> Option<[(u32, f64); 8]> {
        let q = (x - solid.lattice.origin) / (BLOCK as f64 * solid.lattice.spacing);
        let home = q.map(f64::floor);
        let candidates = (0..27).filter_map(|s| {
            let o = offset(s);
            let place: [i32; 3] = std::array::from_fn(|i| home[i] as i32 + o[i]);
            let block = self.blocks.node(place);
            let inside = Vec3::from_fn(|i, _| (q[i] - f64::from(place[i])).clamp(0.0, 1.0));
            let nearest = Vec3::from_fn(|i, _| f64::from(place[i])) + inside;
            (block != NO_NODE).then(|| (block, inside, (q - nearest).norm()))
        });
        let (block, inside, _) = candidates.min_by(|a, b| a.2.total_cmp(&b.2))?;
        Some(std::array::from_fn(|k| {
            let c = corner(k);
            let weight = (0..3).map(|i| if c[i] == 1 { inside[i] } else { 1.0 - inside[i] }).product();
            (self.nodes_of[block as usize][k], weight)
        }))
    }

    /// Visits (particle, weight) of the particles around a node, always in the same order.
    pub fn around(&self, node: usize, mut visit: impl FnMut(usize, f64)) {
        for (k, &block) in self.blocks_of[node].iter().enumerate().filter(|(_, b)| **b != NO_NODE) {
            for (place, &a) in self.particles_of[block as usize].iter().enumerate() {
                if a != NO_PARTICLE {
                    visit(a as usize, self.weights[place][7 - k]);
                }
            }
        }
    }

    /// P^T scale (b - y) of fields on the particles (component by component) into one on the nodes (node by
    /// node).
    pub fn restrict(&mut self, scale: f64, b: &[f64], y: &[f64], nodes: &mut [f32]) {
        let n = self.block_and_place.len();
        let Self { of_block, particles_of, blocks_of, .. } = self;
        of_block.par_iter_mut().zip(&*particles_of).with_min_len(BLOCKS_PER_TASK).for_each(
            |(corners, particles)| {
                corners.fill(0.0);
                for (place, &a) in particles.iter().enumerate().filter(|(_, a)| **a != NO_PARTICLE) {
                    for i in 0..3 {
                        let at = i * n + a as usize;
                        corners[3 * place + i] = (scale * (b[at] - y[at])) as f32;
                    }
                }
                interpolate(corners);
            },
        );
        let none = of_block.len() - 1;
        nodes.par_chunks_mut(3).zip(&*blocks_of).with_min_len(NODES_PER_TASK).for_each(|(out, blocks)| {
            let mut sum = [0.0; 3];
            for (k, &block) in blocks.iter().enumerate() {
                let corners = &of_block[(block as usize).min(none)];
                for i in 0..3 {
                    sum[i] += corners[3 * (7 - k) + i];
                }
            }
            out.copy_from_slice(&sum);
        });
    }

    /// field += scale P nodes in components for which `free(particle, component)` holds.
    pub fn prolong(
        &mut self,
        scale: f64,
        nodes: &[f32],
        field: &mut [f64],
        free: impl Fn(usize, usize) -> bool + Sync,
    ) {
        let n = self.block_and_place.len();
        let Self { of_block, nodes_of, block_and_place, .. } = self;
        of_block.par_iter_mut().zip(&*nodes_of).with_min_len(BLOCKS_PER_TASK).for_each(
            |(values, nodes_of)| {
                for (value, &node) in values.chunks_exact_mut(3).zip(nodes_of) {
                    value.copy_from_slice(&nodes[3 * node as usize..3 * node as usize + 3]);
                }
                interpolate(values);
            },
        );
        let (x, yz) = field.split_at_mut(n);
        let (y, z) = yz.split_at_mut(n);
        (x, y, z, &*block_and_place).into_par_iter().with_min_len(PARTICLES_PER_TASK).enumerate().for_each(
            |(a, (x, y, z, &(block, place)))| {
                let value = &of_block[block as usize][3 * place as usize..3 * place as usize + 3];
                for (i, to) in [x, y, z].into_iter().enumerate() {
                    if free(a, i) {
                        *to += scale * f64::from(value[i]);
                    }
                }
            },
        );
    }
}

/// Trilinear interpolation between the eight corners of a block and the middles of its eight cells, which
/// is its own transpose: along each axis 3/4 of the near value and 1/4 of the far one.
fn interpolate(values: &mut [f32; 24]) {
    for distance in [3, 6, 12] {
        for i in (0..24).filter(|i| i / distance % 2 == 0) {
            let (near, far) = (values[i], values[i + distance]);
            values[i] = 0.75 * near + 0.25 * far;
            values[i + distance] = 0.25 * near + 0.75 * far;
        }
    }
}
