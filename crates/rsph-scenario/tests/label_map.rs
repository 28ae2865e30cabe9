//! Segmented images: what is read from them, and what is refused. Python's tests compare with nibabel.

mod common;

use proptest::prelude::*;
use rsph_core::shape::{Run, voxel_shape};
use rsph_core::tensor::Vec3;
use rsph_scenario::label_map::{Axes, LabelMapError, Labelled, read_label};

/// Voxels of 2 mm, moved by (10, 20, 30) mm.
fn image(size: [i16; 3], voxels: &[u8]) -> Vec<u8> {
    common::nifti(size, 2.0, [10.0, 20.0, 30.0], voxels)
}

fn read(raw: &[u8], label: u32) -> Result<Labelled, LabelMapError> {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("image.nii");
    std::fs::write(&path, raw).expect("written");
    read_label(&path, label)
}

#[test]
fn runs_of_a_label_and_their_place_are_read() {
    let voxels = [0, 7, 7, 0, 7, 3, 3, 7, 7, 7, 7, 7];
    let found = read(&image([4, 3, 1], &voxels), 7).unwrap();
    let run = |x, y, length| Run { start: [x, y, 0], length };
    assert_eq!(found.runs, [run(1, 0, 2), run(0, 1, 1), run(3, 1, 1), run(0, 2, 4)]);
    assert_eq!(found.size, [4, 3, 1]);
    let place = found.placement(None, Axes::Image);
    assert!((place.axes * Vec3::x() - Vec3::x() * 2e-3).norm() < 1e-15);
    assert!((place.origin - Vec3::new(0.01, 0.02, 0.03)).norm() < 1e-15);
    let turned = found.placement(Some(1.0), Axes::Organ);
    assert!((turned.origin - Vec3::new(-10.0, 30.0, 20.0)).norm() < 1e-12);
    assert!(turned.axes.determinant() > 0.0, "a rotation, no mirror");
}

#[test]
fn labels_that_are_not_there_are_told_with_those_that_are() {
    let error = read(&image([2, 2, 1], &[0, 4, 9, 9]), 5).unwrap_err();
    assert!(error.to_string().contains("no voxel has the label 5"), "{error}");
    assert_eq!(error.remedy, "it has the labels 4, 9");
    assert_eq!(read(&image([2, 1, 1], &[0, 0]), 1).unwrap_err().remedy, "the image is empty");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    /// Whatever stands in the header, the image is read or refused.
    #[test]
    fn any_header_is_met_at_the_door(
        changes in prop::collection::vec((0..352_usize, any::<u8>()), 1..6),
        cut in 0..500_usize,
    ) {
        let mut raw = image([4, 4, 4], &[1; 64]);
        for (at, byte) in changes {
            raw[at] = byte;
        }
        raw.truncate(cut.max(300));
        if let Ok(found) = read(&raw, 1) {
            let _ = voxel_shape(&found.runs, found.size, &found.placement(None, Axes::Image), "image");
        }
    }
}
