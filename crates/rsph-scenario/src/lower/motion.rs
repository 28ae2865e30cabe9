//! What moves the particles, and remeshing, in the words of the core.

use super::parts::missing;
use crate::scenario::{
    Document, DynamicsKind, EveryValue, KeyPath, RemeshKernelName, Scenario, ScenarioError, VelocityTable,
};
use rsph_core::flow::{Flow, VelocityField};
use rsph_core::kernel::RemeshKernel;
use rsph_core::material::{Material, Passive};
use rsph_core::setup::{Mechanics, Prescription, Remesh, RemeshTrigger, VectorField};
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// Colour that makes the surface, if the scenario does not say.
const DEFAULT_ISO: f64 = 0.5;

/// What moves the particles.
pub fn mechanics(doc: &Document, tables: &Scenario) -> Result<Mechanics, ScenarioError> {
    let (table, path) = (&tables.dynamics, KeyPath::from("dynamics"));
    if table.kind == DynamicsKind::Solid {
        let present = [
            ("velocity", table.velocity.is_some()),
            ("reversal", table.reversal.is_some()),
            ("band", table.band.is_some()),
            ("iso", table.iso.is_some()),
        ];
        return match present.iter().find(|p| p.1) {
            None => Ok(Mechanics::Solid),
            Some((key, _)) => Err(doc.error(
                &path.key(key),
                "belongs to a prescribed motion, and this is a solid",
                "add `kind = \"prescribed\"` to [dynamics], or remove the key",
            )),
        };
    }
    for (key, there) in [
        ("initial", tables.initial.displacement.is_some() || tables.initial.velocity.is_some()),
        ("boundary", !tables.boundary.is_empty()),
        ("load", !tables.load.is_empty()),
    ] {
        if there {
            return Err(doc.error(
                &KeyPath::from(key),
                "has no place in a prescribed motion: the particles follow the given velocity",
                "remove it, or remove [dynamics] to simulate a solid",
            ));
        }
    }
    let velocity = table.velocity.as_ref().ok_or_else(|| missing(doc, &path, "velocity", "prescribed"))?;
    Ok(Mechanics::Prescribed(Prescription {
        flow: Flow { velocity: velocity_field(velocity), reversal: table.reversal },
        band: table.band.unwrap_or(0.0),
        iso: table.iso.unwrap_or(DEFAULT_ISO),
    }))
}

fn velocity_field(table: &VelocityTable) -> VelocityField {
    VelocityField::Steady(match table {
        VelocityTable::Leveque => return VelocityField::Leveque,
        VelocityTable::Constant(c) => VectorField::Constant(Vec3::from(*c)),
        VelocityTable::Affine { constant, gradient } => VectorField::Affine {
            constant: Vec3::from(*constant),
            gradient: Mat3::from_fn(|i, j| gradient[i][j]),
        },
        VelocityTable::Rotation { rate, centre } => {
            VectorField::Rotation { rate: Vec3::from(*rate), centre: Vec3::from(*centre) }
        }
    })
}

/// What the body is made of; without a table a prescribed motion has density 1.
pub fn material(
    doc: &Document,
    tables: &Scenario,
    mechanics: &Mechanics,
) -> Result<Arc<dyn Material>, ScenarioError> {
    match (&tables.material, mechanics) {
        (Some(table), _) => table.build(doc),
        (None, Mechanics::Prescribed(_)) => Ok(Arc::new(Passive { density: 1.0 })),
        (None, Mechanics::Solid) => {
            let path = KeyPath::from("material");
            let remedy = crate::scenario::remedy_at(&path);
            Err(doc.error(&path, "missing: a solid is made of something", remedy))
        }
    }
}

/// Whether, when and how particles are laid anew.
pub fn remesh(
    doc: &Document,
    tables: &Scenario,
    mechanics: &Mechanics,
    large_strain: bool,
) -> Result<Remesh, ScenarioError> {
    let solid = matches!(mechanics, Mechanics::Solid);
    let trigger = match tables.remesh.every {
        EveryValue::Steps(0) => RemeshTrigger::Never,
        EveryValue::Steps(n) => RemeshTrigger::Steps(n),
        EveryValue::Auto => RemeshTrigger::Strain,
    };
    if solid && !large_strain && trigger != RemeshTrigger::Never {
        return Err(doc.error(
            &KeyPath::from("remesh.every"),
            "remeshing of a solid for small strain is not there yet; only 0 (never) is allowed",
            "set `every = 0` or remove the table, or take material.model = \"neo-hookean\"",
        ));
    }
    let kernel = match tables.remesh.kernel {
        Some(RemeshKernelName::M4Prime) => RemeshKernel::M4Prime,
        Some(RemeshKernelName::Lambda64) => RemeshKernel::Lambda64,
        None if solid => RemeshKernel::M4Prime,
        Some(RemeshKernelName::Lambda42) | None => RemeshKernel::Lambda42,
    };
    Ok(Remesh { trigger, kernel })
}
