//! A solid at large strain: total Lagrangian between remeshings, with the reference position X carried by
//! the particles. The force is the exact derivative of a discrete energy of the positions.

pub mod body;
pub mod configuration;
mod energy;
pub mod equilibrium;
pub mod ghosts;
pub mod points;
pub mod remeshing;
mod state;
pub mod sweeps;

use super::{Dynamics, Energy, ForceSums, Imposed};
use crate::boundary::fixed::Fixed;
use crate::boundary::nodal_load::NodalLoad;
use crate::error::InvalidInput;
use crate::material::{FiniteStrain, Material};
use crate::particles::{Column, Field, Particles};
use crate::tensor::{Mat3, SymTensor, Vec3};
use configuration::Configuration;
use points::Points;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::f64::consts::TAU;
use std::sync::Arc;
use sweeps::{Gradients, Hourglass};

/// Particles that one partial sum covers: fixed, so that sums do not depend on the thread count.
const PARTICLES_A_SUM: usize = 512;

/// A body at large strain, in the plane (`D` = 2: plane strain) or in space.
#[derive(Clone, Debug)]
pub struct LargeStrain<const D: usize> {
    /// Lattice of the last remesh.
    pub configuration: Configuration<D>,
    /// Particles held or moved.
    pub fixed: Fixed,
    /// Dead loads.
    pub loads: Vec<NodalLoad>,
    /// Mass of each particle.
    pub mass: Vec<f64>,
    /// Constitutive law; it has a [`FiniteStrain`].
    pub material: Arc<dyn Material>,
    /// alpha (lambda + 2 mu): stiffness of the hourglass term.
    pub hourglass: f64,
    /// F_0^-1 of each particle.
    undo: Vec<Mat3>,
    work: Workspace,
}

/// Fields that every evaluation reuses.
#[derive(Clone, Debug)]
struct Workspace {
    /// All points, ghosts behind the particles.
    points: Points,
    /// F of particles.
    f: Vec<Mat3>,
    /// dF/dt of particles.
    f_rate: Vec<Mat3>,
    /// Internal force on points; ghosts' are folded into the particles'.
    force: Vec<Vec3>,
    energy: Vec<f64>,
    /// What loads and boundaries do to each `PARTICLES_A_SUM` particles.
    sums: Vec<ForceSums>,
}

/// Positions and velocities of points.
struct Moment {
    x: Vec<Vec3>,
    v: Vec<Vec3>,
}

impl<const D: usize> LargeStrain<D> {
    /// A body of `configuration`, with the weight alpha of the hourglass term.
    ///
    /// # Errors
    /// `material.model` when the material has no law for large strain.
    pub fn new(
        configuration: Configuration<D>,
        material: Arc<dyn Material>,
        hourglass_weight: f64,
    ) -> Result<Self, InvalidInput> {
        if material.law().finite_strain().is_none() {
            return Err(InvalidInput::new(
                "material.model",
                material.name(),
                "has no law for large strain",
                "take \"neo-hookean\"",
            ));
        }
        let (n, none) = (configuration.len, Mat3::zeros());
        let work = Workspace {
            points: Points::new(&configuration),
            f: vec![none; n],
            f_rate: vec![none; n],
            force: vec![Vec3::zeros(); configuration.nodes.len()],
            energy: vec![0.0; n],
            sums: vec![ForceSums::default(); n.div_ceil(PARTICLES_A_SUM)],
        };
        let density = material.density();
        let inverse = |f: &Mat3| f.try_inverse().unwrap_or_else(Mat3::zeros);
        Ok(Self {
            undo: configuration.first_gradient.iter().map(inverse).collect(),
            mass: configuration.reference_volume.iter().map(|v| v * density).collect(),
            hourglass: hourglass_weight * material.p_wave_modulus(),
            configuration,
            fixed: Fixed::default(),
            loads: Vec::new(),
            material,
            work,
        })
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.configuration.len
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.configuration.is_empty()
    }

    /// Moves the particles to x with velocities v, `to(a)` = (x, v), and the planes to where they are at time `t`.
    fn set(&mut self, t: f64, to: impl Fn(usize) -> (Vec3, Vec3) + Sync) {
        self.configuration.ghosts.set_time(t);
        self.work.points.set(&self.configuration, to);
    }

