//! The viscoelastic solid in the adjoint formulation: the corrected gradient of Eq. (10) and, for the
//! divergence of Eq. (12), its exact adjoint, so that the force is the derivative of a discrete energy
//! and a free surface needs no force of its own (Eq. 14).

mod constants;
mod contrast;
mod correction;
mod hourglass;
mod law;
mod materials;
mod measured;
mod reactions;
mod relaxation;
mod stress;
mod sweeps;

use super::{DERIVED, Dynamics, Energy, ForceSums, Imposed, Scales};
use crate::boundary::constraints::Hold;
use crate::boundary::fixed::Fixed;
use crate::boundary::fold::Folds;
use crate::boundary::lift::Lift;
use crate::boundary::nodal_load::NodalLoad;
use crate::boundary::surface_quadrature::SurfaceQuadrature;
use crate::lattice::{Lattice, reflection};
use crate::material::{Composition, Material};
use crate::measures::{is_measure, rests_on_stress};
use crate::moments::Moments;
use crate::ops::PAIR_COMPONENTS;
use crate::particles::{Column, Field, Particles};
use crate::tensor::{Mat3, SymTensor, Vec3};
use crate::tiles::Tile;
use constants::Constants;
use contrast::Contrast;
use correction::{Correction, GENERAL, Row, Surroundings};
use hourglass::Memory;
use materials::Materials;
use rayon::prelude::*;
use relaxation::Relaxation;
use std::sync::Arc;
use stress::State;

/// Particles that one partial sum covers: fixed, so that sums do not depend on the thread count.
const PARTICLES_PER_SUM: usize = 512;

/// A solid body on its lattice.
#[derive(Clone, Debug)]
pub struct Solid {
    /// The lattice of the last remesh.
    pub lattice: Lattice,
    /// F = d xi / d X of every particle at the last remesh, by which gradients on the lattice become
    /// gradients in the undeformed body, as a tiled field of 9; empty as long as the lattice is that of the undeformed body.
    remesh_gradient: Vec<Tile>,
    /// Held parts of the surface.
    pub lift: Lift,
    /// Particles held or moved.
    pub fixed: Fixed,
    /// Loads.
    pub loads: Vec<NodalLoad>,
    /// Mass of each particle.
    pub mass: Arc<Vec<f64>>,
    /// Constitutive laws, by place.
    pub(crate) materials: Arc<Materials>,
    /// kappa: modulus of the hourglass term (Pa), in the first of the materials; in others it goes with Young's modulus.
    pub hourglass: f64,
    /// Between particles of different moduli, if there are any.
    contrast: Option<Contrast>,
    /// A particle that is turned inside out.
    inverted: Option<usize>,
    /// Of materials with Prony series.
    relaxation: Option<Relaxation>,
    constants: Constants,
    correction: Correction,
    /// Of a body that was remeshed, under a law that is not linear.
    memory: Option<Memory>,
    work: Workspace,
}

/// Derived fields that every evaluation of the rates reuses.
#[derive(Clone, Debug)]
struct Workspace {
    /// V (u + T v), less its value at the first particle, tiled field of 3; after the second sweep its sums.
    q: Vec<Tile>,
    /// T_a and the force that needs no neighbour's T, tiled field of 12.
    pair: Vec<Tile>,
    /// On the rows of the correction: its sums of the first sweep, then V P.
    side: Vec<Tile>,
    /// Sums of the hourglass term of a remeshed body, then what the second sweep takes of it: tiled field of 9.
    products: Vec<Tile>,
    /// Gradient (for a linear law strain) lifted from held faces, there.
    lifted: Vec<Tile>,
    /// dF/dt, of laws that are not linear.
    rate: Vec<Tile>,
    /// State of the tangent, of such laws.
    state: State,
    sums: Vec<ForceSums>,
}

