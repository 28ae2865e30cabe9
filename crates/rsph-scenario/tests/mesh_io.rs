//! Mesh files: what is written is read again, and what is broken is refused with a reason.

#![allow(clippy::format_push_string, clippy::format_collect)]

use proptest::prelude::*;
use rsph_core::mesh::TriangleMesh;
use rsph_core::shape::{BoxShape, Shape};
use rsph_core::surface::SurfaceField;
use rsph_core::tensor::Vec3;
use rsph_scenario::mesh_io::{MeshError, read_mesh, read_mesh_with_parts, write_mesh};
use std::fs;
use std::path::{Path, PathBuf};

fn cube() -> TriangleMesh {
    BoxShape::new(Vec3::new(1.0, 2.0, 4.0), Vec3::new(-0.5, 0.0, 1.0)).unwrap().surface().clone()
}

fn file(folder: &tempfile::TempDir, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn assert_is_cube(path: &Path) {
    let mesh = read_mesh(path, 1.0).unwrap().merged();
    assert!(mesh.is_closed(), "{}", path.display());
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (8, 12));
    assert!((mesh.volume() - 8.0).abs() < 1e-9, "{}", mesh.volume());
    assert_eq!(mesh.bounds().unwrap().min, Vec3::new(-0.5, 0.0, 1.0));
}

/// An ASCII STL file of the cube.
fn ascii_stl(first_line: &str) -> String {
    let m = cube();
    let mut text = format!("{first_line}\n");
    for t in 0..m.triangles.len() {
        text += " facet normal 0 0 0\n  outer loop\n";
        for v in m.corners(t) {
            text += &format!("   vertex {} {:e} {}\n", v.x, v.y, v.z);
        }
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid\n"
}

/// A glTF scene with the cube below two nodes: the outer one moves it, the inner one scales it.
fn gltf(extra: &str) -> String {
    let m = cube();
    let mut bytes: Vec<u8> =
        m.vertices.iter().flat_map(|v| [v.x, v.y, v.z]).flat_map(|c| (c as f32).to_le_bytes()).collect();
    let positions = bytes.len();
    bytes.extend(m.triangles.iter().flatten().flat_map(|&v| (v as u16).to_le_bytes()));
    let (indices, total) = (bytes.len() - positions, bytes.len());
    let data = base64(&bytes);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"children":[1],"translation":[10,0,0]}},{{"mesh":0,"scale":[2,2,-2]}}{extra}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "buffers":[{{"byteLength":{total},"uri":"data:application/octet-stream;base64,{data}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{positions}}},
            {{"buffer":0,"byteOffset":{positions},"byteLength":{indices}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3",
            "min":[-0.5,0,1],"max":[0.5,2,5]}},
            {{"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}}]}}"#
    )
}

fn base64(bytes: &[u8]) -> String {
    let digits: Vec<char> = ('A'..='Z').chain('a'..='z').chain('0'..='9').chain(['+', '/']).collect();
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let word = (0..3).fold(0, |w, i| w << 8 | chunk.get(i).map_or(0, |&b| u32::from(b)));
        for i in 0..4 {
            let digit = digits[(word >> (18 - 6 * i)) as usize & 63];
            text.push(if i > chunk.len() { '=' } else { digit });
        }
    }
    text
}

#[test]
fn solids_nodes_meshes_and_materials_are_named_parts() {
    let folder = tempfile::tempdir().unwrap();
    let two = ascii_stl("solid left lobe") + &ascii_stl("solid right lobe");
    let read = read_mesh_with_parts(&file(&folder, "two.stl", two), 1.0).unwrap();
    let halves = [("left lobe", 0..12), ("right lobe", 12..24)];
    let halves = halves.map(|(name, triangles)| (name.to_owned(), triangles.collect::<Vec<u32>>()));
    assert_eq!(read.parts, halves.into());

    let named = gltf("")
        .replace("{\"mesh\":0,", "{\"mesh\":0,\"name\":\"node\",")
        .replace("\"meshes\":[{", "\"materials\":[{\"name\":\"red\"}],\"meshes\":[{\"name\":\"mesh\",")
        .replace("\"indices\":1", "\"indices\":1,\"material\":0");
    let read = read_mesh_with_parts(&file(&folder, "named.gltf", named), 1.0).unwrap();
    let all: Vec<u32> = (0..12).collect();
    assert_eq!(read.parts, ["mesh", "node", "red"].map(|name| (name.to_owned(), all.clone())).into());
    assert!(read_mesh_with_parts(&file(&folder, "a.gltf", gltf("")), 1.0).unwrap().parts.is_empty());
}

#[test]
fn every_written_format_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.stl", "a.OBJ", "a.ply"] {
        let path = folder.path().join(name);
        write_mesh(&path, &cube(), &[]).unwrap();
        assert_is_cube(&path);
    }
}

