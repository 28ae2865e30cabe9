//! Regions, fields, boundaries and loads in the words of the core.

use super::checks::{direction, positive};
use super::probes::name;
use super::surface_part::surface_part;
use crate::scenario::{
    BoundaryKind, BoundaryTable, CentreValue, ComponentName, CurveKindName, Document, FieldTable,
    FoundationTable, KeyPath, LoadKindName, LoadTable, MotionTable, RegionTable, ScenarioError,
};
use rsph_core::region::Region;
use rsph_core::setup::{
    Between, Boundary, BoundaryName, Curve, Fix, Foundation, Load, LoadKind, Motion, PatchCentre, VectorField,
};
use rsph_core::tensor::{Mat3, Vec3};
use rsph_core::vector_field::FreeBeamMode;

/// The region written at `path`.
pub fn region(doc: &Document, path: &KeyPath, table: &RegionTable) -> Result<Region, ScenarioError> {
    let list = |word: &str, parts: &[RegionTable]| -> Result<Vec<Region>, ScenarioError> {
        let path = path.key(word);
        if parts.is_empty() {
            return Err(doc.error(&path, "needs at least one region", "list regions, or use \"all\""));
        }
        parts.iter().enumerate().map(|(i, r)| region(doc, &path.index(i), r)).collect()
    };
    Ok(match table {
        RegionTable::All => Region::All,
        RegionTable::Plane { axis, at, side } => {
            Region::Plane { axis: axis.axis(), at: *at, side: side.side() }
        }
        RegionTable::HalfSpace { point, normal } => Region::HalfSpace {
            point: Vec3::from(*point),
            normal: direction(doc, &path.key("half_space").key("normal"), *normal, "the normal")?,
        },
        RegionTable::Box { min, max } => {
            if (0..3).any(|i| min[i] > max[i]) {
                return Err(doc.error(
                    &path.key("box"),
                    "`min` must not exceed `max` on any axis",
                    "swap the two numbers of that axis",
                ));
            }
            Region::Box { min: Vec3::from(*min), max: Vec3::from(*max) }
        }
        RegionTable::Ball { centre, radius } => Region::Ball {
            centre: Vec3::from(*centre),
            radius: positive(doc, &path.key("ball").key("radius"), *radius, "the radius")?,
        },
        RegionTable::SurfacePatch { centre, radius, facing } => {
            let path = path.key("surface_patch");
            Region::SurfacePatch {
                centre: Vec3::from(*centre),
                radius: positive(doc, &path.key("radius"), *radius, "the radius")?,
                facing: direction(doc, &path.key("facing"), *facing, "the direction")?,
            }
        }
        RegionTable::Part(part) => surface_part(doc, path, &part.0)?,
        RegionTable::Point(p) => Region::Point(Vec3::from(*p)),
        RegionTable::And(parts) => Region::And(list("and", parts)?),
        RegionTable::Or(parts) => Region::Or(list("or", parts)?),
        RegionTable::Not(part) => Region::Not(Box::new(region(doc, &path.key("not"), part)?)),
    })
}

/// The initial field written at `path`; zero if there is none.
pub fn field(
    doc: &Document,
    path: &KeyPath,
    table: Option<&FieldTable>,
) -> Result<VectorField, ScenarioError> {
    Ok(match table {
        None => VectorField::default(),
        Some(FieldTable::Constant(c)) => VectorField::Constant(Vec3::from(*c)),
        Some(FieldTable::Affine { constant, gradient }) => VectorField::Affine {
            constant: Vec3::from(*constant),
            gradient: Mat3::from_fn(|i, j| gradient[i][j]),
        },
        Some(FieldTable::Rotation { rate, centre }) => {
            VectorField::Rotation { rate: Vec3::from(*rate), centre: Vec3::from(*centre) }
        }
        Some(FieldTable::Wave { constant, amplitude, wave_number, phase }) => VectorField::Wave {
            constant: Vec3::from(*constant),
            amplitude: Vec3::from(*amplitude),
            wave_number: Vec3::from(*wave_number),
            phase: *phase,
        },
        Some(FieldTable::FreeBeam { start, end, amplitude, number }) => {
            let [start, end, amplitude] = [start, end, amplitude].map(|v| Vec3::from(*v));
            let mode = FreeBeamMode::new(start, end, amplitude, *number);
            VectorField::FreeBeam(mode.map_err(|e| {
                let word = e.key.rsplit('.').next().unwrap_or_default();
                doc.error(&path.key("free_beam").key(word), e.problem, e.remedy)
            })?)
        }
    })
}

