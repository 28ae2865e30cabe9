//! VTKHDF: what is written is read back; what is damaged is refused.

#![allow(clippy::float_cmp, reason = "what is stored comes back bit by bit")]

mod common;

use proptest::prelude::*;
use rsph_scenario::output::polydata::{Cells, PointField, PolyData};
use rsph_scenario::output::vtkhdf::{VtkHdfWriter, describe, read_step};
use std::path::Path;

fn write(path: &Path, frames: &[PolyData]) {
    let mut writer = VtkHdfWriter::create(path).unwrap();
    for f in frames {
        writer.append(f).unwrap();
    }
}

/// Fields come back by name, whatever their order was.
fn sorted(mut frame: PolyData) -> PolyData {
    frame.fields.sort_by(|a, b| a.name.cmp(&b.name));
    frame
}

#[test]
fn particles_with_a_changing_count_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("particles.vtkhdf");
    let frames: Vec<_> = [(0.0, 4), (0.5, 7), (1.0, 5)]
        .into_iter()
        .map(|(t, cells)| PolyData::from_snapshot(&common::snapshot(t, 0, cells)))
        .collect();
    write(&path, &frames);

    let info = describe(&path).unwrap();
    assert_eq!(info.times, [0.0, 0.5, 1.0]);
    assert_eq!(info.points, frames.iter().map(|f| f.points.len()).collect::<Vec<_>>());
    assert_eq!(info.vertices, info.points);
    assert_eq!(info.polygons, [0, 0, 0]);
    assert_eq!(info.fields.len(), 9);
    assert!(info.fields.iter().any(|f| f.name == "stress" && f.components == 6));
    for (k, frame) in frames.iter().enumerate() {
        assert_eq!(read_step(&path, Some(k)).unwrap(), sorted(frame.clone()), "step {k}");
    }
    assert_eq!(read_step(&path, None).unwrap().time, 1.0);
}

#[test]
fn frames_of_more_points_than_are_written_at_once_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("many.vtkhdf");
    let frame = |n: u32| {
        let values = |c: u32| (0..c * n).map(f64::from).collect();
        let field =
            |c: u32| PointField { name: format!("field_{c}"), components: c as usize, values: values(c) };
        PolyData {
            time: f64::from(n),
            points: (0..n).map(|i| [f64::from(i), 0.5, -1.0]).collect(),
            cells: if n.is_multiple_of(2) {
                Cells::Vertices
            } else {
                Cells::Triangles((2..n).map(|i| [i - 2, i - 1, i]).collect())
            },
            fields: [1, 3, 6].map(field).to_vec(),
        }
    };
    let frames = [140_000, 3, 70_001].map(frame);
    write(&path, &frames);
    for (k, frame) in frames.iter().enumerate() {
        assert!(read_step(&path, Some(k)).unwrap() == *frame, "step {k}");
    }
}

#[test]
fn surfaces_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("surface.vtkhdf");
    let frames: Vec<_> = [(0.0, 4), (0.5, 9), (1.0, 4)]
        .into_iter()
        .map(|(t, rings)| PolyData::from_surface(t, common::surface(t, rings)))
        .collect();
    write(&path, &frames);
    let info = describe(&path).unwrap();
    assert_eq!(info.vertices, [0, 0, 0]);
    assert!(info.polygons[1] > info.polygons[0]);
    for (k, frame) in frames.iter().enumerate() {
        assert_eq!(read_step(&path, Some(k)).unwrap(), sorted(frame.clone()));
    }
}

#[test]
fn snapshot_positions_are_current_and_the_reference_is_left_out() {
    let snapshot = common::snapshot(1.0, 3, 4);
    let frame = PolyData::from_snapshot(&snapshot);
    assert!(frame.field("reference").is_none());
    let (x, u) = (snapshot.column(rsph_core::particles::Field::Reference).vector(5), {
        let f = frame.field("displacement").unwrap();
        [f.values[15], f.values[16], f.values[17]]
    });
    for i in 0..3 {
        assert_eq!(frame.points[5][i], x[i] + u[i]);
    }
}

#[test]
fn a_file_is_readable_while_the_writer_holds_it_and_after_every_frame() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vtkhdf");
    let mut writer = VtkHdfWriter::create(&path).unwrap();
    for k in 0..3 {
        writer.append(&PolyData::from_snapshot(&common::snapshot(f64::from(k), 0, 3))).unwrap();
        // A copy of the bytes on disk is what a crash would leave behind.
        let copy = dir.path().join("copy.vtkhdf");
        std::fs::copy(&path, &copy).unwrap();
        assert_eq!(describe(&copy).unwrap().steps(), k as usize + 1);
        assert_eq!(read_step(&copy, None).unwrap().time, f64::from(k));
    }
}

#[test]
fn changed_fields_and_inconsistent_frames_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vtkhdf");
    let mut writer = VtkHdfWriter::create(&path).unwrap();
    let good = PolyData::from_surface(0.0, common::surface(0.0, 3));
    writer.append(&good).unwrap();
    let mut fewer = good.clone();
    fewer.fields.pop();
    assert!(writer.append(&fewer).unwrap_err().problem.contains("fields changed"));
    let mut short = good.clone();
    short.fields[0].values.pop();
    assert!(writer.append(&short).unwrap_err().problem.contains("displacement"));
    let mut astray = good.clone();
    astray.cells = Cells::Triangles(vec![[0, 1, 1000]]);
    assert!(writer.append(&astray).unwrap_err().problem.contains("1000"));
    drop(writer);
    assert_eq!(describe(&path).unwrap().steps(), 1);
}