impl Solid {
    /// A body of particles with these volumes at the nodes of `lattice`, with `hourglass` as the modulus (Pa) of the
    /// hourglass term. Its surface is neither held nor corrected.
    pub fn new(
        lattice: Lattice,
        volume: &[f64],
        fixed: Fixed,
        material: Arc<dyn Material>,
        hourglass: f64,
    ) -> Self {
        let n = lattice.len();
        let work = Workspace {
            q: lattice.tiles.field(3),
            pair: lattice.tiles.field(PAIR_COMPONENTS),
            side: Vec::new(),
            products: Vec::new(),
            lifted: Vec::new(),
            rate: Vec::new(),
            state: State::default(),
            sums: vec![ForceSums::default(); n.div_ceil(PARTICLES_PER_SUM)],
        };
        let density = material.density();
        let materials = Materials::uniform(material);
        Self {
            remesh_gradient: Vec::new(),
            mass: Arc::new(volume.iter().map(|v| v * density).collect()),
            hourglass,
            contrast: None,
            inverted: None,
            relaxation: Relaxation::new(&materials, &lattice.tiles),
            constants: Constants::new(&lattice, volume),
            correction: Correction::default(),
            memory: None,
            lattice,
            lift: Lift::default(),
            fixed,
            loads: Vec::new(),
            materials: Arc::new(materials),
            work,
        }
    }

    /// The same body made of several `materials`, of which `cells` says what each particle holds. Its first material is that of
    /// [`Solid::new`].
    #[must_use]
    pub fn made_of(mut self, materials: Vec<Arc<dyn Material>>, cells: Vec<Composition>) -> Self {
        let volumes = self.volumes();
        let materials = Materials::by_place(materials.into_iter(), cells, &self.lattice.tiles);
        self.mass = Arc::new(volumes.iter().enumerate().map(|(a, v)| v * materials.density(a)).collect());
        self.set_materials(materials);
        self
    }

    /// Volume of every particle.
    fn volumes(&self) -> Vec<f64> {
        let of = |a: usize| {
            let (t, lane) = self.lattice.tiles.place(a);
            self.constants.volume(t)[lane]
        };
        (0..self.len()).map(of).collect()
    }

    /// The same body remeshed on a lattice where it had been deformed: `gradients` are F = d xi / d X of each particle, by which
    /// gradients on the lattice become gradients in the undeformed body.
    #[must_use]
    pub fn remeshed(mut self, gradients: &[Mat3]) -> Self {
        self.remesh_gradient = self.lattice.tiles.field(GENERAL);
        for (a, f) in gradients.iter().enumerate() {
            let (t, lane) = self.lattice.tiles.place(a);
            for c in 0..GENERAL {
                self.remesh_gradient[t * GENERAL + c].0[lane] = f[(c / 3, c % 3)];
            }
        }
        self
    }

    /// d xi / d X of each particle at the last remesh; nothing as long as the lattice is that of the undeformed body.
    fn remesh_gradients(&self) -> Vec<Mat3> {
        let of = |a: usize| {
            let (t, lane) = self.lattice.tiles.place(a);
            Mat3::from_fn(|i, j| self.remesh_gradient[t * GENERAL + 3 * i + j].0[lane])
        };
        (0..if self.remesh_gradient.is_empty() { 0 } else { self.len() }).map(of).collect()
    }

    /// The same body held by `folds`, in whose mirrors the particles have images; boundaries hold as `holds` says.
    #[must_use]
    pub fn folded(mut self, mut folds: Folds, holds: &[Hold]) -> Self {
        if folds.is_empty() {
            return self;
        }
        let volume = self.volumes();
        self.lattice = self.lattice.mirrored(&folds.mirrors());
        self.constants = Constants::new(&self.lattice, &volume);
        let materials = (*self.materials).clone().on(&self.lattice.tiles);
        let tiles = &self.lattice.tiles;
        let modulus = |a: usize| {
            let (t, lane) = tiles.place(a);
            materials.modulus(t, lane)
        };
        folds.take_images(&self.lattice, |a| volume[a], modulus);
        self.set_materials(materials);
        self.work.q = self.lattice.tiles.field(3);
        self.work.pair = self.lattice.tiles.field(PAIR_COMPONENTS);
        self.lift = Lift::folded(holds, folds);
        self
    }

