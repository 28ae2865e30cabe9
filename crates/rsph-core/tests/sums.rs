//! The kernel sums in three passes against plain sums over neighbours.

use rsph_core::boundary::mirror::{Mirror, MirrorPlane};
use rsph_core::grid::Grid;
use rsph_core::lattice::Lattice;
use rsph_core::ops::{self, PAIR_COMPONENTS, Plain};
use rsph_core::solve::sums::noise;
use rsph_core::tensor::{Mat3, Vec3};
use rsph_core::tiles::{LANES, Tile};

/// A ragged body in a box that no tile fills, with holes, apart from what lies behind the planes.
fn body(planes: &[MirrorPlane], smoothing: f64) -> (Lattice, Vec<Vec3>) {
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
                let before = planes.iter().all(|p| x[p.axis] > p.at);
                if (x - centre).component_div(&Vec3::new(1.0, 0.7, 0.6)).amax() < 0.95 && !hole && before {
                    cells.push([i, j, k]);
                }
            }
        }
    }
    let lattice = Lattice::new(&grid, &cells, smoothing);
    let positions = (0..lattice.len()).map(|a| lattice.position(a)).collect();
    (lattice, positions)
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

fn check(smoothing: f64, planes: Vec<MirrorPlane>) {
    let (lattice, positions) = body(&planes, smoothing);
    let all_on_faces = planes.iter().all(|p| {
        let face = (p.at - lattice.origin[p.axis]) / lattice.spacing;
        (face - face.round()).abs() < 1e-9
    });
    let mirror = Mirror::new(&lattice, &positions, planes, |_| true);
    assert_ne!(mirror.has_others(), all_on_faces);

    let (q, values) = random(&lattice, 3, 3);
    let mut sums = lattice.tiles.field(PAIR_COMPONENTS);
    ops::gradient_sums(&lattice, mirror.folds(), &q, &mut sums, &Plain);
    let (t, tensors) = random(&lattice, PAIR_COMPONENTS, 9);
    let mut adjoint = lattice.tiles.field(3);
    ops::adjoint_sums(&lattice, mirror.folds(), &t, &mut adjoint);

    let vector = |a: usize| Vec3::from_column_slice(&values[3 * a..3 * a + 3]);
    let tensor = |a: usize| Mat3::from_row_slice(&tensors[9 * a..9 * a + 9]);
    let scale: f64 = lattice.neighbours.iter().map(|n| n.w).sum();
    for a in 0..lattice.len() {
        let (mut h, mut plain, mut force) = (Mat3::zeros(), Vec3::zeros(), Vec3::zeros());
        for n in &lattice.neighbours {
            if let Some(b) = lattice.neighbour(a, n) {
                h += n.w * vector(b) * n.x.transpose();
                plain += n.w * vector(b);
                force += n.w * tensor(b) * n.x;
            }
        }
        for ghost in mirror.ghosts_of(a).filter(|g| mirror.is_folded(g)) {
            let b = ghost.partner as usize;
            let image = ghost.w * ghost.sign.component_mul(&vector(b));
            h += image * ghost.x.transpose();
            plain += image;
            let t_x = tensor(b) * ghost.reflection.component_mul(&ghost.x);
            force += ghost.w * ghost.sign.component_mul(&t_x);
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
    }
    // Another number of threads cuts the body into other blocks.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(7).build().unwrap();
    let mut again = lattice.tiles.field(PAIR_COMPONENTS);
    pool.install(|| ops::gradient_sums(&lattice, mirror.folds(), &q, &mut again, &Plain));
    assert!(occupied(&lattice, &sums) == occupied(&lattice, &again));
}

fn occupied(lattice: &Lattice, field: &[Tile]) -> Vec<[f64; LANES]> {
    let tiles: std::collections::BTreeSet<usize> =
        (0..lattice.len()).map(|a| lattice.tiles.place(a).0).collect();
    tiles.iter().flat_map(|t| field[t * PAIR_COMPONENTS..][..PAIR_COMPONENTS].iter().map(|v| v.0)).collect()
}

fn plane(axis: usize, cell: f64, fix: [bool; 3]) -> MirrorPlane {
    let origin = [-0.3, 0.2, 0.1];
    MirrorPlane { axis, at: origin[axis] + 0.1 * cell, fix, motion: None }
}

#[test]
fn free_bodies_at_every_reach() {
    for smoothing in [0.75, 0.8, 1.0, 1.2, 1.25, 1.5, 2.0] {
        check(smoothing, Vec::new());
    }
}

#[test]
fn mirrored_at_faces_edges_and_corners() {
    for smoothing in [0.8, 1.25, 2.0] {
        for axis in 0..3 {
            for face in [0.0, 1.0, 3.0, 4.0] {
                check(smoothing, vec![plane(axis, face, [true; 3])]);
                check(smoothing, vec![plane(axis, face, [axis == 0, axis == 1, axis == 2])]);
            }
        }
        let corner = [
            plane(0, 5.0, [true, false, false]),
            plane(1, 4.0, [false, true, true]),
            plane(2, 3.0, [true, true, false]),
        ];
        check(smoothing, corner[..2].to_vec());
        check(smoothing, corner.to_vec());
    }
}

#[test]
fn planes_between_cell_faces_are_left_to_the_list_of_ghosts() {
    check(1.25, vec![plane(2, 3.3, [true; 3])]);
    check(1.25, vec![plane(0, 5.0, [true, false, false]), plane(2, 3.3, [true; 3])]);
}
