//! Fields on the voxels of an image: values, places and what the files say of themselves. Python's tests read them with nibabel.

use flate2::read::GzDecoder;
use rsph_core::material::KelvinVoigt;
use rsph_core::sample::Resolution;
use rsph_core::setup::{Setup, SolidSetup, VectorField};
use rsph_core::shape::{BoxShape, Placement, Shape};
use rsph_core::simulation::Simulation;
use rsph_core::tensor::{Mat3, SymTensor, Vec3};
use rsph_scenario::label_map::{Axes, ImageGrid, read_grid};
use rsph_scenario::output::nifti::{self, Meaning};
use rsph_scenario::output::polydata::PolyData;
use rsph_scenario::output::voxels::{Registration, on_voxels};
use std::io::Read;
use std::sync::Arc;

const SPACING: f64 = 0.005;
const ORGAN: Registration = Registration { scale: None, axes: Axes::Organ };

fn shape() -> BoxShape {
    BoxShape::new(Vec3::new(0.06, 0.05, 0.04), Vec3::new(0.01, -0.02, 0.03)).unwrap()
}

fn gradient() -> Mat3 {
    Mat3::new(0.02, 0.01, 0.0, -0.03, 0.01, 0.02, 0.0, 0.04, -0.02)
}

/// A block with u = G X.
fn particles() -> PolyData {
    let material = Arc::new(KelvinVoigt::new(1000.0, 1e4, 0.3, 0.0).unwrap());
    let mut setup = Setup::new(Arc::new(shape()), Resolution::Spacing(SPACING), SolidSetup::new(material));
    setup.initial.displacement = VectorField::Affine { constant: Vec3::zeros(), gradient: gradient() };
    PolyData::from_snapshot(&Simulation::new(setup).unwrap().snapshot())
}

/// An oblique image of voxels of 2 x 2.5 x 3 mm around the block, which has the axes of organs.
fn grid() -> ImageGrid {
    let (about_z, about_x) = (0.3_f64.sin_cos(), 0.2_f64.sin_cos());
    let about_z = Mat3::new(about_z.1, -about_z.0, 0.0, about_z.0, about_z.1, 0.0, 0.0, 0.0, 1.0);
    let about_x = Mat3::new(1.0, 0.0, 0.0, 0.0, about_x.1, -about_x.0, 0.0, about_x.0, about_x.1);
    let turn = about_z * about_x;
    let axes = turn * Mat3::from_diagonal(&Vec3::new(2.0, 2.5, 3.0));
    let size = [40, 32, 28];
    let middle = Axes::Organ.turn().transpose() * Vec3::new(0.04, 0.005, 0.05) * 1e3;
    let half = Vec3::new(19.5, 15.5, 13.5);
    ImageGrid { size, placement: Placement { axes, origin: middle - axes * half }, metres: 1e-3 }
}

/// Where a voxel is in the body (m).
fn place(grid: &ImageGrid, voxel: u64) -> Vec3 {
    let [nx, ny, _] = grid.size.map(|n| n as u64);
    let index = Vec3::new((voxel % nx) as f64, (voxel / nx % ny) as f64, (voxel / (nx * ny)) as f64);
    Axes::Organ.turn() * (grid.placement.axes * index + grid.placement.origin) * 1e-3
}

#[test]
fn a_displacement_is_shown_where_the_undeformed_body_is_along_the_axes_of_the_image() {
    let (grid, turn) = (grid(), Axes::Organ.turn());
    let field = on_voxels(&particles(), "displacement", &grid, ORGAN).unwrap();
    assert_eq!(field.meaning, Meaning::Displacement);
    for (voxel, u) in field.voxels.iter().zip(field.values.as_chunks::<3>().0) {
        let expected = turn.transpose() * gradient() * place(&grid, *voxel) * 1e3;
        assert!((Vec3::from(u.map(f64::from)) - expected).norm() < 1e-5, "{voxel}: {u:?} {expected}");
    }
    // The voxels are those in the body, but for a rim of rounded edges.
    let all: u64 = grid.size.iter().map(|n| *n as u64).product();
    for voxel in 0..all {
        let distance = shape().signed_distance(&place(&grid, voxel));
        let is_shown = field.voxels.binary_search(&voxel).is_ok();
        assert!(distance.abs() < 0.3 * SPACING || is_shown == (distance < 0.0), "{voxel} {distance}");
    }
}

