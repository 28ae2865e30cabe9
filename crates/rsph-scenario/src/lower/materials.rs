//! The materials of a body and where each of them is.

use super::parts::{field, region};
use crate::label_map::{OfLabel, read_label, read_values, volume_field};
use crate::scenario::{
    Document, KeyPath, LabelMapTable, LabelMapValue, MaterialTables, ModulusTable, ScenarioError,
};
use crate::shape_of::{labels, of_table};
use rsph_core::material::Material;
use rsph_core::setup::{MaterialPart, ModulusField, Place, SolidSetup, VectorField, Within};
use std::path::Path;
use std::sync::Arc;

/// A material with what its table says of it.
struct Entry {
    path: KeyPath,
    name: String,
    material: Arc<dyn Material>,
    modulus: Option<ModulusField>,
    fibres: Option<VectorField>,
    place: Where,
}

/// Where a material is.
enum Where {
    /// Wherever no other is.
    Rest,
    /// At a label of the label map.
    Label(u32),
    /// There.
    At(Arc<dyn Place>),
    /// In a file that is not read.
    Unread,
}

/// A solid of these materials, without boundaries and loads, in a body that may be of a label map; `folder` is where relative paths
/// start, `None`: no file is read.
///
/// # Errors
/// A table that is no material, two for the rest of the body or none, or a file that can not be read.
pub fn materials(
    doc: &Document,
    tables: &MaterialTables,
    image: Option<&LabelMapValue>,
    folder: Option<&Path>,
) -> Result<SolidSetup, ScenarioError> {
    let image = image.map(|LabelMapValue(image)| image);
    let labels = image.map_or(Ok(Vec::new()), |image| labels(doc, image))?;
    let mut entries = Vec::new();
    for (path, table) in tables.iter() {
        let material = table.build(doc, &path)?;
        let given = table.name(doc, &path)?;
        let label = labels.iter().find(|(_, name)| name.is_some() && *name == given).map(|(label, _)| *label);
        let place = match (table.region(doc, &path)?, table.shape(doc, &path)?, label, folder) {
            (Some(_), Some(_), ..) => {
                return Err(doc.error(
                    &path.key("shape"),
                    "`region` and `shape` exclude each other: each says where the material is",
                    "remove one of the two",
                ));
            }
            (Some(table), None, ..) => Where::At(Arc::new(region(doc, &path.key("region"), &table)?)),
            (None, Some(shape), _, Some(folder)) => {
                Where::At(Arc::new(Within(of_table(doc, &path.key("shape"), &shape, folder)?.0)))
            }
            (None, Some(_), _, None) => Where::Unread,
            (None, None, Some(label), _) => Where::Label(label),
            (None, None, None, _) => Where::Rest,
        };
        let modulus = match (table.modulus(doc, &path)?, folder) {
            (Some(table), Some(folder)) => Some(modulus(doc, &path.key("modulus"), &table, folder)?),
            _ => None,
        };
        let fibres = match table.fibres(doc, &path)? {
            Some(table) => Some(field(doc, &path.key("fibres"), Some(&table))?),
            None => None,
        };
        let name = given.unwrap_or_else(|| material.name().to_owned());
        entries.push(Entry { path, name, material, modulus, fibres, place });
    }
    for (label, name) in labels.iter().filter_map(|(label, name)| Some((label, name.as_ref()?))) {
        let has_rest = entries.iter().any(|e| matches!(e.place, Where::Rest));
        if !has_rest && entries.iter().all(|e| e.name != *name) {
            return Err(doc.error(
                &KeyPath::from("body.labelmap.labels"),
                format!("label {label} is \"{name}\", and there is no material of that name"),
                format!("add a [[material]] with name = \"{name}\", or one without a name for the rest of the body"),
            ));
        }
    }
    let rest = rest(doc, &mut entries)?;
    let mut solid = SolidSetup::new(rest.material);
    (solid.material_name, solid.modulus, solid.fibres) = (rest.name, rest.modulus, rest.fibres);
    for Entry { path, name, material, modulus, fibres, place } in entries {
        let place = match (place, image, folder) {
            (Where::At(place), ..) => place,
            (Where::Label(label), Some(image), Some(folder)) => {
                voxels(doc, &path, image, (label, &labels), folder)?
            }
            _ => continue,
        };
        solid.parts.push(MaterialPart { name, material, modulus, fibres, place });
    }
    Ok(solid)
}

/// Takes the material of the rest of the body out of `entries`; where every one has a label, the first.
fn rest(doc: &Document, entries: &mut Vec<Entry>) -> Result<Entry, ScenarioError> {
    let is_rest = |e: &Entry| matches!(e.place, Where::Rest);
    let mut places = entries.iter().enumerate().filter(|(_, e)| is_rest(e)).map(|(i, _)| i);
    let remedy = "give it a `region`, a `shape`, or the name of a label of the label map";
    match (places.next(), places.next()) {
        (Some(first), None) => Ok(entries.remove(first)),
        (Some(_), Some(second)) => {
            Err(doc.error(&entries[second].path, "is a second material for the rest of the body", remedy))
        }
        (None, _) if entries.iter().all(|e| matches!(e.place, Where::Label(_))) => Ok(entries.remove(0)),
        (None, _) => Err(doc.error(
            &KeyPath::from("material"),
            "has no material for the rest of the body: each has a region or a shape",
            "add a [[material]] without either",
        )),
    }
}

/// Where a label is, beside the other `labels` of the body.
fn voxels(
    doc: &Document,
    path: &KeyPath,
    image: &LabelMapTable,
    (label, labels): (u32, &[(u32, Option<String>)]),
    folder: &Path,
) -> Result<Arc<dyn Place>, ScenarioError> {
    let read = |label: u32| {
        read_label(&folder.join(&image.path), label).map_err(|e| {
            let problem = format!("{}: {}", e.path.display(), e.problem);
            doc.error(&KeyPath::from("body.labelmap.path"), problem, e.remedy)
        })
    };
    let own = read(label)?;
    let others = labels.iter().filter(|(other, _)| *other != label).map(|(other, _)| Ok(read(*other)?.runs));
    let placement = own.placement(image.scale, image.axes.axes());
    let place = OfLabel::new(own.runs, others.collect::<Result<_, ScenarioError>>()?, placement);
    Ok(Arc::new(place.ok_or_else(|| no_place(doc, path))?))
}

/// The map of a modulus.
fn modulus(
    doc: &Document,
    path: &KeyPath,
    table: &ModulusTable,
    folder: &Path,
) -> Result<ModulusField, ScenarioError> {
    super::checks::positive(doc, &path.key("factor"), table.factor, "the factor of a map of moduli")?;
    if let Some(scale) = table.scale {
        super::checks::positive(doc, &path.key("scale"), scale, "the scale of an image")?;
    }
    let volume = read_values(&folder.join(&table.path)).map_err(|e| {
        let problem = format!("{}: {}", e.path.display(), e.problem);
        doc.error(&path.key("path"), problem, e.remedy)
    })?;
    volume_field(volume, table.axes.axes(), table.scale, table.factor).ok_or_else(|| no_place(doc, path))
}

fn no_place(doc: &Document, path: &KeyPath) -> ScenarioError {
    doc.error(
        path,
        "the image says not where its voxels are: their axes lie in a plane",
        "correct the header, for example with ITK-SNAP or nibabel",
    )
}
