//! The headers of NRRD files (teem.sourceforge.net/nrrd/format.html), as 3D Slicer writes segmentations: what of them a label map
//! needs, checked.

use super::image::{Data, Header};
use super::number::Number;
use super::{Problem, broken};
use rsph_core::shape::Placement;
use rsph_core::tensor::{Mat3, Vec3};
use std::collections::HashMap;

/// The first bytes of a file; a version follows.
pub const START: &[u8] = b"NRRD";
/// Lines are read up to this byte: what is longer is no header.
pub const LONGEST: usize = 1_000_000;
/// More voxels than this along an axis are a broken header.
const LONGEST_AXIS: usize = 100_000;

/// Understands the text before the first empty line.
///
/// # Errors
/// What in it is no label map in three dimensions.
pub fn understand(text: &str) -> Result<(Header, Data), Problem> {
    let fields: HashMap<String, &str> = text
        .lines()
        .skip(1)
        .filter(|line| !line.starts_with('#'))
        // `key:=value` is no field.
        .filter_map(|line| line.split_once(": "))
        .map(|(field, value)| (field.trim().to_lowercase(), value.trim()))
        .collect();
    let field = |names: &[&str]| names.iter().find_map(|name| fields.get(*name).copied());
    let needed = |name: &str| {
        field(&[name]).ok_or_else(|| broken(format!("is no whole NRRD file: its header has no \"{name}\"")))
    };
    let dimension = needed("dimension")?;
    let sizes: Vec<usize> = needed("sizes")?.split_whitespace().map_while(|n| n.parse().ok()).collect();
    let size: [usize; 3] =
        sizes.as_slice().try_into().ok().filter(|_| dimension == "3").ok_or_else(|| {
            Problem(
                format!("has {dimension} dimensions; a segmentation is one image of three"),
                "export one label map, not several layers in one file".into(),
            )
        })?;
    if let Some(n) = size.into_iter().find(|n| !(1..=LONGEST_AXIS).contains(n)) {
        return Err(broken(format!("says that it has {n} voxels along an axis")));
    }
    let kind = needed("type")?;
    let number = number(kind).ok_or_else(|| {
        Problem(
            format!("has voxels of the type \"{kind}\", which are no plain numbers"),
            "save the label map with whole numbers (for example short)".into(),
        )
    })?;
    let file = field(&["data file", "datafile"]).map(str::to_owned);
    let data = match needed("encoding")?.to_lowercase().as_str() {
        "raw" => Data { file, is_packed: false },
        "gzip" | "gz" => Data { file, is_packed: true },
        other => {
            return Err(Problem(
                format!("has voxels in the encoding \"{other}\"; raw and gzip are read"),
                "save it with gzip".into(),
            ));
        }
    };
    if let Some(skip) = ["line skip", "lineskip", "byte skip", "byteskip"]
        .iter()
        .find(|name| fields.get(**name).is_some_and(|n| *n != "0"))
    {
        return Err(Problem(
            format!("has a \"{skip}\", which is not read"),
            "save it as one file (.nrrd)".into(),
        ));
    }
    let (placement, metres) = placement(&field)?;
    Ok((
        Header {
            size,
            number,
            scaling: (1.0, 0.0),
            placement,
            metres,
            big_endian: field(&["endian"]).is_some_and(|order| order.eq_ignore_ascii_case("big")),
        },
        data,
    ))
}

fn number(name: &str) -> Option<Number> {
    Some(match name.to_lowercase().as_str() {
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Number::U8,
        "signed char" | "int8" | "int8_t" => Number::I8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Number::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Number::U16,
        "int" | "signed int" | "int32" | "int32_t" => Number::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Number::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Number::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Number::U64,
        "float" => Number::F32,
        "double" => Number::F64,
        _ => return None,
    })
}

/// Where the voxels are, as NIfTI has it: x to the patient's right, y to the front, z up; and from these units to metres.
fn placement<'a>(field: &dyn Fn(&[&str]) -> Option<&'a str>) -> Result<(Placement, f64), Problem> {
    let unclear = || {
        Problem(
            "does not say where its voxels are".into(),
            "export it again with its orientation, or give it as NIfTI".into(),
        )
    };
    let axes = match (field(&["space directions"]), field(&["spacings"])) {
        (Some(text), _) => {
            let columns: Option<Vec<Vec3>> =
                text.split(')').filter(|c| !c.trim().is_empty()).map(vector).collect();
            let columns: [Vec3; 3] = columns.and_then(|c| c.try_into().ok()).ok_or_else(unclear)?;
            Mat3::from_columns(&columns)
        }
        (None, Some(text)) => {
            let edges = vector(&text.split_whitespace().collect::<Vec<_>>().join(",")).ok_or_else(unclear)?;
            Mat3::from_diagonal(&edges.abs())
        }
        (None, None) => Mat3::identity(),
    };
    let origin = field(&["space origin"]).map_or(Some(Vec3::zeros()), vector).ok_or_else(unclear)?;
    let space = field(&["space"]).unwrap_or_default().to_lowercase();
    let letters: String = match space.split('-').collect::<Vec<_>>().as_slice() {
        [one] => (*one).to_owned(),
        words => words.iter().filter_map(|word| word.chars().next()).collect(),
    };
    let signs = match letters.get(..3) {
        Some("lps") => Vec3::new(-1.0, -1.0, 1.0),
        Some("las") => Vec3::new(-1.0, 1.0, 1.0),
        // Right, anterior, superior; or a space of no patient.
        _ => Vec3::repeat(1.0),
    };
    let to_ras = Mat3::from_diagonal(&signs);
    let unit = field(&["space units", "units"]).and_then(|text| text.split('"').nth(1)).unwrap_or("mm");
    let metres = match unit {
        "m" => 1.0,
        "cm" => 1e-2,
        "um" | "\u{b5}m" => 1e-6,
        _ => 1e-3,
    };
    Ok((Placement { axes: to_ras * axes, origin: to_ras * origin }, metres))
}

/// Three numbers in brackets or without.
fn vector(text: &str) -> Option<Vec3> {
    let numbers: Option<Vec<f64>> = text
        .trim()
        .trim_matches(['(', ')'])
        .split(',')
        .map(|number| number.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    numbers.filter(|n| n.len() == 3).map(|n| Vec3::from_column_slice(&n))
}