#[test]
fn tensors_turn_and_components_do_not() {
    let (grid, turn) = (grid(), Axes::Organ.turn());
    let particles = particles();
    let strain = SymTensor::symmetric_part(&gradient());
    let turned = turn.transpose() * strain.to_matrix() * turn;
    let field = on_voxels(&particles, "strain", &grid, ORGAN).unwrap();
    assert_eq!(field.meaning, Meaning::Symmetric);
    let lower = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
    for e in field.values.as_chunks::<6>().0 {
        for (value, at) in e.iter().zip(lower) {
            assert!((f64::from(*value) - turned[at]).abs() < 1e-6, "{e:?} {turned}");
        }
    }
    let component = on_voxels(&particles, "strain.yz", &grid, ORGAN).unwrap();
    assert_eq!((component.meaning, component.values.len()), (Meaning::Scalar, component.voxels.len()));
    assert!(component.values.iter().all(|e| (f64::from(*e) - strain.0[4]).abs() < 1e-6));
}

#[test]
fn a_file_says_what_it_holds_and_has_the_grid_of_the_image() {
    let (dir, grid) = (tempfile::tempdir().unwrap(), grid());
    let particles = particles();
    let number = |raw: &[u8], at: usize| i16::from_le_bytes([raw[at], raw[at + 1]]);
    for (quantity, code, components) in
        [("von_mises", 0, 1), ("displacement", 1006, 3), ("velocity", 1007, 3), ("stress", 1005, 6)]
    {
        let field = on_voxels(&particles, quantity, &grid, ORGAN).unwrap();
        let plain = dir.path().join("field.nii");
        let packed = dir.path().join("field.nii.gz");
        nifti::write(&plain, &grid, &field, f32::NAN).unwrap();
        nifti::write(&packed, &grid, &field, f32::NAN).unwrap();
        let raw = std::fs::read(&plain).unwrap();
        let mut unpacked = Vec::new();
        GzDecoder::new(std::fs::File::open(&packed).unwrap()).read_to_end(&mut unpacked).unwrap();
        assert!(raw == unpacked);
        assert_eq!((number(&raw, 68), number(&raw, 50)), (code, components), "{quantity}");
        let count: usize = grid.size.iter().product();
        assert_eq!(raw.len(), 352 + 4 * count * components as usize);
        let value = |c: usize, voxel: usize| {
            let at = 352 + 4 * (c * count + voxel);
            f32::from_le_bytes(raw[at..at + 4].try_into().unwrap())
        };
        let mut inside = field.voxels.iter().zip(field.values.chunks(components as usize)).peekable();
        for voxel in 0..count {
            match inside.next_if(|(v, _)| **v == voxel as u64) {
                Some((_, values)) => {
                    (0..values.len())
                        .for_each(|c| assert_eq!(value(c, voxel).to_bits(), values[c].to_bits()));
                }
                None => assert!(value(0, voxel).is_nan()),
            }
        }
        if components == 1 {
            let read = read_grid(&packed).unwrap();
            assert_eq!((read.size, read.metres), (grid.size, grid.metres));
            assert!((read.placement.axes - grid.placement.axes).amax() < 1e-6);
            assert!((read.placement.origin - grid.placement.origin).amax() < 1e-5);
        }
    }
}

#[test]
fn what_can_not_be_shown_is_refused() {
    let (grid, particles) = (grid(), particles());
    let key = |quantity: &str| on_voxels(&particles, quantity, &grid, ORGAN).unwrap_err();
    assert!(key("temperature").remedy.contains("displacement, velocity"));
    assert_eq!(key("displacement.w").remedy, "displacement has the components x, y, z");
    assert_eq!(key("pressure").key, "field");
    let as_metres = Registration { scale: Some(1.0), axes: Axes::Organ };
    let elsewhere = on_voxels(&particles, "displacement", &grid, as_metres).unwrap_err();
    assert!(elsewhere.key == "like" && elsewhere.remedy.contains("scale"));
    let mut flat = particles.clone();
    let u = flat.field("displacement").unwrap().values.clone();
    flat.points.iter_mut().zip(u.as_chunks::<3>().0).for_each(|(x, u)| x[2] = u[2]);
    assert_eq!(on_voxels(&flat, "displacement", &grid, ORGAN).unwrap_err().key, "particles");
}