#[test]
fn wrong_files_and_steps_are_errors_with_a_remedy() {
    let dir = tempfile::tempdir().unwrap();
    let missing = describe(&dir.path().join("none.vtkhdf")).unwrap_err();
    assert!(missing.to_string().contains("none.vtkhdf"), "{missing}");
    assert!(!missing.remedy.is_empty());
    assert!(VtkHdfWriter::create(&dir.path().join("no/folder/a.vtkhdf")).is_err());

    let text = dir.path().join("text.vtkhdf");
    std::fs::write(&text, "this is no HDF5").unwrap();
    assert!(describe(&text).is_err());
    assert!(describe(dir.path()).is_err());

    let other = dir.path().join("other.h5");
    hdf5::File::create(&other).unwrap().create_group("something").unwrap();
    assert!(describe(&other).unwrap_err().problem.contains("VTKHDF"));

    let path = dir.path().join("a.vtkhdf");
    write(&path, &[PolyData::from_surface(0.0, common::surface(0.0, 3))]);
    assert!(read_step(&path, Some(1)).unwrap_err().remedy.contains("from 0 to 0"));
}

#[test]
fn tampered_numbers_are_errors() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vtkhdf");
    let tampers: [(&str, i64); 6] = [
        ("VTKHDF/NumberOfPoints", 1 << 60),
        ("VTKHDF/NumberOfPoints", -1),
        ("VTKHDF/Steps/PointOffsets", i64::MAX),
        ("VTKHDF/Steps/PartOffsets", 7),
        ("VTKHDF/Polygons/NumberOfCells", 1),
        ("VTKHDF/Polygons/Connectivity", 1 << 40),
    ];
    for (dataset, value) in tampers {
        write(&path, &[PolyData::from_surface(0.0, common::surface(0.0, 3))]);
        let file = hdf5::File::open_rw(&path).unwrap();
        file.dataset(dataset).unwrap().write_slice(&[value], 0..1).unwrap();
        file.close().unwrap();
        let error = read_step(&path, None).unwrap_err();
        assert!(!error.problem.is_empty(), "{dataset}");
    }
    // A dataset that claims more than the file can hold does not make the reader ask for it.
    write(&path, &[PolyData::from_surface(0.0, common::surface(0.0, 3))]);
    let file = hdf5::File::open_rw(&path).unwrap();
    file.dataset("VTKHDF/Points").unwrap().resize((1 << 50, 3)).unwrap();
    file.dataset("VTKHDF/NumberOfPoints").unwrap().write_slice(&[1_i64 << 50], 0..1).unwrap();
    file.close().unwrap();
    assert!(read_step(&path, None).unwrap_err().problem.contains("more values"));
}

#[test]
fn a_cut_off_file_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vtkhdf");
    write(&path, &[PolyData::from_surface(0.0, common::surface(0.0, 5))]);
    let bytes = std::fs::read(&path).unwrap();
    for part in [0, 100, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..part]).unwrap();
        assert!(read_step(&path, None).is_err(), "{part} of {} bytes", bytes.len());
    }
}

fn any_frame() -> impl Strategy<Value = PolyData> {
    let number = prop_oneof![any::<f64>().prop_filter("NaN differs from itself", |x| !x.is_nan()), -1.0..1.0];
    (
        0_usize..40,
        0_usize..60,
        any::<bool>(),
        -1e3..1e3,
        proptest::collection::vec(number, 40 * 10),
        any::<u64>(),
    )
        .prop_map(|(points, triangles, vertices, time, numbers, seed)| {
            let corner = |k: usize| ((seed >> (k % 50)) as usize % points) as u32;
            let triangles = if points == 0 { 0 } else { triangles };
            let cells = if vertices && points > 0 {
                Cells::Vertices
            } else {
                Cells::Triangles((0..triangles).map(|t| [corner(t), corner(t + 1), corner(t + 7)]).collect())
            };
            let part = |start: usize, c: usize| numbers[start * 40..][..c * points].to_vec();
            PolyData {
                time,
                points: part(0, 3).as_chunks::<3>().0.to_vec(),
                cells,
                fields: vec![
                    PointField { name: "scalar".into(), components: 1, values: part(3, 1) },
                    PointField { name: "tensor".into(), components: 6, values: part(4, 6) },
                ],
            }
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn any_frames_come_back(frames in proptest::collection::vec(any_frame(), 1..5)) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vtkhdf");
        write(&path, &frames);
        for (k, frame) in frames.iter().enumerate() {
            prop_assert_eq!(&read_step(&path, Some(k)).unwrap(), frame);
        }
    }

    #[test]
    fn flipped_bytes_never_panic(at in 0.0..1.0, value in any::<u8>()) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vtkhdf");
        write(&path, &[PolyData::from_surface(0.0, common::surface(0.0, 3))]);
        let mut bytes = std::fs::read(&path).unwrap();
        let i = (at * bytes.len() as f64) as usize;
        bytes[i] = value;
        std::fs::write(&path, &bytes).unwrap();
        let _ = describe(&path);
        let _ = read_step(&path, None);
    }
}