    /// The same body with its surface, whose boundaries hold as `holds` says; `cut` says of each particle whether the
    /// surface cuts its cell. `positions` are those of the particles in the undeformed body. A constant stress balances its
    /// tractions on the surface.
    #[must_use]
    pub fn with_surface(
        mut self,
        surface: &SurfaceQuadrature,
        holds: &[Hold],
        cut: &[bool],
        positions: &[Vec3],
    ) -> Self {
        let spacing = self.lattice.spacing;
        let folds = std::mem::take(&mut *self.lift.folds);
        let wanted = surface.area_vectors(self.len(), &folds);
        let tiles = &self.lattice.tiles;
        let modulus = |a: usize| self.materials.young_modulus_of(tiles.place(a));
        self.lift = Lift::new(surface, holds, folds, modulus, spacing);
        let flagged = correction::near_surface(&self.lattice, cut);
        let remesh_gradients = self.remesh_gradients();
        self.correction = Correction::new(&Surroundings {
            lattice: &self.lattice,
            constants: &self.constants,
            moments: &self.moments(),
            remesh_gradients: &remesh_gradients,
            flagged: &flagged,
            wanted: &wanted,
            folds: &self.lift.folds,
            lifted: self.lift.particles(),
        });
        if !remesh_gradients.is_empty() {
            self.lift.folds.remember_remesh();
            let gradients = self.straightened(&remesh_gradients, positions);
            self = self.remeshed(&gradients);
        }
        if !remesh_gradients.is_empty() && !self.is_linear() {
            self.memory =
                Some(Memory::new(&self.lattice, &self.lift.folds.following, &self.constants, positions));
            self.work.products = self.lattice.tiles.field(GENERAL);
        }
        let on_rows = self.components() * self.correction.rows.len();
        self.work.side = vec![Tile::default(); on_rows];
        if !self.lift.is_empty() {
            self.work.lifted = vec![Tile::default(); on_rows];
        }
        self
    }

    /// d xi / d X by which the gradient of the reference positions is the unit tensor again, which the correction leaves it as on an
    /// undeformed lattice only: F (1 - E) for F, with E the gradient of the reference positions by the correction alone.
    fn straightened(&self, gradients: &[Mat3], positions: &[Vec3]) -> Vec<Mat3> {
        let moved = |a: usize| self.lattice.position(a) - positions[a];
        let following = &self.lift.folds.following;
        let of = |(a, f): (usize, &Mat3)| {
            let Some(row) = self.correction_row(a) else { return *f };
            let mut e = Mat3::zeros();
            for neighbour in &self.lattice.neighbours {
                if let Some(seen) = self.lattice.seen(a, neighbour) {
                    let (t, lane) = self.lattice.tiles.place(seen.particle);
                    let vw = self.constants.volume(t)[lane] * neighbour.w;
                    let gamma = self.gamma(seen.particle).component_mul(&reflection(seen.mirrors));
                    let residual = gamma - row.gamma - row.slope * neighbour.x;
                    let other = following.image(seen.mirrors, &moved(seen.particle));
                    let apart = neighbour.x + moved(a) - other;
                    e += vw * apart * residual.transpose();
                }
            }
            f * (Mat3::identity() - e)
        };
        gradients.par_iter().enumerate().map(of).collect()
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.lattice.len()
    }

    /// Moments of particle `a`.
    pub fn moments_of(&self, a: usize) -> Moments {
        let (t, lane) = self.lattice.tiles.place(a);
        self.constants.moments(t, lane)
    }

    /// Moments of all particles.
    pub fn moments(&self) -> Vec<Moments> {
        (0..self.len()).into_par_iter().map(|a| self.moments_of(a)).collect()
    }

    /// Constants of the correction of the gradient of particle `a`, if there is one.
    pub(crate) fn correction_row(&self, a: usize) -> Option<Row> {
        let (t, lane) = self.lattice.tiles.place(a);
        self.correction.row(t, lane, self.constants.volume(t)[lane])
    }

    /// gamma of the correction at particle `a`.
    pub(crate) fn gamma(&self, a: usize) -> Vec3 {
        let (t, lane) = self.lattice.tiles.place(a);
        self.correction.gamma(t, lane)
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.lattice.is_empty()
    }

    /// -K u of the displacement field `u` (component by component) into `force`, with every held face at rest: its internal
    /// force if the law is linear. Components that are held get zero.
    pub fn force_of(&mut self, u: &[f64], force: &mut [f64]) {
        self.apply(Scales { stiffness: -1.0, ..Scales::default() }, u, force);
    }

