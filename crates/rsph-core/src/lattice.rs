//! The sparse lattice of the last remesh: the home of every kernel sum.
//!
//! Between remeshings the particles keep their place on a regular lattice, so that the neighbours of
//! a particle are constant index offsets and the kernel gradient is one constant vector an offset:
//! no neighbour list. Fields that sums run over are laid out in tiles ([`crate::tiles`]).

mod cuts;
mod weights;

use crate::grid::Grid;
use crate::tensor::Vec3;
use crate::tiles::{LANES, Tiles};
pub use cuts::{Cut, Cuts};
use rayon::prelude::*;
pub use weights::{MAX_CUT, MAX_REACH, Weights};

/// Marks a cell without a particle.
pub const NO_PARTICLE: u32 = u32::MAX;

/// An offset with a weight.
#[derive(Clone, Copy, Debug)]
pub struct Neighbour {
    /// Cells of the padded box between the particle and this neighbour.
    pub shift: isize,
    /// X = x_b - x_a.
    pub x: Vec3,
    /// w(r) = -W'(r)/r.
    pub w: f64,
}

/// A plane between two layers of cells, in which the particles beside it have mirror images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mirror {
    /// Normal axis.
    pub axis: usize,
    /// Whether the images lie above it.
    pub above: bool,
    /// The first layer of cells above it, in (unpadded) coordinates.
    pub layer: isize,
}

impl Mirror {
    /// Its bit in a set of mirrors.
    pub fn bit(&self) -> u8 {
        1 << (2 * self.axis + usize::from(self.above))
    }
}

/// Number of sets of mirrors: one plane below and one above on every axis.
pub const MIRROR_SETS: usize = 1 << 6;

/// Whether a set of mirrors has one on that axis.
pub fn has_mirror(mirrors: u8, axis: usize) -> bool {
    mirrors & (3 << (2 * axis)) != 0
}

/// Diagonal of the reflection in a set of mirrors.
pub fn reflection(mirrors: u8) -> Vec3 {
    Vec3::from_fn(|i, _| if has_mirror(mirrors, i) { -1.0 } else { 1.0 })
}

/// The mirror image of a particle, in a cell that holds none.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// The particle.
    pub particle: u32,
    /// In which mirrors, a set.
    pub mirrors: u8,
    tile: u32,
    lane: u8,
}

impl Image {
    /// Tile and lane of its cell.
    #[inline(always)]
    pub fn place(&self) -> (usize, usize) {
        (self.tile as usize, self.lane as usize)
    }
}

/// What a particle sees at a place around it.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// A particle, or that of the image there.
    pub particle: usize,
    /// The mirrors of the image; none for the particle itself.
    pub mirrors: u8,
    /// Tile of the cell.
    pub tile: usize,
}

/// The lattice with its stencil and its particles.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Lower corner of the cell (0, 0, 0).
    pub origin: Vec3,
    /// Spacing dx.
    pub spacing: f64,
    /// Smoothing length h.
    pub smoothing_length: f64,
    /// The particles, tile by tile.
    pub tiles: Tiles,
    /// Weights of the kernel by distance.
    pub weights: Weights,
    /// Neighbours with a weight.
    pub neighbours: Vec<Neighbour>,
    /// Neighbours that do not see each other across a gap.
    pub cuts: Cuts,
    /// Images of particles in mirrors, by tile.
    pub images: Vec<Image>,
    /// The first image of every tile, and their number; nothing if there are none.
    image_starts: Vec<u32>,
    /// Particle of every cell of the padded box, or [`NO_PARTICLE`]; from their number on, images.
    particle_at: Vec<u32>,
    /// Cell of the padded box of every particle.
    cell_of: Vec<u32>,
    /// Second moment sum_b V_b w X_x^2 of a full neighbourhood, the same along every axis that is there.
    pub full_moment: f64,
    /// 3, or 2 for a body in the plane z = 0, whose cells make up one layer.
    pub dimension: usize,
    /// Cells around the grid, at least as far as the kernel reaches.
    pad: usize,
    /// Cells of the padded box.
    size: [usize; 3],
}