    /// F and dF/dt of where the particles were set, and sources of force for the stress `law`(F, dF/dt) and the
    /// hourglass term of the field x + `of_companion` v.
    fn gradients(&mut self, of_companion: f64, law: &(impl Fn(&Mat3, &Mat3) -> Mat3 + Sync)) {
        let hourglass = Hourglass { stiffness: self.hourglass, of_position: 1.0, of_companion };
        let (w, c) = (&mut self.work, &self.configuration);
        w.points.gradients(c, hourglass, law, Gradients { f: &mut w.f, f_rate: &mut w.f_rate });
    }

    /// F and dF/dt alone.
    fn strain(&mut self) {
        self.gradients(0.0, &|_, _| Mat3::zeros());
    }

    /// Positions and velocities of all points, ghosts included, from those of the particles at time `t`, and
    /// the deformation gradients of that moment.
    fn all_points(&mut self, t: f64, x: &[Vec3], v: &[Vec3]) -> Moment {
        self.set(t, |a| (x[a], v[a]));
        self.strain();
        Moment { x: self.work.points.positions(), v: self.work.points.velocities() }
    }

    /// Internal force of what the gradients have made; returns the power of moving planes.
    fn sum_forces(&mut self) -> f64 {
        let (c, w) = (&self.configuration, &mut self.work);
        w.points.forces(c, &mut w.force); // Eq. (12)
        c.ghosts.fold_forces(&mut w.force)
    }

    /// Elastic force on the particles at rest at the positions `x` while planes are where they are at time
    /// `t`, and the elastic energy (infinite where the body is turned inside out).
    pub fn elastic_force(&mut self, t: f64, x: &[Vec3], force: &mut [Vec3]) -> f64 {
        self.set(t, |a| (x[a], Vec3::zeros()));
        let material = Arc::clone(&self.material);
        let law = law_of(&*material);
        self.gradients(0.0, &|f, _| law.first_piola(f));
        self.sum_forces();
        force.copy_from_slice(&self.work.force[..self.len()]);
        self.elastic_energy()
    }

    /// Elastic energy where the particles were set, F being known.
    fn elastic_energy(&mut self) -> f64 {
        let (c, w) = (&self.configuration, &mut self.work);
        w.points.energies(c, law_of(&*self.material), self.hourglass, &w.f, &mut w.energy);
        w.energy.iter().sum()
    }

    /// Change of the elastic force when the particles change places by `dx`, at the positions of the last
    /// [`Self::elastic_force`]: minus the stiffness times `dx`.
    pub fn tangent_force(&mut self, dx: &[Vec3], force: &mut [Vec3]) {
        let law = law_of(&*self.material);
        let (c, w) = (&self.configuration, &mut self.work);
        w.points.set_changes(c, dx);
        let hourglass = Hourglass { stiffness: self.hourglass, of_position: 0.0, of_companion: 1.0 };
        let out = Gradients { f: &mut w.f, f_rate: &mut w.f_rate };
        w.points.gradients(c, hourglass, &|f, df| law.tangent(f, df), out);
        self.sum_forces();
        force.copy_from_slice(&self.work.force[..self.len()]);
    }

    /// Forces on the particles in equilibrium with the uniform first Piola-Kirchhoff stress `p`, component by
    /// component: p times the discrete reference area vectors.
    pub fn surface_forces(&mut self, p: &Mat3) -> Vec<Vec3> {
        let c = &self.configuration;
        let none = vec![Mat3::zeros(); c.len];
        let out = Gradients { f: &mut none.clone(), f_rate: &mut none.clone() };
        let hourglass = Hourglass { stiffness: 0.0, of_position: 0.0, of_companion: 0.0 };
        // At the nodes, where nothing can be amiss.
        self.work.points.set(c, |a| (c.nodes[a], Vec3::zeros()));
        self.work.points.gradients(c, hourglass, &|_, _| *p, out);
        self.sum_forces();
        self.work.force[..self.len()].iter().map(|f| -f).collect()
    }

    /// Deformation gradients F at the last evaluation.
    pub fn deformation(&self) -> &[Mat3] {
        &self.work.f
    }

    /// A particle that is turned inside out, det F <= 0, at the last evaluation.
    pub fn inverted(&self) -> Option<usize> {
        // What is not a number was turned inside out a stage before.
        let turned = |f: &Mat3| f.determinant().partial_cmp(&0.0) != Some(Ordering::Greater);
        self.work.f.par_iter().with_min_len(PARTICLES_A_SUM).position_first(turned)
    }