    /// y = (m M + k K + c C) x with M the masses, K the stiffness about the state of the last
    /// [`linearise`](Self::linearise), C the damping there and every held face at rest, of fields component by component.
    /// Components that are held get zero.
    pub fn apply(&mut self, scales: Scales, x: &[f64], y: &mut [f64]) {
        let n = self.len();
        let (m, c) = (scales.mass, scales.of_stiffness(self.relaxation_time()));
        self.lift.rest();
        self.spread(x, None);
        self.tangent_sweep(scales);
        self.adjoint_sweep();
        let (yx, yyz) = y.split_at_mut(n);
        let (yy, yz) = yyz.split_at_mut(n);
        let chunk = PARTICLES_PER_SUM;
        (yx.par_chunks_mut(chunk), yy.par_chunks_mut(chunk), yz.par_chunks_mut(chunk))
            .into_par_iter()
            .enumerate()
            .for_each(|(k, (yx, yy, yz))| {
                let first = k * chunk;
                self.internal_forces(first, [&mut *yx, &mut *yy, &mut *yz]);
                for (i, y) in [yx, yy, yz].into_iter().enumerate() {
                    let x = &x[i * n + first..][..y.len()];
                    for ((y, x), mass) in y.iter_mut().zip(x).zip(&self.mass[first..]) {
                        *y = m * mass * x - c * *y;
                    }
                }
            });
        if !self.work.state.is_positive {
            NodalLoad::add_tangent(&mut self.loads, -scales.stiffness, x, y);
        }
        self.fixed.zero(y, n);
    }

    /// The sum of all loads at time `t` and the displacement u into `load`, component by component.
    pub fn load_at(&mut self, t: f64, u: &[f64], load: &mut [f64]) {
        NodalLoad::follow(&mut self.loads, u);
        NodalLoad::sum(&self.loads, t, load);
    }

    /// Strain e = sym grad u of every particle, component by component (6 n values).
    pub fn strain(&mut self, t: f64, u: &[f64]) -> Vec<f64> {
        self.spread_displacement(t, u);
        self.visit_sums(false, |_, _, sums| {
            let mut out = [0.0; PAIR_COMPONENTS];
            out[..6].copy_from_slice(&SymTensor::symmetric_part(&sums.deformation).0);
            out
        });
        self.gather_pair(0..6)
    }

    /// Gradient grad u in the undeformed body of every particle, without the terms of the correction near the surface.
    /// A field that is linear in the undeformed body is exact only where its lattice is that body's, or before
    /// [`with_surface`](Self::with_surface).
    pub fn gradient(&mut self, t: f64, u: &[f64]) -> Vec<Mat3> {
        self.spread_displacement(t, u);
        self.visit_sums(false, |_, _, sums| {
            std::array::from_fn(|i| if i < 9 { sums.gradient[(i / 3, i % 3)] } else { 0.0 })
        });
        let (n, values) = (self.len(), self.gather_pair(0..9));
        (0..n).map(|a| Mat3::from_fn(|i, j| values[(3 * i + j) * n + a])).collect()
    }
}