/// All `[[boundary]]` entries.
pub fn boundaries(doc: &Document, tables: &[BoundaryTable]) -> Result<Vec<Boundary>, ScenarioError> {
    let path = KeyPath::from("boundary");
    tables.iter().enumerate().map(|(i, t)| boundary(doc, &path.index(i), t)).collect()
}

fn boundary(doc: &Document, path: &KeyPath, table: &BoundaryTable) -> Result<Boundary, ScenarioError> {
    let fix = fix(doc, &path.key("fix"), table.fix.as_deref())?;
    let motion = match (table.kind, &table.motion) {
        (BoundaryKind::Clamp, None) => None,
        (BoundaryKind::Prescribed, Some(motion)) => Some(motion_of(doc, &path.key("motion"), motion)?),
        (BoundaryKind::Clamp, Some(_)) => {
            return Err(doc.error(
                &path.key("motion"),
                "a clamp does not move",
                "use kind = \"prescribed\", or remove the motion",
            ));
        }
        (BoundaryKind::Prescribed, None) => return Err(missing(doc, path, "motion", "prescribed")),
    };
    let name = match (&table.name, table.moment_about) {
        (Some(given), point) => Some(BoundaryName {
            text: name(doc, &path.key("name"), given)?,
            moment_about: point.map(Vec3::from),
        }),
        (None, Some(_)) => {
            return Err(doc.error(
                &path.key("moment_about"),
                "says about which point a moment is read, and without a name none is read",
                "give the boundary a `name`, or remove the key",
            ));
        }
        (None, None) => None,
    };
    Ok(Boundary { name, region: region(doc, &path.key("region"), &table.region)?, fix, motion })
}

fn fix(doc: &Document, path: &KeyPath, names: Option<&[ComponentName]>) -> Result<Fix, ScenarioError> {
    let Some(names) = names else { return Ok(Fix::ALL) };
    let holds = |name: ComponentName| names.contains(&name);
    if names.is_empty() {
        return Err(doc.error(
            path,
            "holds no component; allowed: \"x\", \"y\", \"z\", at least one, or \"normal\" alone",
            "list the components, or remove the key to hold all three",
        ));
    }
    if holds(ComponentName::Normal) {
        if names.iter().any(|n| *n != ComponentName::Normal) {
            return Err(doc.error(
                path,
                "holds the normal component and others; \"normal\" stands alone",
                "name the components along the axes, or write a second boundary",
            ));
        }
        return Ok(Fix::Normal);
    }
    Ok(Fix::Components([ComponentName::X, ComponentName::Y, ComponentName::Z].map(holds)))
}

fn motion_of(doc: &Document, path: &KeyPath, table: &MotionTable) -> Result<Motion, ScenarioError> {
    match table {
        MotionTable::Ramp { displacement, from, to } => {
            if to <= from {
                return Err(doc.error(
                    &path.key("ramp").key("to"),
                    format!("must be later than `from` = {from}: an instant motion has no velocity"),
                    "give the motion some time",
                ));
            }
            Ok(Motion::Curve { displacement: Vec3::from(*displacement), curve: Curve::ramp(*from, *to) })
        }
        MotionTable::Curve { displacement, time, value, kind, periodic } => {
            let curve = curve(doc, &path.key("curve"), (time, value), *kind, *periodic)?;
            Ok(Motion::Curve { displacement: Vec3::from(*displacement), curve })
        }
        MotionTable::Oscillation { amplitude, frequency } => {
            positive(doc, &path.key("oscillation").key("frequency"), *frequency, "the frequency (Hz)")?;
            Ok(Motion::Oscillation { amplitude: Vec3::from(*amplitude), frequency: *frequency })
        }
    }
}