    /// Smallest and largest singular value of F_inc, the deformation since the last remesh, at the last
    /// evaluation.
    pub fn stretches_since_remesh(&self) -> (f64, f64) {
        let chunk = PARTICLES_A_SUM;
        let (low, high) = (self.work.f.par_chunks(chunk), self.undo.par_chunks(chunk))
            .into_par_iter()
            .map(|(f, undo)| {
                f.iter().zip(undo).fold((1.0_f64, 1.0_f64), |(low, high), (f, undo)| {
                    let f = f * undo;
                    let (smallest, largest) = extreme_eigenvalues(&(f.transpose() * f));
                    (low.min(smallest), high.max(largest))
                })
            })
            .reduce(|| (1.0, 1.0), |p, q| (p.0.min(q.0), p.1.max(q.1)));
        (low.max(0.0).sqrt(), high.sqrt())
    }
}

impl<const D: usize> Dynamics for LargeStrain<D> {
    fn integrated(&self) -> &'static [Field] {
        &[Field::Displacement, Field::Velocity]
    }

    fn rates(&mut self, t: f64, particles: &Particles, rates: &mut [Column]) -> ForceSums {
        let n = self.len();
        let (reference, u, v) = (
            particles.column(Field::Reference),
            particles.column(Field::Displacement),
            particles.column(Field::Velocity),
        );
        self.set(t, |a| (reference.vector(a) + u.vector(a), v.vector(a)));
        let material = Arc::clone(&self.material);
        let law = law_of(&*material);
        let stress = |f: &Mat3, f_rate: &Mat3| law.first_piola(f) + law.viscous_piola(f, f_rate);
        self.gradients(material.relaxation_time(), &stress); // Eqs. (10), (13)
        let planes = ForceSums { power: self.sum_forces(), ..ForceSums::default() };

        let [du, dv] = rates else { unreachable!("two integrated columns") };
        du.values_mut().copy_from_slice(v.values()); // Eq. (4)
        let (ax, ayz) = dv.values_mut().split_at_mut(n);
        let (ay, az) = ayz.split_at_mut(n);
        let (w, loads, mass) = (&mut self.work, &self.loads, &self.mass);
        let chunk = PARTICLES_A_SUM;
        let internal = w.force[..n].par_chunks(chunk);
        (ax.par_chunks_mut(chunk), ay.par_chunks_mut(chunk), az.par_chunks_mut(chunk), internal, &mut w.sums)
            .into_par_iter()
            .enumerate()
            .for_each(|(i, (ax, ay, az, internal, sum))| {
                let first = i * chunk;
                *sum = ForceSums::default();
                ax.fill(0.0);
                ay.fill(0.0);
                az.fill(0.0);
                NodalLoad::add(loads, t, n, first, [&mut *ax, &mut *ay, &mut *az]);
                for (k, internal) in internal.iter().enumerate() {
                    let (a, load) = (first + k, Vec3::new(ax[k], ay[k], az[k]));
                    sum.reaction += internal;
                    sum.load += load;
                    sum.power += load.dot(&v.vector(a));
                    let acceleration = (internal + load) / mass[a]; // Eq. (2)
                    [ax[k], ay[k], az[k]] = acceleration.into();
                }
            });
        let mut total = w.sums.iter().fold(planes, |total, sum| total.add_scaled(1.0, sum));
        self.fixed.hold(t, &self.mass, du.values_mut(), dv.values_mut(), &mut total);
        total
    }

    fn loads_mut(&mut self) -> Option<&mut Vec<NodalLoad>> {
        Some(&mut self.loads)
    }

    fn impose(&self, t: f64, particles: &mut Particles) -> Imposed {
        self.fixed.impose(t, &self.mass, particles)
    }

    /// Strain is Hencky's, ln V = 1/2 ln(F F^T); stress is Cauchy's, its viscous part included.
    fn derive(&mut self, t: f64, particles: &mut Particles) {
        let n = self.len();
        let (reference, u, v) = (
            particles.column(Field::Reference).clone(),
            particles.column(Field::Displacement).clone(),
            particles.column(Field::Velocity).clone(),
        );
        self.set(t, |a| (reference.vector(a) + u.vector(a), v.vector(a)));
        self.strain();
        let (mut strain, mut stress) = (vec![0.0; 6 * n], vec![0.0; 6 * n]);
        let (mut density, mut von_mises) = (vec![0.0; n], vec![0.0; n]);
        let law = law_of(&*self.material);
        for (a, (f, f_rate)) in self.work.f.iter().zip(&self.work.f_rate).enumerate() {
            let j = f.determinant();
            let piola = law.first_piola(f) + law.viscous_piola(f, f_rate);
            let cauchy = SymTensor::symmetric_part(&(piola * f.transpose() / j));
            let hencky = SymTensor::symmetric_part(&logarithmic_strain(f));
            for c in 0..6 {
                strain[c * n + a] = hencky.0[c];
                stress[c * n + a] = cauchy.0[c];
            }
            density[a] = self.material.density() / j; // Eq. (1), integrated
            von_mises[a] = cauchy.von_mises();
        }
        particles.set(Field::Density, Column::from_vec(density, n));
        particles.set(Field::Strain, Column::from_vec(strain, n));
        particles.set(Field::Stress, Column::from_vec(stress, n));
        particles.set(Field::VonMises, Column::from_vec(von_mises, n));
    }

    fn energy(&mut self, t: f64, particles: &Particles) -> Energy {
        let (reference, u, v) = (
            particles.column(Field::Reference),
            particles.column(Field::Displacement),
            particles.column(Field::Velocity),
        );
        self.set(t, |a| (reference.vector(a) + u.vector(a), v.vector(a)));
        self.strain();
        let kinetic = (0..self.len()).map(|a| 0.5 * self.mass[a] * v.vector(a).norm_squared()).sum();
        Energy { kinetic, elastic: self.elastic_energy() }
    }
}