impl Lattice {
    /// The lattice of `grid` with particles in `cells` (x fastest order) and h = `smoothing` dx, of a body in space
    /// (`dimension` 3) or in the plane (2), where `grid` is one layer of cells, which are of height one.
    pub fn new(grid: &Grid, cells: &[[usize; 3]], smoothing: f64, dimension: usize) -> Self {
        let dx = grid.spacing;
        let weights = Weights::new(dx, smoothing * dx, dimension);
        let pad = weights.cut.isqrt();
        let size = grid.cells.map(|n| n + 2 * pad);
        let reach = pad as isize;
        let across = if dimension == 2 { 0 } else { reach };
        let (mut neighbours, mut full_moment) = (Vec::new(), 0.0);
        for k in -across..=across {
            for j in -reach..=reach {
                for i in -reach..=reach {
                    let square = (i * i + j * j + k * k) as usize;
                    if square == 0 || square > weights.cut {
                        continue;
                    }
                    let x = Vec3::new(i as f64, j as f64, k as f64) * dx;
                    let w = weights.by_square[square];
                    full_moment += dx.powi(dimension as i32) * w * x.x.powi(2);
                    let shift = (k * size[1] as isize + j) * size[0] as isize + i;
                    neighbours.push(Neighbour { shift, x, w });
                }
            }
        }

        let mut particle_at = vec![NO_PARTICLE; size.iter().product()];
        let cell_of: Vec<u32> = cells.iter().map(|c| padded(c, &size, pad) as u32).collect();
        for (a, cell) in cell_of.iter().enumerate() {
            particle_at[*cell as usize] = a as u32;
        }
        Self {
            origin: grid.origin,
            spacing: dx,
            smoothing_length: smoothing * dx,
            tiles: Tiles::new(grid.cells, cells, &[]),
            weights,
            neighbours,
            cuts: Cuts::default(),
            images: Vec::new(),
            image_starts: Vec::new(),
            particle_at,
            cell_of,
            full_moment,
            dimension,
            pad,
            size,
        }
    }

    /// The same lattice without the pairs of neighbours that `parted` says, of the lower number and the higher.
    #[must_use]
    pub fn cut(self, parted: impl Fn(usize, usize) -> bool + Sync) -> Self {
        let parted_from = |a: usize| -> Vec<(u32, u32)> {
            let others = self.neighbours.iter().filter_map(|n| self.neighbour(a, n));
            others.filter(|b| *b > a && parted(a, *b)).map(|b| (a as u32, b as u32)).collect()
        };
        let pairs: Vec<(u32, u32)> = (0..self.len()).into_par_iter().flat_map_iter(parted_from).collect();
        let both = pairs.iter().flat_map(|&(a, b)| [(a, b), (b, a)]).collect();
        self.without(both)
    }

    /// The same lattice without those pairs, each both ways round.
    fn without(mut self, mut pairs: Vec<(u32, u32)>) -> Self {
        pairs.sort_unstable();
        let apart = |a: u32, b: u32| {
            let [from, to] = [a, b].map(|a| self.coordinates(a as usize));
            let offset: [isize; 3] = std::array::from_fn(|i| to[i] as isize - from[i] as isize);
            let square = offset.iter().map(|i| i * i).sum::<isize>() as usize;
            let x = Vec3::from_fn(|i, _| offset[i] as f64 * self.spacing);
            (x, self.weights.by_square.get(square).copied().unwrap_or(0.0))
        };
        self.cuts = Cuts::new(&self.tiles, pairs, apart);
        self
    }

    /// The particles that hang together by sums, piece by piece.
    pub fn pieces(&self) -> Vec<Vec<usize>> {
        let mut is_found = vec![false; self.len()];
        let mut pieces: Vec<Vec<usize>> = Vec::new();
        for start in 0..self.len() {
            if std::mem::replace(&mut is_found[start], true) {
                continue;
            }
            let mut piece = vec![start];
            let mut next = 0;
            while next < piece.len() {
                for neighbour in &self.neighbours {
                    if let Some(b) = self.neighbour(piece[next], neighbour)
                        && !std::mem::replace(&mut is_found[b], true)
                    {
                        piece.push(b);
                    }
                }
                next += 1;
            }
            pieces.push(piece);
        }
        pieces
    }

    /// The same lattice with the images of its particles in `mirrors`, as far as the kernel reaches. No particle lies beyond
    /// one of them, and two on the same axis are a reach apart; none with a cut lies within reach of one.
    #[must_use]
    pub fn mirrored(&self, mirrors: &[Mirror]) -> Self {
        let reach = self.pad as isize;
        let (mut shift, mut size) = ([0; 3], self.size.map(|n| n as isize - 2 * reach));
        for mirror in mirrors.iter().filter(|m| !m.above) {
            // An even layer: the blocks of multigrid end at the mirror.
            let needed = (reach - mirror.layer).max(0);
            shift[mirror.axis] = needed + (needed + mirror.layer) % 2;
        }
        for mirror in mirrors.iter().filter(|m| m.above) {
            size[mirror.axis] = size[mirror.axis].max(mirror.layer + reach);
        }
        let origin = self.origin - Vec3::from_fn(|i, _| shift[i] as f64) * self.spacing;
        let cells = std::array::from_fn(|i| (size[i] + shift[i]) as usize);
        let moved = |c: [isize; 3]| std::array::from_fn(|i| (c[i] + shift[i]) as usize);
        let (mut places, mut images) = (Vec::with_capacity(self.len()), Vec::new());
        for a in 0..self.len() {
            let cell = self.coordinates(a).map(|c| c as isize);
            places.push(moved(cell));
            let mut found = vec![(cell, 0)];
            for mirror in mirrors {
                let image = 2 * mirror.layer - 1 - cell[mirror.axis];
                if (image - cell[mirror.axis]).abs() < 2 * reach {
                    for k in 0..found.len() {
                        let (mut cell, set) = found[k];
                        if !has_mirror(set, mirror.axis) {
                            cell[mirror.axis] = image;
                            found.push((cell, set | mirror.bit()));
                        }
                    }
                }
            }
            images.extend(found[1..].iter().map(|(cell, set)| (a as u32, *set, moved(*cell))));
        }
        let smoothing = self.smoothing_length / self.spacing;
        let grid = Grid { origin, spacing: self.spacing, cells };
        let mut lattice = Self::new(&grid, &places, smoothing, self.dimension);
        let besides: Vec<[usize; 3]> = images.iter().map(|i| i.2).collect();
        lattice.tiles = Tiles::new(cells, &places, &besides);
        let mut placed: Vec<(Image, usize)> = images
            .iter()
            .map(|&(particle, mirrors, c)| {
                let tile = lattice.tiles.tile(c[0] / LANES, c[2], c[1]) as u32;
                (Image { particle, mirrors, tile, lane: (c[0] % LANES) as u8 }, lattice.cell(&c))
            })
            .collect();
        placed.sort_unstable_by_key(|(image, _)| (image.tile, image.lane));
        lattice.image_starts = vec![0; lattice.tiles.len() + 1];
        for (k, (image, cell)) in placed.iter().enumerate() {
            lattice.particle_at[*cell] = (places.len() + k) as u32;
            lattice.image_starts[image.tile as usize + 1] += 1;
        }
        for t in 0..lattice.tiles.len() {
            lattice.image_starts[t + 1] += lattice.image_starts[t];
        }
        lattice.images = placed.into_iter().map(|(image, _)| image).collect();
        lattice.without(self.cuts.pairs().to_vec())
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.cell_of.len()
    }