/// Refuses motions that jump, at the start or later, of a body that moves in time.
pub fn refuse_jumps(doc: &Document, boundaries: &[Boundary]) -> Result<(), ScenarioError> {
    for (i, boundary) in boundaries.iter().enumerate() {
        let Some(Motion::Curve { curve, .. }) = &boundary.motion else { continue };
        let path = KeyPath::from("boundary").index(i).key("motion").key("curve");
        if curve.jumps() {
            return Err(doc.error(
                &path.key("kind"),
                "this motion jumps, and an instant motion has no velocity",
                "take \"linear\" or \"smooth\" and give it some time, or `solver.mode = \"static\"`",
            ));
        }
        if curve.at(0.0) != 0.0 {
            return Err(doc.error(
                &path.key("value"),
                format!(
                    "at time 0 this motion has gone {} of its way, and the body starts undeformed",
                    curve.at(0.0)
                ),
                "start with the value 0 at time 0, or take `solver.mode = \"static\"`",
            ));
        }
    }
    Ok(())
}

/// All `[[foundation]]` entries.
pub fn foundations(doc: &Document, tables: &[FoundationTable]) -> Result<Vec<Foundation>, ScenarioError> {
    let path = KeyPath::from("foundation");
    let of = |(i, table): (usize, &FoundationTable)| {
        let region = region(doc, &path.index(i).key("region"), &table.region)?;
        Ok(Foundation { region, normal: table.normal, tangential: table.tangential })
    };
    tables.iter().enumerate().map(of).collect()
}

/// All `[[load]]` entries.
pub fn loads(doc: &Document, tables: &[LoadTable]) -> Result<Vec<Load>, ScenarioError> {
    let path = KeyPath::from("load");
    tables.iter().enumerate().map(|(i, t)| load(doc, &path.index(i), t)).collect()
}

fn load(doc: &Document, path: &KeyPath, table: &LoadTable) -> Result<Load, ScenarioError> {
    check_keys(doc, path, table)?;
    let region_there = |t: &RegionTable| region(doc, &path.key("region"), t);
    let need = |key: &str| missing(doc, path, key, kind_name(table.kind));
    let surface = || region_there(table.region.as_ref().ok_or_else(|| need("region"))?);
    let kind = match table.kind {
        LoadKindName::Traction => LoadKind::Traction {
            region: surface()?,
            traction: Vec3::from(table.traction.ok_or_else(|| need("traction"))?),
        },
        LoadKindName::Pressure => LoadKind::Pressure {
            region: surface()?,
            pressure: table.pressure.ok_or_else(|| need("pressure"))?,
        },
        LoadKindName::FollowerPressure => LoadKind::FollowerPressure {
            region: surface()?,
            pressure: table.pressure.ok_or_else(|| need("pressure"))?,
        },
        LoadKindName::BodyForce => LoadKind::BodyForce {
            region: table.region.as_ref().map_or(Ok(Region::All), region_there)?,
            acceleration: Vec3::from(table.acceleration.ok_or_else(|| need("acceleration"))?),
        },
        LoadKindName::Patch => LoadKind::Patch {
            pressure: table.pressure.ok_or_else(|| need("pressure"))?,
            centre: match table.centre.ok_or_else(|| need("centre"))? {
                CentreValue::At(p) => PatchCentre::At(Vec3::from(p)),
                CentreValue::UpperRight => PatchCentre::UpperRight,
            },
            radius: match table.radius {
                Some(r) => Some(positive(doc, &path.key("radius"), r, "the radius")?),
                None => None,
            },
            direction: direction(
                doc,
                &path.key("direction"),
                table.direction.ok_or_else(|| need("direction"))?,
                "the direction of the push",
            )?
            .normalize(),
        },
    };
    Ok(Load { kind, curve: course(doc, path, table)? })
}

