//! What moves the particles, and remeshing, in the words of the core.

use super::checks::positive;
use super::materials::materials;
use super::parts::{self, missing};
use crate::scenario::{
    Document, DynamicsKind, EveryValue, FluidTable, KeyPath, ModeName, RemeshKernelName, Scenario,
    ScenarioError, VelocityTable,
};
use rsph_core::flow::{Flow, VelocityField};
use rsph_core::fluid::{Acoustic, Burgers, FluidLaw};
use rsph_core::kernel::RemeshKernel;
use rsph_core::setup::{
    Curve, InteractionSetting, Mechanics, Prescription, Remesh, RemeshTrigger, SolidSetup, VectorField,
};
use rsph_core::tensor::{Mat3, Vec3};
use std::path::Path;
use std::sync::Arc;

/// Colour that makes the surface, if the scenario does not say.
const DEFAULT_ISO: f64 = 0.5;

/// What moves the particles; files are read from `folder`, or not read.
///
/// # Errors
/// What can not be simulated.
pub fn mechanics(
    doc: &Document,
    tables: &Scenario,
    folder: Option<&Path>,
) -> Result<Mechanics, ScenarioError> {
    refuse_keys_of_other_kinds(doc, tables)?;
    match tables.dynamics.kind {
        DynamicsKind::Solid => solid(doc, tables, folder).map(Mechanics::Solid),
        DynamicsKind::Prescribed => prescription(doc, tables).map(Mechanics::Prescribed),
        DynamicsKind::Interaction => interaction(doc, tables).map(Mechanics::Interaction),
    }
}

/// Keys of `[dynamics]` that belong to another kind than the one given.
fn refuse_keys_of_other_kinds(doc: &Document, tables: &Scenario) -> Result<(), ScenarioError> {
    let table = &tables.dynamics;
    let (prescribed, interaction) = (DynamicsKind::Prescribed, DynamicsKind::Interaction);
    let keys = [
        ("velocity", table.velocity.is_some(), prescribed),
        ("reversal", table.reversal.is_some(), prescribed),
        ("band", table.band.is_some(), prescribed),
        ("iso", table.iso.is_some(), prescribed),
        ("fluid", table.fluid.is_some(), interaction),
        ("solid", table.solid.is_some(), interaction),
        ("interface", table.interface.is_some(), interaction),
    ];
    let name = |kind| match kind {
        DynamicsKind::Solid => ("solid", "a solid"),
        DynamicsKind::Prescribed => ("prescribed", "a prescribed motion"),
        DynamicsKind::Interaction => ("fsi_1d", "a fluid beside a solid"),
    };
    match keys.iter().find(|(_, there, kind)| *there && *kind != table.kind) {
        None => Ok(()),
        Some((key, _, kind)) => Err(doc.error(
            &KeyPath::from("dynamics").key(key),
            format!("belongs to {}, and this is {}", name(*kind).1, name(table.kind).1),
            format!("write `kind = \"{}\"` in [dynamics], or remove the key", name(*kind).0),
        )),
    }
}

/// A solid.
fn solid(doc: &Document, tables: &Scenario, folder: Option<&Path>) -> Result<SolidSetup, ScenarioError> {
    let Some(table) = &tables.material else {
        let path = KeyPath::from("material");
        let remedy = crate::scenario::remedy_at(&path);
        return Err(doc.error(&path, "missing: a solid is made of something", remedy));
    };
    let mut solid = materials(doc, table, tables.body.labelmap.as_ref(), folder)?;
    let boundaries = parts::boundaries(doc, &tables.boundary)?;
    if tables.solver.mode == ModeName::Dynamic && tables.initial.displacement.is_none() {
        parts::refuse_jumps(doc, &boundaries)?;
    }
    let mut loads = parts::loads(doc, &tables.load)?;
    if tables.solver.mode == ModeName::Static && tables.solver.steps > 1 {
        for load in loads.iter_mut().filter(|l| l.curve == Curve::default()) {
            load.curve = Curve::ramp(0.0, tables.until());
        }
    }
    (solid.boundaries, solid.loads) = (boundaries, loads);
    solid.foundations = parts::foundations(doc, &tables.foundation)?;
    Ok(solid)
}

