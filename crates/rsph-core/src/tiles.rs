//! Fields for the vector units: the cells of the lattice in tiles of eight along x.
//!
//! A *tiled field* of C components holds one [`Tile`] for each component of each tile of cells: lane l
//! of component c of tile t is `field[t C + c].0[l]`. Tiles of one x column stand together, plane after
//! plane, row after row, so that a sweep along a column reads and writes memory in sequence. Lanes
//! without a particle hold zero.

use std::ops::Range;

/// Lanes of a tile.
pub const LANES: usize = 8;

/// Eight values, those of cells that are neighbours along x; a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Tile(pub [f64; LANES]);

/// Which cells of the lattice's box hold a particle, tile by tile.
#[derive(Clone, Debug)]
pub struct Tiles {
    /// Tiles along x.
    pub columns: usize,
    /// Cells along z.
    pub planes: usize,
    /// Cells along y.
    pub rows: usize,
    /// Particle in the first occupied lane of every tile; the following lanes count on from it.
    first: Vec<u32>,
    /// Occupied lanes of every tile, a bit each.
    mask: Vec<u8>,
    /// Rows from the first to the last particle in every plane of every column.
    occupied: Vec<Range<u32>>,
    /// First tile of every plane of every column, and their number.
    start: Vec<u32>,
    /// Tile and lane of every particle.
    place: Vec<u32>,
}

impl Tiles {
    /// Of a box of `cells` with particles in `places` (x fastest order), and tiles for the cells in `besides` as well.
    pub fn new(cells: [usize; 3], places: &[[usize; 3]], besides: &[[usize; 3]]) -> Self {
        let [columns, rows, planes] = [cells[0].div_ceil(LANES), cells[1], cells[2]];
        let mut occupied = vec![0..0; columns * planes];
        for [x, y, z] in places.iter().chain(besides) {
            let (range, y): (&mut Range<u32>, u32) = (&mut occupied[x / LANES * planes + z], *y as u32);
            *range =
                if range.start == range.end { y..y + 1 } else { range.start.min(y)..range.end.max(y + 1) };
        }
        let mut start = vec![0];
        for range in &occupied {
            start.push(start[start.len() - 1] + range.end - range.start);
        }
        let count = start[start.len() - 1] as usize;
        let (first, mask) = (vec![0; count], vec![0; count]);
        let mut tiles = Self { columns, planes, rows, first, mask, occupied, start, place: Vec::new() };
        tiles.place.reserve_exact(places.len());
        for (a, [x, y, z]) in places.iter().enumerate() {
            let t = tiles.tile(x / LANES, *z, *y);
            if tiles.mask[t] == 0 {
                tiles.first[t] = a as u32;
            }
            tiles.mask[t] |= 1 << (x % LANES);
            tiles.place.push((t * LANES + x % LANES) as u32);
        }
        tiles
    }

    /// Number of tiles.
    pub fn len(&self) -> usize {
        self.mask.len()
    }

    /// Whether there is no tile.
    pub fn is_empty(&self) -> bool {
        self.mask.is_empty()
    }

    /// A field of `components` zeros.
    pub fn field(&self, components: usize) -> Vec<Tile> {
        vec![Tile::default(); components * self.len()]
    }

    /// First tile of plane `z` of `column`; of the plane after the last, the end of the column.
    #[inline(always)]
    pub fn start(&self, column: usize, z: usize) -> usize {
        self.start[column * self.planes + z] as usize
    }

    /// The tile in row `y` of plane `z` of `column`, which must be one of [`Tiles::occupied`].
    #[inline(always)]
    pub fn tile(&self, column: usize, z: usize, y: usize) -> usize {
        let plane = column * self.planes + z;
        self.start[plane] as usize + (y - self.occupied[plane].start as usize)
    }

    /// Tile and lane of a particle.
    #[inline(always)]
    pub fn place(&self, a: usize) -> (usize, usize) {
        let place = self.place[a] as usize;
        (place / LANES, place % LANES)
    }

    /// Rows from the first to the last particle in plane `z` of `column`; none outside of the box.
    #[inline(always)]
    pub fn occupied(&self, column: usize, z: isize) -> Range<isize> {
        if z < 0 || z as usize >= self.planes {
            return 0..0;
        }
        let rows = &self.occupied[column * self.planes + z as usize];
        rows.start as isize..rows.end as isize
    }

    /// The particle in the first occupied lane of tile `t`, and its occupied lanes.
    #[inline(always)]
    pub fn particles(&self, t: usize) -> (usize, u8) {
        (self.first[t] as usize, self.mask[t])
    }

    /// The particle in that lane of tile `t`, if there is one.
    #[inline(always)]
    pub fn particle(&self, t: usize, lane: usize) -> Option<usize> {
        let (first, mask) = self.particles(t);
        let before = mask & ((1 << lane) - 1);
        (mask >> lane & 1 == 1).then(|| first + before.count_ones() as usize)
    }

    /// Calls `visit(particle, tile, lane, count)` for every stretch of particles in neighbouring lanes of
    /// a tile, `particles` in order.
    #[inline(always)]
    pub fn for_each_run(&self, particles: Range<usize>, mut visit: impl FnMut(usize, usize, usize, usize)) {
        let mut a = particles.start;
        while a < particles.end {
            let (t, lane) = self.place(a);
            let count = ((self.mask[t] >> lane).trailing_ones() as usize).min(particles.end - a);
            visit(a, t, lane, count);
            a += count;
        }
    }
}
