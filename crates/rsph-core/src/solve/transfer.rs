//! Between particles and the nodes of the first coarse level: trilinear interpolation on blocks of two
//! cells a side.

use super::hexahedra::corner;
use super::level::{NO_NODE, NodeMap};
use crate::dynamics::elastic::Elastic;
use crate::lattice::NO_PARTICLE;
use rayon::prelude::*;

/// Cells along the edge of a block.
pub const BLOCK: usize = 2;
const NODES_A_TASK: usize = 128;
const PARTICLES_A_TASK: usize = 1024;

/// The blocks of a body and what they connect.
#[derive(Clone, Debug)]
pub struct Transfer {
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
}

impl Transfer {
    /// The blocks of `elastic`'s lattice.
    pub fn new(elastic: &Elastic) -> Self {
        let lattice = &elastic.lattice;
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
        let at = |c: &[i32; 3], k: usize| {
            let o = corner(k);
            std::array::from_fn(|i| c[i] + o[i] as i32)
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
        Self { nodes, nodes_of, particles_of, blocks_of, block_and_place, weights }
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

    /// P^T of a field on the particles (component by component) into one on the nodes (node by node).
    pub fn restrict(&self, field: &[f64], nodes: &mut [f64]) {
        let n = self.block_and_place.len();
        nodes.par_chunks_mut(3).with_min_len(NODES_A_TASK).enumerate().for_each(|(node, out)| {
            let mut sum = [0.0; 3];
            self.around(node, |a, w| {
                for i in 0..3 {
                    sum[i] += w * field[i * n + a];
                }
            });
            out.copy_from_slice(&sum);
        });
    }

    /// field += P nodes
    pub fn prolong(&self, nodes: &[f64], field: &mut [f64]) {
        let n = self.block_and_place.len();
        let (x, yz) = field.split_at_mut(n);
        let (y, z) = yz.split_at_mut(n);
        (x, y, z, &self.block_and_place).into_par_iter().with_min_len(PARTICLES_A_TASK).for_each(
            |(x, y, z, &(block, place))| {
                let mut sum = [0.0; 3];
                for (&node, w) in self.nodes_of[block as usize].iter().zip(&self.weights[place as usize]) {
                    for i in 0..3 {
                        sum[i] += w * nodes[3 * node as usize + i];
                    }
                }
                (*x, *y, *z) = (*x + sum[0], *y + sum[1], *z + sum[2]);
            },
        );
    }
}
