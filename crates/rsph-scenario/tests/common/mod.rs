//! A made-up run: a ball that is sheared and stretched, with a made-up strain, in place of a
//! simulation.
#![allow(dead_code, reason = "each test program uses another part of it")]

use rsph_core::error::{Failure, FailureKind};
use rsph_core::mesh::TriangleMesh;
use rsph_core::particles::{Column, Field, Particles};
use rsph_core::region::Axis;
use rsph_core::setup::Units;
use rsph_core::simulation::{Conservation, Description, Reading};
use rsph_core::snapshot::Snapshot;
use rsph_core::surface::{Surface, SurfaceField};
use rsph_core::tensor::{Mat3, SymTensor, Vec3};
use rsph_scenario::output::{Course, Parameter, ProbeColumn, RunInfo};
use rsph_scenario::sink::{Outcome, Status};

/// Displacement gradient of the made-up motion, which bends a little more towards the top.
fn gradient(t: f64, x: &Vec3) -> Mat3 {
    let a = 0.01 * (1.0 - (-t).exp());
    Mat3::new(-0.3, 0.0, 0.8 + 2.0 * x.z, 0.0, -0.3, 0.0, 0.0, 0.0, 1.0) * a
}

fn displacement(t: f64, x: &Vec3) -> Vec3 {
    gradient(t, x) * x
}

/// The lattice points of a ball of radius 1 with `cells` cells along the diameter, at time `t`.
pub fn snapshot(t: f64, step: u64, cells: usize) -> Snapshot {
    let spacing = 2.0 / cells as f64;
    let at = |i: usize| -1.0 + (i as f64 + 0.5) * spacing;
    let mut x = Vec::new();
    for k in 0..cells {
        for j in 0..cells {
            x.extend((0..cells).map(|i| Vec3::new(at(i), at(j), at(k))).filter(|x| x.norm() < 1.0));
        }
    }
    let n = x.len();
    let u: Vec<_> = x.iter().map(|x| displacement(t, x)).collect();
    let v: Vec<_> = u.iter().map(|u| u * (-t).exp()).collect();
    let strain: Vec<_> = x.iter().map(|x| SymTensor::symmetric_part(&gradient(t, x))).collect();
    let stress: Vec<_> = strain.iter().map(|e| *e * 100.0).collect();
    let tensors = |s: &[SymTensor]| {
        Column::from_vec((0..6).flat_map(|c| s.iter().map(move |s| s.0[c])).collect(), s.len())
    };
    let mut p = Particles::new(n);
    p.set(Field::Reference, Column::from_vectors(&x));
    p.set(Field::Displacement, Column::from_vectors(&u));
    p.set(Field::Velocity, Column::from_vectors(&v));
    p.set(Field::Mass, Column::from_vec(vec![spacing.powi(3); n], n));
    p.set(Field::Volume, Column::from_vec(vec![spacing.powi(3); n], n));
    p.set(Field::Density, Column::from_vec(strain.iter().map(|e| 1.0 - e.trace()).collect(), n));
    p.set(Field::Strain, tensors(&strain));
    p.set(Field::Stress, tensors(&stress));
    p.set(Field::LevelSet, Column::from_vec(x.iter().map(|x| x.norm() - 1.0).collect(), n));
    p.set(Field::VonMises, Column::from_vec(stress.iter().map(|s| s.von_mises()).collect(), n));
    Snapshot { time: t, step, particles: p }
}

/// The ball's surface at time `t`, with `rings` rings of vertices between its poles.
pub fn surface(t: f64, rings: usize) -> Surface {
    let around = 2 * rings;
    let mut x = vec![Vec3::new(0.0, 0.0, 1.0)];
    for i in 1..=rings {
        let polar = std::f64::consts::PI * i as f64 / (rings + 1) as f64;
        for j in 0..around {
            let azimuth = std::f64::consts::TAU * j as f64 / around as f64;
            x.push(Vec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()));
        }
    }
    x.push(Vec3::new(0.0, 0.0, -1.0));
    let at = |ring: usize, j: usize| (1 + (ring - 1) * around + j % around) as u32;
    let south = x.len() as u32 - 1;
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([0, at(1, j), at(1, j + 1)]);
        for i in 1..rings {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        triangles.push([at(rings, j), south, at(rings, j + 1)]);
    }

    let strain: Vec<_> = x.iter().map(|x| SymTensor::symmetric_part(&gradient(t, x))).collect();
    let normal = |i: usize| strain[i].dot(&x[i]).dot(&x[i]);
    let shear = |i: usize| (strain[i].dot(&x[i]) - x[i] * normal(i)).norm();
    let field = |name, components, values| SurfaceField { name, components, values };
    let n = x.len();
    let fields = vec![
        field(
            "displacement",
            3,
            x.iter().flat_map(|x| displacement(t, x).iter().copied().collect::<Vec<_>>()).collect(),
        ),
        field("strain", 6, strain.iter().flat_map(|e| e.0).collect()),
        field("von_mises", 1, strain.iter().map(|e| 100.0 * e.von_mises()).collect()),
        field("normal_strain", 1, (0..n).map(normal).collect()),
        field("shear_strain", 1, (0..n).map(shear).collect()),
    ];
    let vertices = x.iter().map(|x| x + displacement(t, x)).collect();
    Surface { mesh: TriangleMesh { vertices, triangles }, fields }
}

