//! NIfTI-1 images of a field: plain or compressed, 32-bit numbers on the grid of another image.

use super::atomic;
use crate::label_map::ImageGrid;
use crate::sink::SinkError;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Bytes of the header and of the four that follow it.
const HEADER: usize = 352;
/// More voxels than this along an axis do not fit into the header.
const LONGEST: usize = i16::MAX as usize;

/// What the values of a voxel are together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// A number.
    Scalar,
    /// A displacement, x to the right, y to the front, z up; in the units of the image.
    Displacement,
    /// Any other vector along these axes.
    Vector,
    /// A symmetric matrix: XX XY YY XZ YZ ZZ.
    Symmetric,
    /// A matrix of three rows and columns, row by row.
    Matrix,
}

impl Meaning {
    /// Values a voxel.
    pub fn components(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Displacement | Self::Vector => 3,
            Self::Symmetric => 6,
            Self::Matrix => 9,
        }
    }

    /// Its intent code in the standard, with the parameters.
    fn intent(self) -> (i16, [f32; 2]) {
        match self {
            Self::Scalar => (0, [0.0; 2]),
            Self::Matrix => (1004, [3.0; 2]),
            Self::Symmetric => (1005, [3.0, 0.0]),
            Self::Displacement => (1006, [0.0; 2]),
            Self::Vector => (1007, [0.0; 2]),
        }
    }
}

/// A field on the voxels that lie in a body.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelField {
    /// Name of the field.
    pub name: String,
    /// What its values are.
    pub meaning: Meaning,
    /// Numbers of the voxels in the body, in rising order: i + nx (j + ny k).
    pub voxels: Vec<u64>,
    /// Their values, voxel by voxel.
    pub values: Vec<f32>,
}

/// Writes `field` to `path`, compressed if it ends with `.gz`; other voxels of `grid` hold `outside`.
///
/// # Errors
/// When the image does not fit into the format or the file can not be stored.
pub fn write(path: &Path, grid: &ImageGrid, field: &VoxelField, outside: f32) -> Result<(), SinkError> {
    if grid.size.iter().any(|n| *n > LONGEST) {
        return Err(SinkError::new(path, format!("more than {LONGEST} voxels along an axis do not fit")));
    }
    let compressed = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    atomic::replace(path, |part| {
        let fill = || -> io::Result<()> {
            let file = BufWriter::new(File::create(part)?);
            if compressed {
                let mut stream = GzEncoder::new(file, Compression::fast());
                put(&mut stream, grid, field, outside)?;
                return stream.finish()?.flush();
            }
            let mut file = file;
            put(&mut file, grid, field, outside)?;
            file.flush()
        };
        fill().map_err(|e| SinkError::io(path, e))
    })
}

fn put(out: &mut dyn Write, grid: &ImageGrid, field: &VoxelField, outside: f32) -> io::Result<()> {
    out.write_all(&header(grid, field))?;
    let row_length = grid.size[0];
    let rows = grid.size[1] as u64 * grid.size[2] as u64;
    let components = field.meaning.components();
    let mut row = Vec::with_capacity(4 * row_length);
    for c in 0..components {
        let mut inside = field.voxels.iter().zip(field.values.chunks_exact(components)).peekable();
        for k in 0..rows {
            row.clear();
            for number in k * row_length as u64..(k + 1) * row_length as u64 {
                let value = inside.next_if(|(voxel, _)| **voxel == number).map_or(outside, |(_, v)| v[c]);
                row.extend(value.to_le_bytes());
            }
            out.write_all(&row)?;
        }
    }
    Ok(())
}

/// The header, little-endian, with the place of the voxels as `sform`.
fn header(grid: &ImageGrid, field: &VoxelField) -> Vec<u8> {
    let mut bytes = vec![0; HEADER];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    let components = field.meaning.components();
    let [nx, ny, nz] = grid.size.map(|n| n as i16);
    let dimensions: i16 = if components > 1 { 5 } else { 3 };
    put(0, &348_i32.to_le_bytes());
    for (i, n) in [dimensions, nx, ny, nz, 1, components as i16, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    let (intent, parameters) = field.meaning.intent();
    for (i, p) in parameters.into_iter().enumerate() {
        put(56 + 4 * i, &p.to_le_bytes());
    }
    put(68, &intent.to_le_bytes());
    // 32-bit real numbers.
    put(70, &16_i16.to_le_bytes());
    put(72, &32_i16.to_le_bytes());
    put(76, &1.0_f32.to_le_bytes());
    for i in 0..3 {
        let edge = grid.placement.axes.column(i).norm() as f32;
        put(80 + 4 * i, &edge.to_le_bytes());
    }
    put(92, &1.0_f32.to_le_bytes());
    put(96, &1.0_f32.to_le_bytes());
    put(108, &(HEADER as f32).to_le_bytes());
    put(112, &1.0_f32.to_le_bytes());
    // Metres, millimetres or micrometres, and seconds.
    let length = if grid.metres > 0.1 { 1 } else { 3 - u8::from(grid.metres > 1e-4) };
    put(123, &[length | 8]);
    put(148, b"rsph");
    // Coordinates of the scanner.
    put(254, &1_i16.to_le_bytes());
    for i in 0..3 {
        for j in 0..4 {
            let x = if j < 3 { grid.placement.axes[(i, j)] } else { grid.placement.origin[i] };
            put(280 + 16 * i + 4 * j, &(x as f32).to_le_bytes());
        }
    }
    let name = field.name.as_bytes();
    put(328, &name[..name.len().min(15)]);
    put(344, b"n+1\0");
    bytes
}
