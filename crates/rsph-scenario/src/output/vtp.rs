//! VTP (VTK XML `PolyData`): one moment as one small file that every VTK program opens.

use super::atomic;
use super::polydata::{Cells, Frame, PolyData};
use crate::sink::SinkError;
use base64::prelude::{BASE64_STANDARD, Engine};
use std::fmt::Write;
use std::path::Path;

/// Writes `frame` to `path` as VTP with inline base64 arrays, which keep every bit.
///
/// # Errors
/// When the frame is inconsistent or the file can not be stored.
pub fn write(path: &Path, frame: &PolyData) -> Result<(), SinkError> {
    frame.check().map_err(|e| SinkError::new(path, e))?;
    atomic::write(path, to_text(frame).as_bytes())
}

/// The text of the file.
fn to_text(frame: &PolyData) -> String {
    let points = frame.points.len();
    let vertices: Vec<[u32; 1]> = match frame.cells {
        Cells::Vertices => (0..points as u32).map(|i| [i]).collect(),
        Cells::Triangles(_) => Vec::new(),
    };
    let triangles: &[[u32; 3]] = match &frame.cells {
        Cells::Vertices => &[],
        Cells::Triangles(t) => t,
    };
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<PolyData>\n",
    );
    out += "<FieldData>\n";
    floats(&mut out, "TimeValue", "NumberOfTuples=\"1\"", [frame.time]);
    out += "</FieldData>\n";
    let _ = writeln!(
        out,
        "<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"{}\">\n<PointData>",
        vertices.len(),
        triangles.len()
    );
    for f in &frame.fields {
        let components = format!("NumberOfComponents=\"{}\"", f.components);
        floats(&mut out, &f.name, &components, f.values.iter().copied());
    }
    out += "</PointData>\n<Points>\n";
    let coordinates = frame.points.iter().flatten().copied();
    floats(&mut out, "Points", "NumberOfComponents=\"3\"", coordinates);
    out += "</Points>\n";
    cells(&mut out, "Verts", &vertices);
    cells(&mut out, "Polys", triangles);
    out + "</Piece>\n</PolyData>\n</VTKFile>\n"
}

fn cells<const C: usize>(out: &mut String, name: &str, corners: &[[u32; C]]) {
    let _ = writeln!(out, "<{name}>");
    let ids = corners.iter().flatten().map(|&i| i64::from(i).to_le_bytes());
    array(out, "Int64", "connectivity", "", ids);
    array(out, "Int64", "offsets", "", (1..=corners.len()).map(|k| ((k * C) as i64).to_le_bytes()));
    let _ = writeln!(out, "</{name}>");
}

fn floats(out: &mut String, name: &str, shape: &str, values: impl IntoIterator<Item = f64>) {
    array(out, "Float64", name, shape, values.into_iter().map(f64::to_le_bytes));
}

/// An array of 8-byte numbers; its length in bytes goes before it.
fn array(out: &mut String, kind: &str, name: &str, shape: &str, values: impl IntoIterator<Item = [u8; 8]>) {
    let mut bytes = vec![0; 8];
    bytes.extend(values.into_iter().flatten());
    let length = bytes.len() as u64 - 8;
    bytes[..8].copy_from_slice(&length.to_le_bytes());
    let name = escape(name);
    let _ = writeln!(out, "<DataArray type=\"{kind}\" Name=\"{name}\" {shape} format=\"binary\">");
    BASE64_STANDARD.encode_string(&bytes, out);
    out.push_str("\n</DataArray>\n");
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