/// The conserved sums of the made-up run at time `t`.
pub fn conservation(t: f64) -> Conservation {
    let s = 1.0 - (-t).exp();
    Conservation {
        mass: 4.19,
        momentum: Vec3::new(0.0, 0.0, 1e-3 * (-t).exp()),
        kinetic_energy: 2e-3 * s * (-t).exp(),
        elastic_energy: 4e-3 * s * s,
        external_work: 1e-2 * s,
        dissipated: 5e-3 * s * s,
        load: Vec3::new(0.0, 0.0, 1.0),
        reaction: Vec3::new(0.0, 0.0, -s),
        momentum_error: 1e-14 * (1.0 + t),
        mass_error: 0.0,
        energy_error: None,
    }
}

/// Readings of a scalar and a vector probe.
pub fn readings(t: f64) -> Vec<Reading> {
    let u = displacement(t, &Vec3::new(0.0, 0.0, 1.0));
    let reading = |name: &str, value| Reading { name: name.to_owned(), value };
    vec![reading("extension", u.z), reading("tip_x", u.x), reading("tip_y", u.y), reading("tip_z", u.z)]
}

/// What is known of the made-up run before its start.
pub fn description() -> Description {
    Description {
        particles: snapshot(0.0, 0, 10).len(),
        spacing: 0.2,
        smoothing_length: 0.25,
        neighbours: 56,
        scheme: rsph_core::setup::Scheme::Rk4,
        scheme_reason: None,
        shortest_step: None,
        fastest_decay: 0.0,
        dt: 0.01,
        dt_limit: 0.0111,
        limited_by_viscosity: true,
        volume: 4.16,
        shape_volume: 4.19,
        load: Vec3::new(0.0, 0.0, 1.0),
        notes: vec!["The made-up run is not a simulation.".to_owned()],
    }
}

/// What the writers know of the made-up run.
pub fn info() -> RunInfo {
    RunInfo {
        title: "Made-up ball <sheared & stretched>".to_owned(),
        units: Units::Si,
        scenario: "title = \"Made-up ball <sheared & stretched>\"\n# </script> {{data}}\n".to_owned(),
        description: description(),
        repair: None,
        material: vec![
            Parameter::new("model", "kelvin-voigt", ""),
            Parameter::number("density", 1060.0, "kg/m^3"),
            Parameter::number("Young's modulus", 4000.0, "Pa"),
            Parameter::number("Poisson's ratio", 0.45, "1"),
            Parameter::number("relaxation time", 0.2, "s"),
        ],
        parameters: vec![Parameter::new("shape", "ball of radius 1", "m")],
        courses: vec![Course {
            name: "load 1: pressure <2 kPa>".to_owned(),
            points: vec![[0.0, 0.0], [0.5, 1.0], [1.0, 0.25]],
        }],
        probes: [
            ("extension", "displacement.z"),
            ("tip_x", "displacement.x"),
            ("tip_y", "displacement.y"),
            ("tip_z", "displacement.z"),
        ]
        .map(|(name, quantity)| ProbeColumn {
            name: name.into(),
            quantity: quantity.into(),
            unit: "m".into(),
        })
        .to_vec(),
        up: Axis::Z,
    }
}

/// A failure of the made-up run.
pub fn failure() -> Failure {
    Failure {
        kind: FailureKind::Unstable,
        time: 3.0,
        step: 301,
        what: "strain 12.5 is larger than 10".to_owned(),
        place: Some(Vec3::new(0.1, 0.2, 0.9)),
        remedy: "choose time.dt = \"auto\" or a time step below 0.0111".to_owned(),
    }
}

/// An outcome of the made-up run.
pub fn outcome(status: Status) -> Outcome {
    Outcome {
        status,
        wall_seconds: 2.0,
        steps: 300,
        rhs_evaluations: 1200,
        time: 3.0,
        threads: 2,
        remesh: None,
        equilibrium: None,
        largest: None,
        notes: Vec::new(),
    }
}

/// A NIfTI-1 image of bytes with cubic voxels of `edge` mm, the first around `origin` (mm).
pub fn nifti(size: [i16; 3], edge: f32, origin: [f32; 3], voxels: &[u8]) -> Vec<u8> {
    let mut raw = vec![0; 352];
    let mut put = |at: usize, bytes: &[u8]| raw[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (i, n) in [3, size[0], size[1], size[2], 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    put(70, &2_i16.to_le_bytes());
    put(108, &352.0_f32.to_le_bytes());
    put(123, &[2]);
    put(254, &1_i16.to_le_bytes());
    for i in 0..3 {
        put(280 + 20 * i, &edge.to_le_bytes());
        put(292 + 16 * i, &origin[i].to_le_bytes());
    }
    put(344, b"n+1\0");
    raw.extend_from_slice(voxels);
    raw
}