/// Refuses keys that belong to another kind of load.
fn check_keys(doc: &Document, path: &KeyPath, t: &LoadTable) -> Result<(), ScenarioError> {
    let allowed: &[&str] = match t.kind {
        LoadKindName::Traction => &["region", "traction"],
        LoadKindName::Pressure | LoadKindName::FollowerPressure => &["region", "pressure"],
        LoadKindName::BodyForce => &["region", "acceleration"],
        LoadKindName::Patch => &["pressure", "centre", "radius", "direction"],
    };
    let present = [
        ("region", t.region.is_some()),
        ("traction", t.traction.is_some()),
        ("pressure", t.pressure.is_some()),
        ("acceleration", t.acceleration.is_some()),
        ("centre", t.centre.is_some()),
        ("radius", t.radius.is_some()),
        ("direction", t.direction.is_some()),
    ];
    match present.iter().find(|(key, there)| *there && !allowed.contains(key)) {
        None => Ok(()),
        Some((key, _)) => Err(doc.error(
            &path.key(key),
            format!("does not belong to a load of kind \"{}\"", kind_name(t.kind)),
            format!(
                "such a load takes `{}` and `ramp` or `curve`: remove the key or change the kind",
                allowed.join("`, `")
            ),
        )),
    }
}

fn kind_name(kind: LoadKindName) -> &'static str {
    match kind {
        LoadKindName::Traction => "traction",
        LoadKindName::Pressure => "pressure",
        LoadKindName::FollowerPressure => "follower_pressure",
        LoadKindName::BodyForce => "body_force",
        LoadKindName::Patch => "patch",
    }
}

/// The course of a load in time.
fn course(doc: &Document, path: &KeyPath, table: &LoadTable) -> Result<Curve, ScenarioError> {
    match (&table.ramp, &table.curve) {
        (None, None) => Ok(Curve::default()),
        (Some(ramp), None) if ramp.to < ramp.from => Err(doc.error(
            &path.key("ramp").key("to"),
            format!("must not be earlier than `from` = {}", ramp.from),
            "equal times switch the load on at once",
        )),
        (Some(ramp), None) => Ok(Curve::ramp(ramp.from, ramp.to)),
        (None, Some(table)) => {
            curve(doc, &path.key("curve"), (&table.time, &table.value), table.kind, table.periodic)
        }
        (Some(_), Some(_)) => Err(doc.error(
            &path.key("curve"),
            "`ramp` and `curve` exclude each other: each says how the load changes in time",
            "remove one of the two",
        )),
    }
}

/// The curve through the points written at `path`.
fn curve(
    doc: &Document,
    path: &KeyPath,
    (time, value): (&[f64], &[f64]),
    kind: CurveKindName,
    periodic: bool,
) -> Result<Curve, ScenarioError> {
    let between = match kind {
        CurveKindName::Linear => Between::Linear,
        CurveKindName::Step => Between::Step,
        CurveKindName::Smooth => Between::Smooth,
    };
    Curve::new(time, value, between, periodic).map_err(|e| doc.error(&path.key(&e.key), e.problem, e.remedy))
}

/// `key` is missing, which `kind` needs.
pub fn missing(doc: &Document, path: &KeyPath, key: &str, kind: &str) -> ScenarioError {
    let path = path.key(key);
    let remedy = crate::scenario::remedy_at(&path);
    doc.error(&path, format!("missing: kind \"{kind}\" needs it"), remedy)
}
