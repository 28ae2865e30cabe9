//! Segmented images: what is read from them, and what is refused. Python's tests compare with nibabel.

mod common;

use proptest::prelude::*;
use rsph_core::shape::{Run, voxel_shape};
use rsph_core::tensor::Vec3;
use rsph_scenario::label_map::{Axes, LabelMapError, Labelled, read_label, survey};

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

/// The same image as NRRD, in the axes of a patient's left, back and head.
fn nrrd(encoding: &str, data: &str) -> String {
    format!(
        "NRRD0004\n# made here\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 3 1\n\
         space directions: (-2,0,0) (0,-2,0) (0,0,2)\nkinds: domain domain domain\nencoding: {encoding}\n\
         space origin: (-10,-20,30)\nsegment:=no field\n{data}\n"
    )
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut stream = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut stream, bytes).unwrap();
    stream.finish().unwrap()
}

#[test]
fn nrrd_is_the_same_image_as_nifti() {
    let voxels = [0, 7, 7, 0, 7, 3, 3, 7, 7, 7, 7, 7];
    let wanted = read(&image([4, 3, 1], &voxels), 7).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("image.nrrd");
    let read_nrrd = |text: String, data: &[u8]| {
        std::fs::write(&path, [text.as_bytes(), data].concat()).unwrap();
        read_label(&path, 7)
    };
    assert_eq!(read_nrrd(nrrd("raw", ""), &voxels).unwrap(), wanted);
    assert_eq!(read_nrrd(nrrd("gzip", ""), &packed(&voxels)).unwrap(), wanted);
    std::fs::write(dir.path().join("image.raw"), voxels).unwrap();
    assert_eq!(read_nrrd(nrrd("raw", "data file: image.raw\n"), &[]).unwrap(), wanted);
    std::fs::write(dir.path().join("image.raw.gz"), packed(&voxels)).unwrap();
    assert_eq!(read_nrrd(nrrd("gzip", "data file: ./image.raw.gz\n"), &[]).unwrap(), wanted);
    for (text, data, says) in [
        (nrrd("raw", ""), &voxels[..5], "ends too early"),
        (nrrd("gzip", ""), &packed(&voxels)[..20], "damaged archive"),
        (nrrd("gzip", ""), &voxels[..], "slice 0"),
        (nrrd("bzip2", ""), &voxels, "encoding \"bzip2\""),
        (nrrd("raw", "data file: ../image.raw\n"), &[], "no single file beside it"),
        (nrrd("raw", "data file: none.raw\n"), &[], "cannot be read"),
        (nrrd("raw", "byte skip: 3\n"), &voxels, "byte skip"),
        (nrrd("raw", "").replace("sizes: 4 3 1", "sizes: 4 3"), &voxels, "3 dimensions"),
        (nrrd("raw", "").replace("dimension: 3", "dimension: 4"), &voxels, "4 dimensions"),
        (nrrd("raw", "").replace("unsigned char", "block"), &voxels, "no plain numbers"),
        (nrrd("raw", "").replace("(0,0,2)", "none"), &voxels, "where its voxels are"),
        (nrrd("raw", "").replace("encoding: raw\n", ""), &voxels, "no \"encoding\""),
    ] {
        let said = read_nrrd(text, data).unwrap_err().to_string();
        assert!(said.contains(says), "{says}: {said}");
    }
}

#[test]
fn archives_may_end_in_zeros_and_have_several_members() {
    let voxels = [0, 7, 7, 0, 7, 3, 3, 7, 7, 7, 7, 7];
    let raw = image([4, 3, 1], &voxels);
    let wanted = read(&raw, 7).unwrap();
    let (first, second) = (packed(&raw[..200]), packed(&raw[200..]));
    for bytes in [
        [packed(&raw), vec![0; 512]].concat(),
        [first.clone(), second.clone()].concat(),
        [first.clone(), vec![0; 7], second, vec![0; 70_000]].concat(),
    ] {
        assert_eq!(read(&bytes, 7).unwrap(), wanted);
    }
    let said = read(&[packed(&raw), b"rest".to_vec()].concat(), 7).unwrap_err().to_string();
    assert!(said.contains("damaged archive"), "{said}");
}

#[test]
fn sizes_of_voxels_count_by_their_absolute_values() {
    let voxels = [0, 7, 7, 0, 7, 3, 3, 7, 7, 7, 7, 7];
    let with = |sizes: [f32; 4], qform: i16| {
        let mut raw = image([4, 3, 1], &voxels);
        raw[252..254].copy_from_slice(&qform.to_le_bytes());
        raw[254..256].copy_from_slice(&0_i16.to_le_bytes());
        for (i, size) in sizes.into_iter().enumerate() {
            raw[76 + 4 * i..80 + 4 * i].copy_from_slice(&size.to_le_bytes());
        }
        read(&raw, 7).unwrap()
    };
    for qform in [0, 1] {
        let wanted = with([1.0, 2.0, 2.0, 3.0], qform);
        assert_eq!(with([1.0, -2.0, 2.0, -3.0], qform), wanted);
    }
    // The first is the hand of the axes.
    assert!(with([-1.0, 2.0, 2.0, 3.0], 1).placement.axes.determinant() < 0.0);
}

#[test]
fn voxels_that_are_no_number_are_outside() {
    let values = [0.0_f32, 1.0, f32::NAN, 0.7, 1.4, f32::INFINITY, 1.0, 2.0];
    let mut raw = image([4, 2, 1], &[]);
    raw[70..72].copy_from_slice(&16_i16.to_le_bytes());
    raw.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    let found = read(&raw, 1).unwrap();
    let inside: usize = found.runs.iter().map(|run| run.length).sum();
    assert_eq!(inside, 4, "{:?}", found.runs);
}

#[test]
fn a_survey_tells_labels_from_values() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("image.nii");
    std::fs::write(&path, image([4, 3, 1], &[0, 7, 7, 0, 7, 3, 3, 7, 7, 7, 7, 7])).unwrap();
    let found = survey(&path).unwrap();
    assert_eq!(found.labels.unwrap().into_iter().collect::<Vec<_>>(), [(0, 2), (3, 2), (7, 8)]);
    assert_eq!((found.grid.edges(), &*found.grid.orientation(), found.without), ([2.0; 3], "RAS", 0));
    let mut raw = image([4, 2, 1], &[]);
    raw[70..72].copy_from_slice(&16_i16.to_le_bytes());
    raw.extend([0.0_f32, 1.5, f32::NAN, 0.7, -1.4, 3.0, 1.0, 2.0].iter().flat_map(|v| v.to_le_bytes()));
    std::fs::write(&path, raw).unwrap();
    let found = survey(&path).unwrap();
    assert_eq!((found.labels, found.without), (None, 1));
    assert!((found.range[0] + 1.4).abs() < 1e-6 && (found.range[1] - 3.0).abs() < 1e-6);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    /// Whatever stands in an NRRD file, it is read or refused.
    #[test]
    fn any_nrrd_header_is_met_at_the_door(
        changes in prop::collection::vec((0..230_usize, any::<u8>()), 1..6),
        cut in 0..400_usize,
    ) {
        let mut raw = [nrrd("raw", "").as_bytes(), &[7; 12]].concat();
        for (at, byte) in changes {
            raw[at] = byte;
        }
        raw.truncate(cut.max(100));
        if let Ok(found) = read(&raw, 7) {
            let _ = voxel_shape(&found.runs, found.size, &found.placement(None, Axes::Image), "image");
        }
    }
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