/// A body that moves as told.
fn prescription(doc: &Document, tables: &Scenario) -> Result<Prescription, ScenarioError> {
    let (table, path) = (&tables.dynamics, KeyPath::from("dynamics"));
    for (key, there) in [
        ("initial", tables.initial.displacement.is_some() || tables.initial.velocity.is_some()),
        ("boundary", !tables.boundary.is_empty()),
        ("load", !tables.load.is_empty()),
        ("foundation", !tables.foundation.is_empty()),
    ] {
        if there {
            return Err(doc.error(
                &KeyPath::from(key),
                "has no place in a prescribed motion: the particles follow the given velocity",
                "remove it, or remove [dynamics] to simulate a solid",
            ));
        }
    }
    let density = match &tables.material {
        Some(materials) => match materials.iter().next() {
            Some((path, table)) => table.build(doc, &path)?.density(),
            None => 1.0,
        },
        None => 1.0,
    };
    let velocity = table.velocity.as_ref().ok_or_else(|| missing(doc, &path, "velocity", "prescribed"))?;
    Ok(Prescription {
        density,
        flow: Flow { velocity: velocity_field(velocity), reversal: table.reversal },
        band: table.band.unwrap_or(0.0),
        iso: table.iso.unwrap_or(DEFAULT_ISO),
    })
}

/// A fluid beside a solid.
fn interaction(doc: &Document, tables: &Scenario) -> Result<InteractionSetting, ScenarioError> {
    let (table, path) = (&tables.dynamics, KeyPath::from("dynamics"));
    for (key, there) in [
        ("material", tables.material.is_some()),
        ("initial.displacement", tables.initial.displacement.is_some()),
    ] {
        if there {
            return Err(doc.error(
                &KeyPath::from(key),
                "has no place beside `dynamics.kind = \"fsi_1d\"`: the materials are `dynamics.fluid` and \
                 `dynamics.solid`, and both start undeformed",
                "remove it",
            ));
        }
    }
    let (held, rests) = (!tables.boundary.is_empty(), !tables.foundation.is_empty());
    for (key, there) in [("boundary", held), ("foundation", rests), ("load", !tables.load.is_empty())] {
        if there {
            return Err(doc.error(
                &KeyPath::from(key),
                "has no place beside `dynamics.kind = \"fsi_1d\"`: there is a wall at its left and a held end at its right, \
                 Eq. (21), and no load",
                "remove it",
            ));
        }
    }
    let missing = |key| missing(doc, &path, key, "fsi_1d");
    let refused = |e| doc.invalid_input(&e);
    let fluid: Arc<dyn FluidLaw> = match table.fluid.ok_or_else(|| missing("fluid"))? {
        FluidTable::Burgers { viscosity } => Arc::new(Burgers::new(viscosity).map_err(refused)?),
        FluidTable::Acoustic { density, sound_speed } => {
            Arc::new(Acoustic::new(density, sound_speed).map_err(refused)?)
        }
    };
    let solid = table.solid.ok_or_else(|| missing("solid"))?;
    Ok(InteractionSetting {
        fluid,
        elasticity: solid.elasticity,
        solid_density: solid.density,
        interface: table.interface.ok_or_else(|| missing("interface"))?,
    })
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

/// Whether, when and how particles are remeshed.
pub fn remesh(doc: &Document, tables: &Scenario, mechanics: &Mechanics) -> Result<Remesh, ScenarioError> {
    let solid = matches!(mechanics, Mechanics::Solid(_));
    let trigger = match (tables.remesh.every, tables.remesh.interval) {
        (EveryValue::Steps(0), Some(t)) => {
            positive(doc, &KeyPath::from("remesh.interval"), t, "the time between remeshings")?;
            RemeshTrigger::Interval(t)
        }
        (_, Some(_)) => {
            return Err(doc.error(
                &KeyPath::from("remesh.interval"),
                "`interval` and `every` exclude each other: each says when particles are remeshed",
                "remove one of the two",
            ));
        }
        (EveryValue::Steps(0), None) => RemeshTrigger::Never,
        (EveryValue::Steps(n), None) => RemeshTrigger::Steps(n),
        (EveryValue::Auto, None) => RemeshTrigger::Strain,
    };
    let kernel = match tables.remesh.kernel {
        Some(RemeshKernelName::M4Prime) => RemeshKernel::M4Prime,
        Some(RemeshKernelName::Lambda64) => RemeshKernel::Lambda64,
        None if solid => RemeshKernel::M4Prime,
        Some(RemeshKernelName::Lambda42) | None => RemeshKernel::Lambda42,
    };
    let restore_level_set = tables.remesh.restore_level_set.unwrap_or(false);
    if restore_level_set && !solid {
        let problem = "belongs to a solid: the surface of a prescribed motion is that of the colour, Eq. (8)";
        return Err(doc.error(&KeyPath::from("remesh.restore_level_set"), problem, "remove it"));
    }
    Ok(Remesh { trigger, kernel, restore_level_set })
}
