//! The sink of a run's folder: what the writers need to know, from the scenario and the simulation.

use super::RunStart;
use super::writer_thread::WriterThread;
use crate::output::units;
use crate::output::{Course, Parameter, ProbeColumn, RunInfo, RunWriters};
use crate::scenario::{AxesName, LabelMapValue, LoadedScenario, MaterialTables, ModeName, ShapeTable};
use crate::sink::{RunSink, SinkError};
use rsph_core::material::Kind;
use rsph_core::region::Axis;
use rsph_core::setup::{
    Curve, Formulation, Load, LoadKind, Mechanics, Motion, RemeshTrigger, STRAIN, Scheme, Setup, Units,
};
use rsph_core::simulation::{OwnReading, own_readings};

/// Intervals of the plot of a curve.
const INTERVALS: u32 = 400;

/// Opens the files of a run's folder.
pub fn open(start: &RunStart<'_>) -> Result<Box<dyn RunSink>, SinkError> {
    let info = info(start);
    let writers = match start.checkpoint {
        None => RunWriters::create(start.folder, info)?,
        Some(checkpoint) => RunWriters::resume(
            start.folder,
            info,
            &checkpoint.state,
            start.simulation.particles().len(),
            start.conservation,
        )?,
    };
    Ok(Box::new(WriterThread::new(start.folder, Box::new(writers))?))
}

/// What writers and summaries need to know.
pub fn info(start: &RunStart<'_>) -> RunInfo {
    let setup = start.simulation.setup();
    let mut description = start.description.clone();
    description.notes = start.notes.to_vec();
    RunInfo {
        title: start.scenario.title().to_owned(),
        units: setup.units,
        scenario: start.scenario.as_run_anywhere(),
        description,
        repair: setup.shape.repair().cloned(),
        material: material(start.scenario),
        parameters: parameters(start),
        courses: courses(setup, start.scenario.tables().until()),
        probes: probes(setup),
        up: up(start.scenario, setup.units),
    }
}

/// The columns of probes.csv: the probes, and what the kind of body adds.
fn probes(setup: &Setup) -> Vec<ProbeColumn> {
    let mut columns = ProbeColumn::of(&setup.probes);
    let own = own_readings(&setup.mechanics, &setup.gauges, setup.remesh.trigger).into_iter();
    columns.extend(own.map(|OwnReading { name, quantity, unit }| ProbeColumn {
        name,
        quantity,
        unit: unit.into(),
    }));
    columns
}

fn material(scenario: &LoadedScenario) -> Vec<Parameter> {
    let mut rows = Vec::new();
    for (_, table) in scenario.tables().material.iter().flat_map(MaterialTables::iter) {
        if let Some(name) = table.text("name") {
            rows.push(Parameter::new("name", name, ""));
        }
        rows.push(Parameter::new("material", table.text("model").unwrap_or_default(), ""));
        rows.extend(table.values().into_iter().map(|(p, numbers)| match numbers[..] {
            [number] => Parameter::number(p.doc, number, p.unit),
            _ if p.kind == Kind::Pairs => {
                Parameter::new(p.doc, format!("{:?}", numbers.as_chunks::<2>().0), p.unit)
            }
            _ => Parameter::new(p.doc, format!("{numbers:?}"), p.unit),
        }));
    }
    rows
}

fn parameters(start: &RunStart<'_>) -> Vec<Parameter> {
    let setup = start.simulation.setup();
    let formulation = match setup.solver.formulation {
        Formulation::Adjoint => "adjoint",
        Formulation::Paper => "paper, Eqs. (10) to (14)",
    };
    let mut rows = vec![Parameter::new("body", setup.shape.name(), "")];
    match &setup.mechanics {
        Mechanics::Solid(_) => {
            rows.push(Parameter::new("formulation", formulation, ""));
            rows.push(Parameter::number("hourglass term, times its default", setup.solver.hourglass, "1"));
        }
        Mechanics::Prescribed(p) => {
            rows.push(Parameter::new("motion", "prescribed velocity", ""));
            rows.extend(p.flow.reversal.map(|t| Parameter::number("time of return", t, "s")));
            rows.push(Parameter::number("band of the colour in spacings", p.band, "1"));
            rows.push(Parameter::number("colour of the surface", p.iso, "1"));
        }
        Mechanics::Interaction(i) => {
            rows.push(Parameter::new("fluid", i.fluid.name(), ""));
            rows.push(Parameter::number("density of the fluid", i.fluid.density(), "kg/m^3"));
            if i.fluid.viscosity() > 0.0 {
                rows.push(Parameter::number("viscosity of the fluid", i.fluid.viscosity(), "Pa s"));
            }
            rows.extend(
                i.fluid.bulk_modulus().map(|k| Parameter::number("bulk modulus of the fluid", k, "Pa")),
            );
            rows.push(Parameter::number("density of the solid", i.solid_density, "kg/m^3"));
            rows.push(Parameter::number("elasticity of the solid", i.elasticity, "Pa"));
            rows.push(Parameter::number("interface at rest", i.interface, "m"));
        }
    }
    rows.push(Parameter::number("smoothing length in spacings", setup.solver.smoothing, "1"));
    rows.push(time(start));
    rows.extend(remeshing(setup));
    let loads = setup.solid().map_or(&[][..], |solid| &solid.loads);
    rows.extend(loads.iter().map(size));
    let foundations = setup.solid().map_or(&[][..], |solid| &solid.foundations);
    rows.extend(foundations.iter().flat_map(|foundation| {
        [
            Parameter::number("foundation, along the normal", foundation.normal, "Pa/m"),
            Parameter::number("foundation, across it", foundation.tangential, "Pa/m"),
        ]
    }));
    rows
}

