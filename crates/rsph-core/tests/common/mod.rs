//! Bodies for the tests of the operator.
#![allow(dead_code, clippy::needless_pass_by_value)]

use rsph_core::boundary::constraints::Constraints;
use rsph_core::boundary::fold::Folds;
use rsph_core::boundary::surface_quadrature::{LoadedParticles, SurfaceQuadrature, rim};
use rsph_core::dynamics::solid::Solid;
use rsph_core::lattice::Lattice;
use rsph_core::material::{Composition, KelvinVoigt, Material, Model, REGISTRY};
use rsph_core::mls::Cloud;
use rsph_core::particles::Column;
use rsph_core::region::{Axis, Region, Side};
use rsph_core::sample::{Resolution, sample};
use rsph_core::setup::{Boundary, Fix, Solver};
use rsph_core::shape::{BoxShape, Shape, SphereShape};
use rsph_core::tensor::{Mat3, Vec3};
use std::sync::Arc;

/// A reproducible stream of numbers in [-0.5, 0.5).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }

    pub fn column(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// Every law of the registry with that Young's modulus, nu = 0.3, T = 0.2 where it has such parameters, else 1 or its defaults.
pub fn every_law(young_modulus: f64) -> Vec<Arc<dyn Material>> {
    let mu = young_modulus / 2.6;
    let value = |model: &str, key: &str| {
        Some(match (model, key) {
            (_, "young_modulus") => vec![young_modulus],
            (_, "poisson_ratio") => vec![0.3],
            (_, "relaxation_time") => vec![T],
            ("mooney-rivlin", "c10") => vec![0.3 * mu],
            ("mooney-rivlin", "c01") | ("holzapfel-gasser-ogden", "k1") => vec![0.2 * mu],
            ("yeoh" | "veronda-westmann", "c1") => vec![0.5 * mu],
            ("yeoh", "c2" | "c3") => vec![0.1 * mu],
            ("ogden", "moduli") => vec![0.7 * mu, 0.3 * mu],
            ("ogden", "exponents") => vec![3.0, -2.5],
            ("veronda-westmann", "c2") => vec![2.0],
            ("fung" | "holzapfel-gasser-ogden", "shear_modulus") => vec![mu],
            ("fung", "exponent") => vec![1.5],
            (_, "density") | ("holzapfel-gasser-ogden", "k2") => vec![1.0],
            ("holzapfel-gasser-ogden", "dispersion") => vec![0.1],
            ("holzapfel-gasser-ogden", "fibre") => FIBRE.to_vec(),
            _ => return None,
        })
    };
    let build = |model: &Model| model.make(|key| value(model.name, key)).unwrap();
    REGISTRY.iter().map(build).collect()
}

/// Direction of the fibres of the law that has some.
pub const FIBRE: [f64; 3] = [0.6, 0.8, 0.0];

/// Relaxation time of the test bodies.
pub const T: f64 = 0.2;

/// A solid with its positions.
pub struct TestBody {
    pub solid: Solid,
    pub positions: Vec<Vec3>,
    pub spacing: f64,
    /// The surface with the weights of the particles.
    pub surface: SurfaceQuadrature,
}

/// The body that samples `shape`, held by `boundaries`, with E = 100, nu = `nu`, and the default hourglass term times
/// `hourglass`.
pub fn body(
    shape: Arc<dyn Shape>,
    resolution: Resolution,
    smoothing: f64,
    hourglass: f64,
    nu: f64,
    boundaries: &[Boundary],
) -> TestBody {
    body_of(None, shape, resolution, smoothing, hourglass, nu, boundaries)
}

/// [`body`] of another material with Young's modulus E = 100.
pub fn body_of(
    material: Option<Arc<dyn Material>>,
    shape: Arc<dyn Shape>,
    resolution: Resolution,
    smoothing: f64,
    hourglass: f64,
    nu: f64,
    boundaries: &[Boundary],
) -> TestBody {
    let material = material.unwrap_or_else(|| Arc::new(KelvinVoigt::new(1.0, 100.0, nu, T).unwrap()));
    remeshed_body(material, shape, resolution, (smoothing, hourglass), boundaries, None)
}

/// What a body is made of: one material, or several with a function of place and spacing.
pub struct Made {
    pub materials: Vec<Arc<dyn Material>>,
    pub cell: Option<fn(&Vec3, f64) -> Composition>,
}

impl From<Arc<dyn Material>> for Made {
    fn from(material: Arc<dyn Material>) -> Self {
        Self { materials: vec![material], cell: None }
    }
}

/// A body that looks like `shape` when it is remeshed, where it has the displacement `moved`, a function of the place there; with
/// nothing, the undeformed body.
pub fn remeshed_body(
    made: impl Into<Made>,
    shape: Arc<dyn Shape>,
    resolution: Resolution,
    (smoothing, hourglass): (f64, f64),
    boundaries: &[Boundary],
    moved: Option<&dyn Fn(&Vec3) -> Vec3>,
) -> TestBody {
    let made = made.into();
    let sampled = sample(&*shape, resolution, &[]).unwrap();
    let (spacing, dimension) = (sampled.grid.spacing, shape.dimension());
    let undeformed = |x: &Vec3| moved.map_or(*x, |moved| x - moved(x));
    let nodes: Vec<Vec3> = sampled.cells.iter().map(|c| sampled.grid.centre(*c)).collect();
    let positions: Vec<Vec3> = nodes.iter().map(undeformed).collect();
    let mut boundary = if dimension == 2 { rim(shape.surface(), spacing) } else { shape.surface().clone() };
    for x in &mut boundary.vertices {
        let height = if dimension == 2 { std::mem::take(&mut x.z) } else { 0.0 };
        *x = undeformed(x) + Vec3::z() * height;
    }
    let modulus = Solver { smoothing, hourglass, ..Solver::ACCURATE }.hourglass_modulus(100.0);
    let constraints = Constraints::new(boundaries, &boundary, &positions, spacing).unwrap();
    let mut fixed = constraints.fixed(&positions).unwrap();
    if dimension == 2 {
        fixed.hold_in_plane(positions.len());
    }
    let solid = |volume: &[f64]| {
        let mut lattice = Lattice::new(&sampled.grid, &sampled.cells, smoothing, dimension);
        if let Some(sight) = &sampled.sight {
            lattice =
                lattice.cut(|a, b| sight.is_blocked(&sight.home(&positions[a]), &sight.home(&positions[b])));
        }
        let folds = Folds::new(&constraints, &boundary, &lattice, moved.is_some());
        let mut solid = Solid::new(lattice, volume, fixed.clone(), Arc::clone(&made.materials[0]), modulus);
        if let Some(cell) = made.cell {
            let cells = positions.iter().map(|x| cell(x, spacing)).collect();
            solid = solid.made_of(made.materials.clone(), cells);
        }
        solid.folded(folds, &constraints.holds)
    };
    let mut volume = sampled.volume.clone();
    let mut gradients: Vec<Mat3> = Vec::new();
    if moved.is_some() {
        let d: Vec<Vec3> = nodes.iter().zip(&positions).map(|(x, x0)| x - x0).collect();
        let d = Column::from_vectors(&d);
        let back = |g: &Mat3| Mat3::identity() - g;
        let of_d = solid(&volume).gradient(0.0, d.values());
        volume.iter_mut().zip(&of_d).for_each(|(v, g)| *v *= back(g).determinant());
        let of_d = solid(&volume).gradient(0.0, d.values());
        gradients = of_d.iter().map(|g| back(g).try_inverse().unwrap()).collect();
    }
    let solid = solid(&volume);
    let doubled = solid.lift.folds.doubled(&positions, &volume, spacing);
    let cloud = Cloud::new(&doubled.positions, &doubled.volume, spacing);
    let sight = sampled.sight.as_deref();
    let cloud = cloud.in_dimension(dimension).for_surface(smoothing).with_sight(sight);
    let fits = |places: &[Vec3]| places.iter().map(|x| cloud.fit_at(x)).collect();
    let particles = LoadedParticles { particles: &doubled, fits: &fits, sight };
    let held = |x: &Vec3, n: &Vec3| constraints.held_at(x, n);
    let holds = &constraints.holds;
    let surface = SurfaceQuadrature::new(&boundary, dimension, spacing, &particles, holds, &held);
    let solid = if moved.is_some() { solid.remeshed(&gradients) } else { solid };
    let solid = solid.with_surface(&surface, holds, &sampled.cut(), &positions);
    TestBody { solid, positions, spacing, surface }
}

/// A half-space of the unit cube's faces.
pub fn face(axis: Axis, at: f64, side: Side) -> Region {
    Region::Plane { axis, at, side }
}

/// A clamp at z = 0.
pub fn clamp() -> Boundary {
    Boundary { name: None, region: face(Axis::Z, 0.0, Side::Below), fix: Fix::ALL, motion: None }
}

/// The unit cube.
pub fn cube() -> Arc<dyn Shape> {
    Arc::new(BoxShape::new(Vec3::repeat(1.0), Vec3::zeros()).unwrap())
}

/// The unit cube of n^3 particles with these boundaries.
pub fn held_cube(n: usize, smoothing: f64, nu: f64, boundaries: &[Boundary]) -> TestBody {
    body(cube(), Resolution::Spacing(1.0 / n as f64), smoothing, 1.0, nu, boundaries)
}

/// The cube of n^3 particles clamped at z = 0.
pub fn clamped_cube(n: usize, smoothing: f64, nu: f64) -> TestBody {
    held_cube(n, smoothing, nu, &[clamp()])
}

/// A ball with cut cells, some of them small: a body with nothing flat.
pub fn ball(smoothing: f64) -> TestBody {
    let shape = Arc::new(SphereShape::new(0.47, Vec3::repeat(0.55)).unwrap());
    body(shape, Resolution::Spacing(0.1), smoothing, 1.0, 0.3, &[])
}

/// Conjugate gradients for K u = f.
pub fn solve(solid: &mut Solid, load: &[f64]) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut x = vec![0.0; load.len()];
    let mut r = load.to_vec();
    solid.fixed.zero(&mut r, load.len() / 3);
    let mut p = r.clone();
    let mut q = vec![0.0; load.len()];
    let mut rr = dot(&r, &r);
    let goal = 1e-18 * rr;
    while rr > goal {
        solid.force_of(&p, &mut q);
        let alpha = -rr / dot(&p, &q);
        for i in 0..x.len() {
            x[i] += alpha * p[i];
            r[i] += alpha * q[i];
        }
        let next = dot(&r, &r);
        for i in 0..x.len() {
            p[i] = r[i] + next / rr * p[i];
        }
        rr = next;
    }
    x
}
