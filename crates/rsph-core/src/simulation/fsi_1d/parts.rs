//! From a set-up to a fluid beside a solid: checks, elements, time step.

use super::{Bar, FluidBesideSolid};
use crate::dynamics::fsi_1d::{FluidStructure, SMALLEST_SMOOTHING};
use crate::error::InvalidInput;
use crate::particles::Field;
use crate::sample::Resolution;
use crate::setup::{Interaction, InteractionSetting, Scheme, Setup, TimeStep};
use crate::simulation::Description;
use crate::simulation::model::Parts;
use crate::simulation::time_step::{choose_step, only_rk4};
use crate::stability::StepLimit;
use crate::tensor::Vec3;

/// Fewest elements of each material: what the remeshing kernels reach, and more.
const FEWEST: usize = 8;
/// Fields that all particles have.
const FIELDS: [Field; 8] = [
    Field::Reference,
    Field::Displacement,
    Field::Velocity,
    Field::Mass,
    Field::Volume,
    Field::Strain,
    Field::Stress,
    Field::Colour,
];
/// Most elements of both.
const MOST: usize = 1_000_000;
/// Courant number of the solid in a step that the program chooses; the limit is 1.41.
const COURANT: f64 = 0.8;
/// Shortest distance between fluid particles, in spacings at rest, that a step must be stable for:
/// between two remeshings, and because the interface moves.
const COMPRESSED: f64 = 0.8;

impl FluidBesideSolid {
    /// Particles along the x axis of the body's box, between a wall at its left and a held end at its right, Eq. (21), and the time
    /// step.
    ///
    /// # Errors
    /// The first input that can not be simulated.
    pub fn parts(setup: &Setup, setting: &InteractionSetting) -> Result<Parts, InvalidInput> {
        check(setup, setting)?;
        only_rk4(setup, "a fluid beside a solid")?;
        let bounds = setup.shape.bounds();
        let elements = elements(setup, setting, bounds.min.x, bounds.max.x)?;
        let interaction = Interaction {
            fluid: setting.fluid.clone(),
            elasticity: setting.elasticity,
            solid_density: setting.solid_density,
            left: bounds.min.x,
            interface: setting.interface,
            right: bounds.max.x,
            elements,
        };
        let [h, dxi] = interaction.spacings();
        let dynamics = FluidStructure::new(&interaction, setup.solver.smoothing);
        let particles = dynamics.particles(&interaction, |x| setup.initial.velocity.at_all(x));
        let wave_speed = (setting.elasticity / setting.solid_density).sqrt();
        let [wave, viscous] = dynamics.step_limits(COMPRESSED * h);
        let kappa = 4.0 * (wave_speed / dxi).powi(2);
        let limit =
            StepLimit { kappa, fastest_decay: 0.0, dt: wave.min(viscous), wave, viscous: viscous < wave };
        let (mut dt, notes) = choose_step(setup, &limit, None)?;
        if setup.time_step == TimeStep::Auto {
            dt = dt.min(COURANT * dxi / wave_speed);
        }
        let length = bounds.max.x - bounds.min.x;
        let description = Description {
            particles: particles.len(),
            spacing: h.max(dxi),
            smoothing_length: setup.solver.smoothing * h,
            neighbours: 2 * (2.5 * setup.solver.smoothing).floor() as usize,
            scheme: Scheme::Rk4,
            scheme_reason: None,
            dt,
            shortest_step: None,
            fastest_decay: 0.0,
            dt_limit: limit.dt,
            limited_by_viscosity: limit.viscous,
            volume: length,
            shape_volume: length,
            load: Vec3::zeros(),
            notes,
        };
        let model = Box::new(Self {
            dynamics,
            kernel: setup.remesh.kernel,
            probes: setup.probes.clone(),
            bar: Bar::new(bounds),
            strain: 0.0,
        });
        Ok(Parts { model, particles, description })
    }
}

/// Elements of the fluid and of the solid, of about the same length.
fn elements(
    setup: &Setup,
    setting: &InteractionSetting,
    left: f64,
    right: f64,
) -> Result<[usize; 2], InvalidInput> {
    let (key, spacing) = match setup.resolution {
        Resolution::Spacing(dx) => ("body.spacing", dx),
        Resolution::Particles(n) => ("body.particles", (right - left) / n.saturating_sub(1).max(1) as f64),
    };
    let count = |length: f64| (length / spacing).round();
    let [n, m] = [setting.interface - left, right - setting.interface].map(count);
    let fewest = FEWEST as f64;
    if n >= fewest && m >= fewest && n + m <= MOST as f64 {
        return Ok([n as usize, m as usize]);
    }
    Err(InvalidInput::new(
        key,
        spacing,
        format!(
            "gives {n:.0} elements of fluid and {m:.0} of solid; each needs at least {FEWEST}, and both have \
             at most {MOST}"
        ),
        "0.01 on a line of length 1 is the paper's choice",
    ))
}

/// Values out of range, and what particles on a line have no use for.
fn check(setup: &Setup, setting: &InteractionSetting) -> Result<(), InvalidInput> {
    if !setup.shape.is_box() {
        return Err(InvalidInput::new(
            "body.shape",
            setup.shape.name(),
            "fluid and solid lie along the x axis of a box",
            "for example `shape = { box = { size = [1.0, 0.1, 0.1], corner = [-0.5, 0.0, 0.0] } }`",
        ));
    }
    for (key, value) in [("elasticity", setting.elasticity), ("density", setting.solid_density)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(InvalidInput::new(
                format!("dynamics.solid.{key}"),
                value,
                "must be a positive number",
                "the paper has 1",
            ));
        }
    }
    let bounds = setup.shape.bounds();
    if !(setting.interface > bounds.min.x && setting.interface < bounds.max.x) {
        return Err(InvalidInput::new(
            "dynamics.interface",
            setting.interface,
            format!("must lie between the ends of the box, {} and {}", bounds.min.x, bounds.max.x),
            "fluid is left of it, solid right of it",
        ));
    }
    if setup.solver.smoothing < SMALLEST_SMOOTHING {
        return Err(InvalidInput::new(
            "solver.smoothing",
            setup.solver.smoothing,
            format!(
                "must be at least {SMALLEST_SMOOTHING} beside a solid, so that sums reach both neighbours"
            ),
            "0.85 is most accurate, the paper uses 1.25",
        ));
    }
    let pressure = setting.fluid.bulk_modulus().is_some();
    let carried = |f: Field| FIELDS.contains(&f) || (pressure && f == Field::Pressure);
    if let Some(i) = setup.probes.iter().position(|p| !carried(p.quantity.field)) {
        return Err(InvalidInput::new(
            format!("probe[{i}].quantity"),
            setup.probes[i].quantity.field.spec().name,
            "the particles of a fluid beside a solid do not have this field",
            format!("choose one of {}", FIELDS.map(|f| f.spec().name).join(", ")),
        ));
    }
    Ok(())
}
