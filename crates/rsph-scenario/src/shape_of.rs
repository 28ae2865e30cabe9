//! The body's shape from its table: the one place that knows how shapes are built.

use crate::label_map::read_label;
use crate::mesh_io::read_mesh;
use crate::scenario::{
    BodyTable, Document, KeyPath, LabelMapTable, LabelMapValue, ScenarioError, ShapeTable,
};
use rsph_core::shape::{
    BoxShape, CylinderShape, DiscShape, MeshShape, PolygonShape, RectangleShape, Shape, SphereShape, organ,
    voxel_shape,
};
use rsph_core::tensor::Vec3;
use std::path::Path;
use std::sync::Arc;

/// A shape, and what the user should know about it (one sentence each).
pub type FoundShape = (Arc<dyn Shape>, Vec<String>);

/// The shape of the body, and what the user should know about it (one sentence each). A relative
/// path of a mesh or an image starts at `base_dir`.
///
/// # Errors
/// A size out of range, a mesh that can not be read or shows no body, or an image that can not be read
/// or does not show the body.
pub fn shape_of(doc: &Document, body: &BodyTable, base_dir: &Path) -> Result<FoundShape, ScenarioError> {
    let place = KeyPath::from("body");
    match (&body.shape, &body.labelmap) {
        (Some(shape), None) => of_table(doc, &place.key("shape"), shape, base_dir),
        (None, Some(LabelMapValue(image))) => of_image(doc, image, base_dir),
        (Some(_), Some(_)) => Err(doc.error(
            &place.key("labelmap"),
            "`shape` and `labelmap` exclude each other: each says what the body is",
            "remove one of the two",
        )),
        (None, None) => Err(doc.error(
            &place.key("shape"),
            "missing in `body`: what the body is, as `shape` or as `labelmap`",
            "for example `shape = { organ = \"liver\" }`",
        )),
    }
}

/// The body of a label in a segmented image.
fn of_image(doc: &Document, image: &LabelMapTable, base_dir: &Path) -> Result<FoundShape, ScenarioError> {
    let place = KeyPath::from("body.labelmap");
    if let Some(scale) = image.scale
        && scale <= 0.0
    {
        return Err(doc.error(
            &place.key("scale"),
            "the scale of an image must be greater than 0",
            "leave it out to go by the header of the image; 0.001 makes metres of mm",
        ));
    }
    let file = base_dir.join(&image.path);
    let labels = labels(doc, image)?;
    let mut runs = Vec::new();
    let mut whole = None;
    for (label, _) in &labels {
        let read = read_label(&file, *label).map_err(|e| {
            let problem = format!("{}: {}", e.path.display(), e.problem);
            doc.error(&place.key("path"), problem, e.remedy)
        })?;
        runs.extend_from_slice(&read.runs);
        whole = Some(read);
    }
    let Some(read) = whole else {
        return Err(doc.error(
            &place.key("labels"),
            "is empty",
            crate::scenario::remedy_at(&place.key("labels")),
        ));
    };
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let numbers: Vec<String> = labels.iter().map(|(label, _)| label.to_string()).collect();
    let word = if numbers.len() > 1 { "labels" } else { "label" };
    let name = format!("{word} {} of {name}", numbers.join(", "));
    let (shape, notes) =
        voxel_shape(&runs, read.size, &read.placement(image.scale, image.axes.axes()), &name)
            .map_err(|e| doc.invalid_input(&e))?;
    Ok((Arc::new(shape), notes))
}

/// The labels of the body with their names; a single one has none.
///
/// # Errors
/// Numbers that are none, or both ways to give them.
pub fn labels(doc: &Document, image: &LabelMapTable) -> Result<Vec<(u32, Option<String>)>, ScenarioError> {
    let place = KeyPath::from("body.labelmap");
    let Some(labels) = &image.labels else { return Ok(vec![(image.label.unwrap_or(1), None)]) };
    if image.label.is_some() {
        return Err(doc.error(
            &place.key("labels"),
            "`label` and `labels` exclude each other: each says which voxels are the body",
            "remove one of the two",
        ));
    }
    let number = |(number, name): (&String, &String)| match number.parse() {
        Ok(label) if label > 0 => Ok((label, Some(name.clone()))),
        _ => Err(doc.error(
            &place.key("labels"),
            format!("\"{number}\" is no label: a whole number, 1 or more, is"),
            crate::scenario::remedy_at(&place.key("labels")),
        )),
    };
    labels.iter().map(number).collect()
}

/// The shape that has words in a scenario.
///
/// # Errors
/// A size out of range, or a mesh that can not be read or shows no body.
pub fn of_table(
    doc: &Document,
    place: &KeyPath,
    shape: &ShapeTable,
    base_dir: &Path,
) -> Result<FoundShape, ScenarioError> {
    let refused = |e| doc.invalid_input(&e);
    let plain = |shape: Arc<dyn Shape>| Ok((shape, Vec::new()));
    match shape {
        ShapeTable::Box { size, corner } => {
            plain(Arc::new(BoxShape::new(Vec3::from(*size), Vec3::from(*corner)).map_err(refused)?))
        }
        ShapeTable::Sphere { radius, centre } => {
            plain(Arc::new(SphereShape::new(*radius, Vec3::from(*centre)).map_err(refused)?))
        }
        ShapeTable::Cylinder { radius, height, axis, centre } => plain(Arc::new(
            CylinderShape::new(axis.axis(), *radius, *height, Vec3::from(*centre)).map_err(refused)?,
        )),
        ShapeTable::Rectangle { size, corner } => {
            plain(Arc::new(RectangleShape::new(*size, *corner).map_err(refused)?))
        }
        ShapeTable::Polygon { points } => plain(Arc::new(PolygonShape::new(points).map_err(refused)?)),
        ShapeTable::Disc { radius, centre } => {
            plain(Arc::new(DiscShape::new(*radius, *centre).map_err(refused)?))
        }
        ShapeTable::Organ(name) => plain(Arc::new(organ(&name.0).map_err(refused)?)),
        ShapeTable::Mesh { path, scale, repair } => {
            let place = place.key("mesh");
            if *scale <= 0.0 {
                return Err(doc.error(
                    &place.key("scale"),
                    "the scale of a mesh must be greater than 0",
                    "1.0 if the mesh is in the units of the scenario, 0.001 from mm to m",
                ));
            }
            let file = base_dir.join(path);
            let mesh = read_mesh(&file, *scale).map_err(|e| {
                doc.error(&place.key("path"), format!("{}: {}", e.path().display(), e.problem()), e.remedy())
            })?;
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let build = if *repair { MeshShape::new } else { MeshShape::new_closed };
            let (shape, notes) = build(&mesh, &format!("mesh {name}")).map_err(refused)?;
            Ok((Arc::new(shape), notes))
        }
    }
}