#[test]
fn ascii_stl_is_read_whatever_its_first_line() {
    let folder = tempfile::tempdir().unwrap();
    for line in ["solid", "solid cube", "SOLID cube\r", "solid caf\u{e9}"] {
        assert_is_cube(&file(&folder, "a.stl", ascii_stl(line)));
    }
}

#[test]
fn a_binary_stl_that_begins_with_solid_is_binary() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.stl");
    write_mesh(&path, &cube(), &[]).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    bytes[..10].copy_from_slice(b"solid cube");
    assert_is_cube(&file(&folder, "a.stl", bytes));
}

#[test]
fn polygons_are_divided() {
    let folder = tempfile::tempdir().unwrap();
    let v = ["-0.5 0 1", "0.5 0 1", "-0.5 2 1", "0.5 2 1", "-0.5 0 5", "0.5 0 5", "-0.5 2 5", "0.5 2 5"];
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut obj: String = v.iter().map(|v| format!("v {v}\n")).collect();
    obj += "mtllib missing.mtl\nusemtl skin\n";
    let mut ply =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 6\nproperty list uchar int vertex_index\nend_header\n"
            .to_string();
    ply += &v.join("\n");
    for [a, b, c, d] in quads {
        obj += &format!("f {} {} {} {}\n", a + 1, b + 1, c + 1, d + 1);
        ply += &format!("\n4 {a} {b} {c} {d}");
    }
    assert_is_cube(&file(&folder, "a.obj", obj));
    assert_is_cube(&file(&folder, "a.ply", ply + "\n"));
}

#[test]
fn a_gltf_scene_is_put_where_its_nodes_say() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = read_mesh(&file(&folder, "a.gltf", gltf("")), 0.1).unwrap().merged();
    assert!(mesh.is_closed());
    // Twice as large, mirrored but still outward, then moved, then a tenth of it.
    assert!((mesh.volume() - 0.064).abs() < 1e-9, "{}", mesh.volume());
    let b = mesh.bounds().unwrap();
    assert!((b.min - Vec3::new(0.9, 0.0, -1.0)).norm() < 1e-9 && (b.max.x - 1.1).abs() < 1e-9, "{b:?}");
}

#[test]
fn fields_become_vertex_properties_of_ply() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    let fields = [
        SurfaceField { name: "von_mises", components: 1, values: (0..8).map(f64::from).collect() },
        SurfaceField { name: "displacement", components: 3, values: vec![0.5; 24] },
    ];
    write_mesh(&path, &cube(), &fields).unwrap();
    let bytes = fs::read(&path).unwrap();
    let header = String::from_utf8_lossy(&bytes[..400]).into_owned();
    for name in ["double von_mises", "double displacement_x", "double displacement_z"] {
        assert!(header.contains(name), "{header}");
    }
    assert_is_cube(&path);
}

#[test]
fn ascii_stl_as_programs_write_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let cube = ascii_stl("solid cube");
    for (name, text) in [
        ("crlf.stl", cube.replace('\n', "\r\n")),
        ("upper_case.stl", cube.to_uppercase()),
        ("no_normals.stl", cube.replace("normal 0 0 0", "normal nan -nan(ind) nan")),
        ("no_end.stl", cube.replace("endsolid\n", "")),
    ] {
        assert_is_cube(&file(&folder, name, text));
    }
    let twice = file(&folder, "two_solids.stl", cube.clone() + &cube);
    assert_eq!(read_mesh(&twice, 1.0).unwrap().triangles.len(), 24);
}