/// A load where its curve is 1.
fn size(load: &Load) -> Parameter {
    match &load.kind {
        LoadKind::Traction { traction, .. } => Parameter::number("traction", traction.norm(), "Pa"),
        LoadKind::Pressure { pressure, .. } => Parameter::number("pressure", *pressure, "Pa"),
        LoadKind::FollowerPressure { pressure, .. } => {
            Parameter::number("pressure that follows the surface", *pressure, "Pa")
        }
        LoadKind::BodyForce { acceleration, .. } => {
            Parameter::number("body force per mass", acceleration.norm(), "m/s^2")
        }
        LoadKind::Patch { pressure, .. } => Parameter::number("peak pressure of the patch", *pressure, "Pa"),
    }
}

/// The curves of loads and motions up to the end of the run; loads at full strength from the start have none.
fn courses(setup: &Setup, until: f64) -> Vec<Course> {
    let Some(solid) = setup.solid() else { return Vec::new() };
    let sampled = |name: String, factor: &dyn Fn(f64) -> f64| {
        let at = |k: u32| until * f64::from(k) / f64::from(INTERVALS);
        Course { name, points: (0..=INTERVALS).map(|k| [at(k), factor(at(k))]).collect() }
    };
    let loads = solid.loads.iter().enumerate().filter(|(_, load)| load.curve != Curve::default());
    let of_loads = loads.map(|(i, load)| {
        let Parameter { name, value, unit } = size(load);
        let unit = units::bracket(setup.units, &unit);
        sampled(format!("load {}: {name} {value}{unit}", i + 1), &|t| load.curve.at(t))
    });
    let motions = solid.boundaries.iter().enumerate().filter_map(|(i, b)| Some((i, b, b.motion.as_ref()?)));
    let of_motions = motions.map(|(i, boundary, motion)| {
        let which = boundary.name.as_ref().map_or_else(|| (i + 1).to_string(), |name| name.text.clone());
        let by = match motion {
            Motion::Curve { displacement: by, .. } | Motion::Oscillation { amplitude: by, .. } => by,
        };
        let unit = units::bracket(setup.units, "m");
        let name = format!("boundary {which}: displacement {}{unit}", units::number(by.norm()));
        sampled(name, &|t| match motion {
            Motion::Curve { curve, .. } => curve.at(t),
            Motion::Oscillation { frequency, .. } => (std::f64::consts::TAU * frequency * t).sin(),
        })
    });
    of_loads.chain(of_motions).collect()
}

/// How time advances, if it does.
fn time(start: &RunStart<'_>) -> Parameter {
    if start.scenario.tables().solver.mode == ModeName::Static {
        return Parameter::new("time integrator", "none: equilibria", "");
    }
    let scheme = match start.description.scheme {
        Scheme::Auto | Scheme::Rk4 => "Runge-Kutta, fourth order",
        Scheme::Sdirk2 => "SDIRK2, implicit, second order",
        Scheme::BackwardEuler => "backward Euler, implicit, first order",
        Scheme::Rkc2 => "Runge-Kutta-Chebyshev, second order",
    };
    Parameter::new("time integrator", scheme, "")
}

/// When and how particles are remeshed.
fn remeshing(setup: &Setup) -> Vec<Parameter> {
    let when = match setup.remesh.trigger {
        RemeshTrigger::Never => return vec![Parameter::new("remeshing", "never", "")],
        RemeshTrigger::Steps(n) => format!("every {n} steps"),
        RemeshTrigger::Interval(t) => format!("every {t} of time"),
        RemeshTrigger::Strain => format!("at a strain of {STRAIN}"),
    };
    vec![
        Parameter::new("remeshing", when, ""),
        Parameter::new("remeshing kernel", setup.remesh.kernel.name(), ""),
    ]
}

/// Organs stand along y; test bodies, in normalised units, along z.
fn up(scenario: &LoadedScenario, units: Units) -> Axis {
    let body = &scenario.tables().body;
    match (&body.shape, &body.labelmap, units) {
        (Some(ShapeTable::Organ(_)), ..) | (Some(ShapeTable::Mesh { .. }), _, Units::Si) => Axis::Y,
        (_, Some(LabelMapValue(image)), _) if image.axes == AxesName::Organ => Axis::Y,
        _ => Axis::Z,
    }
}