impl Dynamics for Solid {
    fn integrated(&self) -> &'static [Field] {
        self.columns()
    }

    fn moves_with_velocity(&self) -> bool {
        true
    }

    fn rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums {
        let n = self.len();
        let (u, v) = (particles.column(Field::Displacement), particles.column(Field::Velocity));
        let (motion, relaxed) = rates.split_at_mut(2);
        self.take_relaxed(particles);
        if !relaxed.is_empty() {
            self.relaxed_rates(t, particles, relaxed);
        }

        self.stress_sweep_at(t, u.values(), v.values()); // Eqs. (10), (13), (5)
        self.adjoint_sweep(); // Eq. (12)
        NodalLoad::follow(&mut self.loads, u.values());

        let [du, dv] = motion else { unreachable!("displacement and velocity") };
        if !du.is_empty() {
            du.values_mut().copy_from_slice(v.values()); // Eq. (4)
        }
        let mut sums = std::mem::take(&mut self.work.sums);
        let (ax, ayz) = dv.values_mut().split_at_mut(n);
        let (ay, az) = ayz.split_at_mut(n);
        let chunk = PARTICLES_PER_SUM;
        (ax.par_chunks_mut(chunk), ay.par_chunks_mut(chunk), az.par_chunks_mut(chunk), &mut sums)
            .into_par_iter()
            .enumerate()
            .for_each(|(c, (ax, ay, az, sum))| {
                *sum = ForceSums::default();
                let first = c * chunk;
                self.internal_forces(first, [&mut *ax, &mut *ay, &mut *az]);
                let mut load = [[0.0; PARTICLES_PER_SUM]; 3];
                let [lx, ly, lz] = load.each_mut().map(|l| &mut l[..ax.len()]);
                NodalLoad::add(&self.loads, t, n, first, [lx, ly, lz]);
                for (i, (a, load)) in [ax, ay, az].into_iter().zip(&load).enumerate() {
                    let at = i * n + first;
                    let v = &v.values()[at..at + a.len()];
                    let (mut total, mut power) = (0.0, 0.0);
                    for (((a, load), v), mass) in a.iter_mut().zip(load).zip(v).zip(&self.mass[first..]) {
                        *a = (*a + load) / mass; // Eq. (2)
                        total += load;
                        power += load * v;
                    }
                    sum.load[i] = total;
                    sum.power += power;
                }
            });
        let mut total = sums.iter().fold(ForceSums::default(), |s, c| s.add_scaled(1.0, c));
        self.work.sums = sums;
        let (reaction, power) = self.lift.reaction();
        total.reaction += reaction;
        total.power += power;
        self.fixed.hold(t, &self.mass, du.values_mut(), dv.values_mut(), &mut total);
        total
    }

    fn solid(&mut self) -> Option<&mut Solid> {
        Some(self)
    }

    fn smallest_jacobian(&mut self, t: f64, particles: &Particles) -> Option<(usize, f64)> {
        Solid::smallest_jacobian(self, t, particles.column(Field::Displacement).values())
    }

    fn loads_mut(&mut self) -> Option<&mut Vec<NodalLoad>> {
        Some(&mut self.loads)
    }

    fn impose(&self, t: f64, particles: &mut Particles) -> Imposed {
        self.fixed.impose(t, &self.mass, particles)
    }

    fn derive(&mut self, t: f64, particles: &mut Particles) {
        self.derive_some(t, &DERIVED, particles);
    }

    fn derive_some(&mut self, t: f64, wanted: &[Field], particles: &mut Particles) {
        let n = self.len();
        let wants = |field| wanted.contains(&field);
        let u = particles.column(Field::Displacement).clone();
        let v = particles.column(Field::Velocity).clone();
        if self.materials.is_several() {
            let numbers = (0..n).map(|a| self.material_of(a) as f64).collect();
            particles.set(Field::Material, Column::from_vec(numbers, n));
        }
        let chosen: Vec<Field> = wanted.iter().copied().filter(|f| is_measure(*f)).collect();
        let wants_stress =
            wants(Field::Stress) || wants(Field::VonMises) || chosen.iter().any(|f| rests_on_stress(*f));
        self.take_relaxed(particles);
        let [strain, stress] = self.strain_and_stress(t, u.values(), wants_stress.then(|| v.values()));
        if !chosen.is_empty() {
            self.set_measures(t, &chosen, [&strain, &stress], particles);
        }
        if wants(Field::Strain) || wants(Field::Density) {
            // Eq. (1), integrated: d(ln rho)/dt = -tr(de/dt), and the trace of Hencky's strain is ln det F.
            let volume = particles.column(Field::Volume).values();
            let density = (0..n)
                .map(|a| self.mass[a] / volume[a] * (-(strain[a] + strain[n + a] + strain[2 * n + a])).exp())
                .collect();
            particles.set(Field::Density, Column::from_vec(density, n));
            particles.set(Field::Strain, Column::from_vec(strain, n));
        }
        if wants(Field::Stress) || wants(Field::VonMises) {
            let von_mises = |a: usize| SymTensor(std::array::from_fn(|c| stress[c * n + a])).von_mises();
            particles.set(Field::VonMises, Column::from_vec((0..n).map(von_mises).collect(), n));
            if wants(Field::Stress) {
                particles.set(Field::Stress, Column::from_vec(stress, n));
            }
        }
    }

    fn energy(&mut self, t: f64, particles: &Particles) -> Energy {
        let (u, v) = (particles.column(Field::Displacement), particles.column(Field::Velocity));
        let elements = self.energy_of_elements(t, particles);
        let elastic = self.elastic_energy(t, 1.0, u.values()) + elements;
        let kinetic = (0..self.len()).map(|a| 0.5 * self.mass[a] * v.vector(a).norm_squared()).sum();
        Energy { kinetic, elastic }
    }
}
