//! The kernel sums in three passes against plain sums over neighbours.

use rsph_core::grid::Grid;
use rsph_core::lattice::Lattice;
use rsph_core::ops::{self, EvenField, PAIR_COMPONENTS, Part, Plain, Results};
use rsph_core::solve::sums::noise;
use rsph_core::tensor::{Mat3, Vec3};
use rsph_core::tiles::{LANES, Tile};

/// A ragged body in a box that no tile fills, with holes.
fn body(smoothing: f64) -> Lattice {
    let size = [19, 13, 11];
    let grid = Grid { origin: Vec3::new(-0.3, 0.2, 0.1), spacing: 0.1, cells: size };
    let mut cells = Vec::new();
    for k in 0..size[2] {
        for j in 0..size[1] {
            for i in 0..size[0] {
                let x =
                    grid.origin + Vec3::new(i as f64 + 0.5, j as f64 + 0.5, k as f64 + 0.5) * grid.spacing;
                let centre = grid.origin + Vec3::new(9.0, 6.0, 5.0) * grid.spacing;
                let hole = (i * 7 + j * 5 + k * 3) % 11 == 0;
                if (x - centre).component_div(&Vec3::new(1.0, 0.7, 0.6)).amax() < 0.95 && !hole {
                    cells.push([i, j, k]);
                }
            }
        }
    }
    Lattice::new(&grid, &cells, smoothing, 3)
}

fn random(lattice: &Lattice, components: usize, used: usize) -> (Vec<Tile>, Vec<f64>) {
    let mut values = vec![0.0; used * lattice.len()];
    noise(&mut values);
    let mut field = lattice.tiles.field(components);
    for a in 0..lattice.len() {
        let (t, lane) = lattice.tiles.place(a);
        for c in 0..used {
            field[t * components + c].0[lane] = values[used * a + c];
        }
    }
    (field, values)
}

/// Components of sums on a part of the body.
const PART: usize = 9;

/// A field on a part of the body.
struct OnSource<'a> {
    source: &'a Part,
    values: &'a [Tile],
}

impl EvenField<PART> for OnSource<'_> {
    fn lanes<const N: usize>(&self, tile: usize, first: usize) -> Option<[[f64; N]; PART]> {
        self.source.number(tile)?;
        let components = &self.values[PAIR_COMPONENTS * tile..];
        Some(std::array::from_fn(|c| std::array::from_fn(|l| components[c].0[first + l])))
    }
}

#[test]
fn sums_are_those_over_neighbours_at_every_reach() {
    for smoothing in [0.75, 0.8, 1.0, 1.2, 1.25, 1.5, 2.0] {
        check(smoothing);
    }
}

fn check(smoothing: f64) {
    let lattice = body(smoothing);
    let (q, values) = random(&lattice, 3, 3);
    let mut sums = lattice.tiles.field(PAIR_COMPONENTS);
    ops::gradient_sums(&lattice, None, &q, &mut sums, [None, None], &Plain);
    let (t, tensors) = random(&lattice, PAIR_COMPONENTS, 9);
    let mut adjoint = lattice.tiles.field(3);
    ops::adjoint_sums(&lattice, None, &t, &mut adjoint);
    // Some tiles, alone and in groups.
    let part = Part::new(&lattice, |t| t % 7 == 0 || t % 13 < 2);
    // Of a field that is not everywhere either.
    let source = Part::new(&lattice, |t| t % 5 != 0);
    let field = OnSource { source: &source, values: &t };
    let even_sums = || {
        let mut even = vec![Tile::default(); PART * part.len()];
        ops::even_sums(&lattice, &part, &field, Results::new(Some(&part), PART, &mut even));
        even
    };
    let even = even_sums();
    let (mut sums_of_part, mut adjoint_of_part) =
        (lattice.tiles.field(PAIR_COMPONENTS), lattice.tiles.field(3));
    ops::gradient_sums(&lattice, Some(&part), &q, &mut sums_of_part, [None, None], &Plain);
    ops::adjoint_sums(&lattice, Some(&part), &t, &mut adjoint_of_part);

    let vector = |a: usize| Vec3::from_column_slice(&values[3 * a..3 * a + 3]);
    let tensor = |a: usize| Mat3::from_row_slice(&tensors[9 * a..9 * a + 9]);
    let scale: f64 = lattice.neighbours.iter().map(|n| n.w).sum();
    for a in 0..lattice.len() {
        let (mut h, mut plain, mut force) = (Mat3::zeros(), Vec3::zeros(), Vec3::zeros());
        let mut plain_tensor = Mat3::zeros();
        for n in &lattice.neighbours {
            if let Some(b) = lattice.neighbour(a, n) {
                h += n.w * vector(b) * n.x.transpose();
                plain += n.w * vector(b);
                force += n.w * tensor(b) * n.x;
                if source.number(lattice.tiles.place(b).0).is_some() {
                    plain_tensor += n.w * tensor(b);
                }
            }
        }
        let (tile, lane) = lattice.tiles.place(a);
        let sum = |c: usize| sums[tile * PAIR_COMPONENTS + c].0[lane];
        for i in 0..3 {
            for j in 0..3 {
                assert!((sum(3 * i + j) - h[(i, j)]).abs() < 1e-13 * scale, "{smoothing} H{i}{j} of {a}");
            }
            assert!((sum(9 + i) - plain[i]).abs() < 1e-13 * scale, "{smoothing} Q{i} of {a}");
            let computed = adjoint[tile * 3 + i].0[lane];
            assert!((computed - force[i]).abs() < 1e-13 * scale, "{smoothing} adjoint {i} of {a}");
        }
        let Some(number) = part.number(tile) else { continue };
        for c in 0..PART {
            let error = even[PART * number + c].0[lane] - plain_tensor[(c / 3, c % 3)];
            assert!(error.abs() < 1e-13 * scale, "{smoothing} even {c} of {a}");
        }
        for c in 0..PAIR_COMPONENTS {
            assert_eq!(sums_of_part[tile * PAIR_COMPONENTS + c].0[lane].to_bits(), sum(c).to_bits());
        }
        for i in 0..3 {
            assert_eq!(
                adjoint_of_part[tile * 3 + i].0[lane].to_bits(),
                adjoint[tile * 3 + i].0[lane].to_bits()
            );
        }
    }
    // Another number of threads cuts the body into other blocks.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(7).build().unwrap();
    let mut again = lattice.tiles.field(PAIR_COMPONENTS);
    pool.install(|| ops::gradient_sums(&lattice, None, &q, &mut again, [None, None], &Plain));
    assert!(occupied(&lattice, &sums) == occupied(&lattice, &again));
    assert!(even == pool.install(even_sums));
}

fn occupied(lattice: &Lattice, field: &[Tile]) -> Vec<[f64; LANES]> {
    let tiles: std::collections::BTreeSet<usize> =
        (0..lattice.len()).map(|a| lattice.tiles.place(a).0).collect();
    tiles.iter().flat_map(|t| field[t * PAIR_COMPONENTS..][..PAIR_COMPONENTS].iter().map(|v| v.0)).collect()
}