    /// Volume of a cell, of height one in the plane.
    pub fn cell_volume(&self) -> f64 {
        self.spacing.powi(self.dimension as i32)
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.cell_of.is_empty()
    }

    /// Cell of the padded box with (unpadded) coordinates `c`.
    fn cell(&self, c: &[usize; 3]) -> usize {
        padded(c, &self.size, self.pad)
    }

    /// The particle in the cell with (unpadded) coordinates `c`, which may lie outside of the grid, or that of the image there.
    pub fn particle(&self, c: [isize; 3]) -> Option<usize> {
        let p: [isize; 3] = std::array::from_fn(|i| c[i] + self.pad as isize);
        if (0..3).any(|i| p[i] < 0 || p[i] >= self.size[i] as isize) {
            return None;
        }
        let cell = (p[2] as usize * self.size[1] + p[1] as usize) * self.size[0] + p[0] as usize;
        Some(self.particle_at[cell]).filter(|&a| a != NO_PARTICLE).map(|a| self.seen_as(a).particle)
    }

    /// The particle at `neighbour` of particle `a`, or that of the image there.
    #[inline(always)]
    pub fn neighbour(&self, a: usize, neighbour: &Neighbour) -> Option<usize> {
        self.seen(a, neighbour).map(|seen| seen.particle)
    }

    /// What particle `a` sees at `neighbour`.
    #[inline(always)]
    pub fn seen(&self, a: usize, neighbour: &Neighbour) -> Option<Seen> {
        let b = self.particle_at[(self.cell_of[a] as usize).wrapping_add_signed(neighbour.shift)];
        (b != NO_PARTICLE && !self.cuts.part(a, b as usize)).then(|| self.seen_as(b))
    }

    /// The particle with that number, or image from the number of particles on.
    #[inline(always)]
    fn seen_as(&self, number: u32) -> Seen {
        let particle = number as usize;
        if let Some(k) = particle.checked_sub(self.len()) {
            let image = &self.images[k];
            return Seen { particle: image.particle as usize, mirrors: image.mirrors, tile: image.place().0 };
        }
        Seen { particle, mirrors: 0, tile: self.tiles.place(particle).0 }
    }

    /// The images in tile `t`.
    #[inline(always)]
    pub fn images_in(&self, t: usize) -> &[Image] {
        if self.images.is_empty() {
            return &[];
        }
        &self.images[self.image_starts[t] as usize..self.image_starts[t + 1] as usize]
    }

    /// (Unpadded) coordinates of the cell of a particle.
    pub fn coordinates(&self, a: usize) -> [usize; 3] {
        let cell = self.cell_of[a] as usize;
        let row = cell / self.size[0];
        [cell % self.size[0], row % self.size[1], row / self.size[1]].map(|c| c - self.pad)
    }

    /// Undeformed position of a particle: the centre of its cell.
    pub fn position(&self, a: usize) -> Vec3 {
        let cell = self.coordinates(a);
        self.origin + Vec3::from_fn(|i, _| (cell[i] as f64 + 0.5) * self.spacing)
    }
}

/// Number of the cell with coordinates `c` in a box of that `size`, padded by `pad` cells.
fn padded(c: &[usize; 3], size: &[usize; 3], pad: usize) -> usize {
    ((c[2] + pad) * size[1] + c[1] + pad) * size[0] + c[0] + pad
}