/// The law for large strain of a material that has one.
fn law_of(material: &dyn Material) -> &dyn FiniteStrain {
    match material.law().finite_strain() {
        Some(law) => law,
        None => unreachable!("checked when the body was made"),
    }
}

/// Smallest and largest eigenvalue of a symmetric matrix: with the mean m of all three and p^2 = |C - m I|^2 / 6 they
/// are m + 2 p cos(angle + 2 pi k / 3), where cos(3 angle) = det((C - m I) / p) / 2.
fn extreme_eigenvalues(c: &Mat3) -> (f64, f64) {
    let mean = c.trace() / 3.0;
    let deviator = c - Mat3::identity() * mean;
    let p = (deviator.norm_squared() / 6.0).sqrt();
    if p == 0.0 {
        return (mean, mean);
    }
    let angle = ((deviator / p).determinant() / 2.0).clamp(-1.0, 1.0).acos() / 3.0;
    (mean + 2.0 * p * (angle + TAU / 3.0).cos(), mean + 2.0 * p * angle.cos())
}

/// ln V = 1/2 ln(F F^T).
fn logarithmic_strain(f: &Mat3) -> Mat3 {
    let eigen = (f * f.transpose()).symmetric_eigen();
    let logarithms = eigen.eigenvalues.map(|s| 0.5 * s.max(f64::MIN_POSITIVE).ln());
    eigen.eigenvectors * Mat3::from_diagonal(&logarithms) * eigen.eigenvectors.transpose()
}

/// Vector `a` of a column of `n`.
fn vector(column: &[f64], n: usize, a: usize) -> Vec3 {
    Vec3::new(column[a], column[n + a], column[2 * n + a])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn extreme_eigenvalues_are_those_of_the_decomposition(
            f in prop::array::uniform9(-2.0..2.0_f64), alike in prop::bool::ANY
        ) {
            let f = Mat3::from_row_slice(&f);
            // Two or three of them alike are the hard cases.
            let f = if alike { Mat3::identity() + f.column(0) * f.column(1).transpose() * 1e-9 } else { f };
            let c = f.transpose() * f;
            let exact = c.symmetric_eigenvalues();
            let (smallest, largest) = extreme_eigenvalues(&c);
            prop_assert!((smallest - exact.min()).abs() < 1e-7 * exact.max());
            prop_assert!((largest - exact.max()).abs() < 1e-7 * exact.max());
        }
    }

    #[test]
    fn extreme_eigenvalues_by_hand() {
        assert_eq!(extreme_eigenvalues(&Mat3::identity()), (1.0, 1.0));
        let (smallest, largest) = extreme_eigenvalues(&Mat3::from_diagonal(&Vec3::new(4.0, 1.0, 1.0)));
        assert!((smallest - 1.0).abs() < 1e-7 && (largest - 4.0).abs() < 1e-12);
    }
}
