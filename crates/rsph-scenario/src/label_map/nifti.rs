//! The headers of NIfTI-1 and NIfTI-2 (nifti.nimh.nih.gov): what of them a segmentation needs, checked.

use super::image::Header;
use super::number::Number;
use super::{Problem, broken};
use rsph_core::shape::Placement;
use rsph_core::tensor::{Mat3, Vec3};

/// Bytes of a NIfTI-1 and of a NIfTI-2 header.
pub const SIZES: [usize; 2] = [348, 540];
/// Voxels begin before this byte: what comes before is text about the image.
const LAST_START: f64 = 1e8;
/// More voxels than this along an axis are a broken header.
const LONGEST: i64 = 100_000;

/// Places in a header: byte of each entry, and types of numbers that differ between the versions.
struct Layout {
    dim: usize,
    datatype: usize,
    pixdim: usize,
    vox_offset: usize,
    slope: usize,
    units: usize,
    qform: usize,
    sform: usize,
    quaternion: usize,
    rows: usize,
    /// Number types of dimensions, real numbers, the offset, codes of forms, and units.
    types: [Number; 5],
}

const NIFTI_1: Layout = Layout {
    dim: 40,
    datatype: 70,
    pixdim: 76,
    vox_offset: 108,
    slope: 112,
    units: 123,
    qform: 252,
    sform: 254,
    quaternion: 256,
    rows: 280,
    types: [Number::I16, Number::F32, Number::F32, Number::I16, Number::U8],
};

const NIFTI_2: Layout = Layout {
    dim: 16,
    datatype: 12,
    pixdim: 104,
    vox_offset: 168,
    slope: 176,
    units: 500,
    qform: 344,
    sform: 348,
    quaternion: 352,
    rows: 400,
    types: [Number::I64, Number::F64, Number::I64, Number::I32, Number::I32],
};

/// Size of the header that begins with these four bytes, and whether it is big-endian; `None` if it is none.
pub fn kind(start: [u8; 4]) -> Option<(usize, bool)> {
    let (little, big) = (i32::from_le_bytes(start), i32::from_be_bytes(start));
    SIZES.into_iter().find_map(|size| {
        let wanted = size as i32;
        (little == wanted || big == wanted).then_some((size, big == wanted))
    })
}

/// Understands a header; returns where the voxels begin in the file, too.
///
/// # Errors
/// What in it is no segmentation in three dimensions.
pub fn understand(bytes: &[u8]) -> Result<(Header, u64), Problem> {
    let start = bytes.first_chunk().copied().unwrap_or_default();
    let (size, big_endian) = kind(start).ok_or_else(|| broken("is no NIfTI file"))?;
    let first = size == SIZES[0];
    let (layout, magic) = if first { (NIFTI_1, 344) } else { (NIFTI_2, 4) };
    match bytes.get(magic..magic + 3) {
        Some(b"n+1" | b"n+2") => {}
        Some(b"ni1" | b"ni2") => {
            return Err(Problem(
                "is the header of a pair of files (.hdr and .img)".into(),
                "save the image as one file (.nii or .nii.gz)".into(),
            ));
        }
        _ => return Err(broken("is no NIfTI file, although it begins like one")),
    }
    let at = |place: usize, number: Number| number.read(bytes.get(place..).unwrap_or_default(), big_endian);
    let list = |place: usize, number: Number, i: usize| at(place + i * number.bytes(), number);
    let [dims, real, offset, form, units] = layout.types;
    let dim = |i: usize| list(layout.dim, dims, i) as i64;
    let code = at(layout.datatype, Number::I16) as i64;
    let number = Number::from_code(code).ok_or_else(|| {
        Problem(
            format!("has voxels of the type {code}, which are no plain numbers"),
            "save the label map with whole numbers (for example int16)".into(),
        )
    })?;
    let metres = match at(layout.units, units) as i64 & 7 {
        1 => 1.0,
        3 => 1e-6,
        // Millimetres, also where nothing is said.
        _ => 1e-3,
    };
    let slope = at(layout.slope, real);
    let scaling = if slope.is_finite() && slope != 0.0 {
        (slope, at(layout.slope + real.bytes(), real))
    } else {
        (1.0, 0.0)
    };
    // The sizes are positive by the format; programs write others. The first number is no size but a sign.
    let size_of = |i: usize| list(layout.pixdim, real, i);
    let pixdim = [size_of(0), size_of(1).abs(), size_of(2).abs(), size_of(3).abs()];
    let placement = if at(layout.sform, form) > 0.0 {
        let row = |i: usize, j: usize| list(layout.rows, real, 4 * i + j);
        Placement { axes: Mat3::from_fn(row), origin: Vec3::from_fn(|i, _| row(i, 3)) }
    } else if at(layout.qform, form) > 0.0 {
        let q: [f64; 6] = std::array::from_fn(|i| list(layout.quaternion, real, i));
        Placement { axes: rotation([q[0], q[1], q[2]], &pixdim), origin: Vec3::new(q[3], q[4], q[5]) }
    } else {
        let edges = Vec3::new(pixdim[1], pixdim[2], pixdim[3]);
        Placement { axes: Mat3::from_diagonal(&edges), origin: Vec3::zeros() }
    };
    let offset = at(layout.vox_offset, offset);
    if !(offset >= size as f64 && offset < LAST_START) {
        return Err(broken(format!("says that its voxels begin at byte {offset}, which can not be")));
    }
    let size = voxels(&std::array::from_fn(dim))?;
    Ok((Header { size, number, scaling, placement, metres, big_endian }, offset as u64))
}

/// The size of an image in three dimensions.
fn voxels(dim: &[i64; 8]) -> Result<[usize; 3], Problem> {
    let count = dim[0];
    if !(1..=7).contains(&count) {
        return Err(broken(format!("says that it has {count} dimensions")));
    }
    let along = |i: usize| if i as i64 <= count { dim[i] } else { 1 };
    if let Some(i) = (4..8).find(|&i| along(i) > 1) {
        return Err(Problem(
            format!(
                "has {} images along dimension {i}; a segmentation is one image of three dimensions",
                along(i)
            ),
            "save one of them, with numbers for the organs".into(),
        ));
    }
    if let Some(i) = (1..4).find(|&i| !(1..=LONGEST).contains(&along(i))) {
        return Err(broken(format!("says that it has {} voxels along dimension {i}", along(i))));
    }
    Ok(std::array::from_fn(|i| along(i + 1) as usize))
}

/// The axes of a quaternion (b, c, d) with these edges of voxels; the sign of the third is `pixdim[0]`.
fn rotation([b, c, d]: [f64; 3], pixdim: &[f64; 4]) -> Mat3 {
    let a = (1.0 - b * b - c * c - d * d).max(0.0).sqrt();
    let turn = Mat3::new(
        a * a + b * b - c * c - d * d,
        2.0 * (b * c - a * d),
        2.0 * (b * d + a * c),
        2.0 * (b * c + a * d),
        a * a + c * c - b * b - d * d,
        2.0 * (c * d - a * b),
        2.0 * (b * d - a * c),
        2.0 * (c * d + a * b),
        a * a + d * d - b * b - c * c,
    );
    let handed = if pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    turn * Mat3::from_diagonal(&Vec3::new(pixdim[1], pixdim[2], handed * pixdim[3]))
}