/// The cube as OBJ, with something after each line of a face.
fn obj_cube(after: &str) -> String {
    let m = cube();
    let vertices: String = m.vertices.iter().map(|v| format!("v {} {} {}\n", v.x, v.y, v.z)).collect();
    let faces =
        m.triangles.iter().map(|t| format!("f {}/1 {}/1 {}/1{after}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices + &faces.collect::<String>()
}

#[test]
fn texts_of_any_encoding_with_comments_and_continued_lines_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let utf_16 = |text: &str, unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(unit).collect()
    };
    let latin_1: Vec<u8> =
        format!("# Knöchel, rechts\no Leber Größe\n{}", obj_cube("")).chars().map(|c| c as u8).collect();
    let stl = ascii_stl("solid cube");
    let with_mark = |text: &str| format!("\u{feff}{text}").into_bytes();
    for (name, bytes) in [
        ("latin_1.obj", latin_1.clone()),
        ("mark.obj", with_mark(&obj_cube(""))),
        ("wide.obj", utf_16(&obj_cube(""), u16::to_le_bytes)),
        ("comments.obj", obj_cube(" # a face, \u{fe}").into_bytes()),
        ("close_comments.obj", obj_cube("# a face").into_bytes()),
        ("carriage.obj", obj_cube("\r").into_bytes()),
        ("continued.obj", obj_cube("").replace("/1 ", "/1 \\\n  ").into_bytes()),
        ("from_the_end.obj", backwards().into_bytes()),
        ("mark.stl", with_mark(&stl)),
        ("wide.stl", utf_16(&stl, u16::to_le_bytes)),
        ("wide_big_endian.stl", utf_16(&stl, u16::to_be_bytes)),
        ("blanks.stl", format!("\n  {stl}\n\n").into_bytes()),
    ] {
        assert_is_cube(&file(&folder, name, bytes));
    }
    let parts = read_mesh_with_parts(&file(&folder, "latin_1.obj", latin_1), 1.0).unwrap().parts;
    assert_eq!(parts.keys().collect::<Vec<_>>(), ["Leber Größe"]);
}

/// The cube as OBJ, its vertices counted from the end.
fn backwards() -> String {
    let m = cube();
    let vertices: String = m.vertices.iter().map(|v| format!("v {} {} {}\n", v.x, v.y, v.z)).collect();
    let number = |v: u32| i64::from(v) - m.vertices.len() as i64;
    let faces = m.triangles.iter().map(|t| format!("f {} {} {}\n", number(t[0]), number(t[1]), number(t[2])));
    vertices + &faces.collect::<String>()
}

#[test]
fn binary_stl_is_known_by_its_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.stl");
    write_mesh(&path, &cube(), &[]).unwrap();
    let plain = fs::read(&path).unwrap();
    for header in [&b"solid cube"[..], b"SOLID\nfacet", b"COLOR=", b"\xef\xbb\xbfsolid"] {
        for tail in [&b""[..], b"\n", b"\r\n", &[0; 512], b"made by a program that says so"] {
            let mut bytes = plain.clone();
            bytes[..header.len()].copy_from_slice(header);
            bytes.extend(tail);
            assert_is_cube(&file(&folder, "a.stl", bytes));
        }
    }
    let mut cut = plain.clone();
    cut[..5].copy_from_slice(b"solid");
    cut.truncate(300);
    let said = problem(&file(&folder, "cut.stl", cut));
    assert!(said.contains("announces 12 triangles"), "{said}");
}

/// A prism below a polygon: an L, a comb with corners on its straight sides, a spiral.
#[test]
fn polygons_with_dents_are_cut_within_them() {
    let folder = tempfile::tempdir().unwrap();
    let l = vec![[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    let mut comb = vec![[0.0, -1.0], [2.0, -1.0], [7.0, -1.0]];
    for k in (0..4).rev() {
        let x = 2.0 * f64::from(k);
        comb.extend([[x + 1.0, 0.0], [x + 1.0, 2.0], [x + 0.5, 2.0], [x, 2.0], [x, 0.0]]);
    }
    let spiral: Vec<[f64; 2]> = (0..60)
        .map(|k| (k, 1.0))
        .chain((0..60).rev().map(|k| (k, 0.6)))
        .map(|(k, width)| {
            let angle = 0.25 * f64::from(k);
            [(angle + width) * angle.cos(), (angle + width) * angle.sin()]
        })
        .collect();
    for (name, outline) in [("l", l), ("comb", comb), ("spiral", spiral)] {
        let n = outline.len();
        let area = 0.5 * (0..n).map(|i| cross(outline[i], outline[(i + 1) % n])).sum::<f64>();
        for start in [0, 1, n / 2] {
            let mut obj = String::new();
            for z in [0.0, 1.0] {
                for [x, y] in &outline {
                    obj += &format!("v {x} {y} {z}\n");
                }
            }
            let list = |numbers: Vec<usize>| {
                format!("f {}\n", numbers.iter().map(|v| format!("{v} ")).collect::<String>())
            };
            let at = |i: usize| (i + start) % n + 1;
            obj += &list((0..n).rev().map(at).collect());
            obj += &list((0..n).map(|i| at(i) + n).collect());
            for i in 0..n {
                let (a, b) = (at(i), at(i + 1));
                obj += &list(vec![a, b, b + n, a + n]);
            }
            let mesh = read_mesh(&file(&folder, "a.obj", obj), 1.0).unwrap();
            assert!(mesh.is_closed(), "{name} from {start}");
            assert_eq!(mesh.triangles.len(), 4 * n - 4);
            assert!((mesh.volume() - area).abs() < 1e-9 * area, "{name}: {} {area}", mesh.volume());
            // Triangles within the outline have its area together, others more.
            assert!((mesh.area() - sides(&outline) - 2.0 * area).abs() < 1e-9 * area, "{name} from {start}");
        }
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn sides(outline: &[[f64; 2]]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
}

#[test]
fn strips_of_ply_turn_every_other_triangle_and_end_at_minus_one() {
    let folder = tempfile::tempdir().unwrap();
    let v = ["-0.5 0 1", "0.5 0 1", "-0.5 2 1", "0.5 2 1", "-0.5 0 5", "0.5 0 5", "-0.5 2 5", "0.5 2 5"];
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
         element tristrips 1\nproperty list int int vertex_indices\nend_header\n{}\n\
         21 0 1 4 5 6 7 2 3 0 1 -1 0 4 2 6 -1 1 3 5 7 -1\n",
        v.join("\n")
    );
    assert_is_cube(&file(&folder, "a.ply", ply));
}

#[test]
fn a_gltf_file_without_a_scene_shows_all_of_its_nodes() {
    let folder = tempfile::tempdir().unwrap();
    let with = gltf("");
    let without = with.replace(r#""scene":0,"scenes":[{"nodes":[0]}],"#, "");
    assert_ne!(with, without);
    let [with, without] = [with, without].map(|text| read_mesh(&file(&folder, "a.gltf", text), 1.0).unwrap());
    assert_eq!(with, without);
}

fn problem(path: &Path) -> String {
    let error = read_mesh(path, 1.0).unwrap_err();
    assert_eq!(error.path(), path);
    assert!(!error.remedy().is_empty());
    error.to_string()
}

#[test]
fn broken_files_are_refused_with_path_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    let mut stl = vec![0; 84];
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nend_header\n";
    let cases: [(&str, Vec<u8>, &str); 16] = [
        ("empty.stl", vec![], "is empty"),
        ("count.stl", stl, "announces 4294967295 triangles"),
        ("none.stl", vec![0; 84], "no triangle"),
        ("text.stl", b"solid x\nfacet normal 0 0 0\nouter loop\nvertex 1 2 q\n".to_vec(), "STL"),
        ("empty.obj", vec![], "is empty"),
        ("index.obj", b"v 0 0 0\nf 1 2 3\n".to_vec(), "OBJ"),
        ("number.obj", b"v 0 0 x\n".to_vec(), "OBJ"),
        ("empty.ply", vec![], "is empty"),
        ("short.ply", format!("{ply}0 0 0\n").into_bytes(), "PLY"),
        ("huge.ply", ply.replace("vertex 3", "vertex 999999999999").into_bytes(), "more than the"),
        ("bare.ply", b"ply\nformat ascii 1.0\nelement vertex 9\nend_header\n".to_vec(), "property \"x\""),
        ("empty.glb", vec![], "is empty"),
        ("cycle.gltf", gltf(r#",{"children":[2]}"#).replace("[1]", "[1,1]").into_bytes(), "glTF"),
        ("accessor.gltf", gltf("").replace("\"POSITION\":0", "\"POSITION\":7").into_bytes(), "accessor 7"),
        ("buffer.gltf", gltf("").replace("data:app", "/dev/zero#").into_bytes(), "beside the file"),
        ("count.gltf", gltf("").replace("\"count\":8", "\"count\":800").into_bytes(), "beyond its buffer"),
    ];
    for (name, bytes, expected) in cases {
        let message = problem(&file(&folder, name, bytes));
        assert!(message.contains(expected) && message.contains(name), "{name}: {message}");
    }
}

#[test]
fn missing_files_folders_formats_and_scales_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(read_mesh(&folder.path().join("no.stl"), 1.0), Err(MeshError::File { .. })));
    fs::create_dir(folder.path().join("dir.stl")).unwrap();
    assert!(problem(&folder.path().join("dir.stl")).contains("this is a folder"));
    assert!(problem(&folder.path().join("a.step")).contains("stl, obj, ply, glb, gltf"));
    let path = folder.path().join("a.stl");
    write_mesh(&path, &cube(), &[]).unwrap();
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(read_mesh(&path, scale), Err(MeshError::Scale { .. })));
    }
    assert!(matches!(
        write_mesh(&folder.path().join("a.xyz"), &cube(), &[]),
        Err(MeshError::UnknownFormat { .. })
    ));
    assert!(matches!(write_mesh(&folder.path().join("no/a.stl"), &cube(), &[]), Err(MeshError::File { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// Files with some bytes changed and an end cut off are read or refused, but never panic.
    #[test]
    fn damaged_files_never_panic(
        format in 0..6_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        digits in prop::collection::vec((any::<prop::sample::Index>(), b'0'..=b'9'), 0..6),
        keep in 0.3..1.6_f64,
    ) {
        let folder = tempfile::tempdir().unwrap();
        let name = ["a.stl", "a.obj", "a.ply", "b.stl", "a.gltf", "a.glb"][format];
        let path = folder.path().join(name);
        match format {
            3 => fs::write(&path, ascii_stl("solid")).unwrap(),
            4 => fs::write(&path, gltf("")).unwrap(),
            5 => fs::write(&path, glb()).unwrap(),
            _ => write_mesh(&path, &cube(), &[]).unwrap(),
        }
        let mut bytes = fs::read(&path).unwrap();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        // Numbers that stay numbers get past the syntax and reach the sizes.
        for (at, value) in digits {
            let at = at.index(bytes.len());
            if bytes[at].is_ascii_digit() {
                bytes[at] = value;
            }
        }
        let length = (bytes.len() as f64 * keep) as usize;
        bytes.truncate(length);
        fs::write(&path, bytes).unwrap();
        let _ = read_mesh(&path, 1.0);
    }
}

/// The scene as a binary file: the same text in its one chunk.
fn glb() -> Vec<u8> {
    let mut json = gltf("").into_bytes();
    while !json.len().is_multiple_of(4) {
        json.push(b' ');
    }
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((json.len() as u32 + 20).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes
}
