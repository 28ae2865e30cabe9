//! Strain and stress on the surface of a solid, read with the traction that is known there.
//!
//! The strain of the last layer of particles belongs to places half a spacing inside; on the surface a cubic fit of the
//! displacement gives the tangential strains, and the traction t the others: e = e_fit + sym(a (x) n) with sigma(e) n = t.
//! Of t only the components that are not held are known, and a has only those: on a roller the shear is read so and the fit
//! gives the rest, on a clamp and where forces from outside push the fit stands alone. A Kelvin-Voigt solid has
//! sigma = C (e + T de/dt): its stress follows from u + T v and t, and its strain from u and what t becomes in C e n, which
//! obeys T ds/dt + s = t. Under any other law F = F_fit + a (x) n with P(F, dF/dt) n = t, dF/dt as the fit has it.

use super::held::Held;
use super::materials::at_points;
use crate::boundary::constraints::projectors;
use crate::boundary::load::SurfaceTraction;
use crate::boundary::surface_load::SurfacePoint;
use crate::error::InvalidInput;
use crate::material::{Composition, FiniteStrain, Law, Material, Scaled, Stiffness};
use crate::measures::LocalState;
use crate::mesh::TriangleMesh;
use crate::mls::{Cloud, GradientFit};
use crate::neighbors::CellList;
use crate::setup::{Curve, Load, Setup, SolidSetup};
use crate::surface::VertexStrain;
use crate::tensor::{Mat3, SymTensor, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Radius over which normals are averaged, in spacings.
const SMOOTH: f64 = 0.75;
/// Cosine of the angle up to which the surface bends and is not an edge between two faces: 30 degrees.
const SAME_FACE: f64 = 0.866;
/// Tolerance of regions for vertices of the zero level set, in spacings.
const TOLERANCE: f64 = 0.1;

/// How the stress at a vertex has relaxed: beta and K of beta S^e - K.
pub(super) type BetaAndK = (f64, SymTensor);

/// A law that has relaxed: P = beta P^e - F K.
#[derive(Debug)]
struct RelaxedLaw<'a> {
    law: &'a dyn FiniteStrain,
    factor: f64,
    relaxed: Mat3,
}

impl FiniteStrain for RelaxedLaw<'_> {
    /// beta W - K : E.
    fn energy(&self, f: &Mat3) -> f64 {
        let strain = 0.5 * (f.transpose() * f - Mat3::identity());
        self.factor * self.law.energy(f) - self.relaxed.dot(&strain)
    }

    fn first_piola(&self, f: &Mat3) -> Mat3 {
        self.law.first_piola(f) * self.factor - f * self.relaxed
    }

    fn tangent(&self, f: &Mat3, df: &Mat3) -> Mat3 {
        self.law.tangent(f, df) * self.factor - df * self.relaxed
    }

    fn viscous_piola(&self, f: &Mat3, f_rate: &Mat3) -> Mat3 {
        self.law.viscous_piola(f, f_rate)
    }
}

/// The vertices of the undeformed surface, as readings want them.
#[derive(Clone, Debug)]
pub(super) struct SurfaceReading {
    vertices: Vec<Vertex>,
    /// The material at each; nothing if it is the same everywhere.
    materials: Vec<Composition>,
    /// C e n at an earlier time, from which it goes on: at the start, at rest, and when loads are replaced.
    pub(super) settled: Settled,
}

#[derive(Clone, Copy, Debug)]
struct Vertex {
    /// Place on the surface of the shape.
    x: Vec3,
    /// Outward normal there; beside an edge that of the face that is nearest.
    normal: Vec3,
    /// Projector on the components of the traction that are known.
    free: Mat3,
}

/// C e n of every vertex at some time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Settled {
    /// When.
    pub time: f64,
    /// What; none where it is zero.
    pub traction: Vec<Vec3>,
}

/// What a surface is loaded with.
pub(super) struct Loading<'a> {
    pub solid: &'a SolidSetup,
    pub loads: &'a [Load],
    pub surface: &'a TriangleMesh,
    pub spacing: f64,
}

impl<'a> Loading<'a> {
    /// The loads of a set-up on a surface with particles that far apart.
    pub fn of(setup: &'a Setup<SolidSetup>, surface: &'a TriangleMesh, spacing: f64) -> Self {
        Self { solid: &setup.mechanics, loads: &setup.mechanics.loads, surface, spacing }
    }
}

impl SurfaceReading {
    /// Of the zero level set of a body with these vertices; `points` cover its surface, held as `held` says.
    ///
    /// # Errors
    /// A modulus on the surface that is not positive.
    pub fn new(
        setup: &Setup<SolidSetup>,
        held: &Held,
        points: &[SurfacePoint],
        vertices: &[Vec3],
        spacing: f64,
    ) -> Result<Self, InvalidInput> {
        let shape = &*setup.shape;
        let places: Vec<Vec3> = points.iter().map(|p| p.x).collect();
        let cells = CellList::new(&places, SMOOTH * spacing);
        let set = |p: &SurfacePoint| held.held_at(&p.x, &p.normal).unwrap_or(0);
        let in_plane = shape.dimension() == 2;
        let vertex = |x: &Vec3| {
            let inside = shape.signed_distance(x) < -TOLERANCE * spacing;
            if in_plane && inside {
                // On a face of the slab that a body in the plane is drawn as.
                let normal = Vec3::new(0.0, 0.0, x.z.signum());
                return Vertex { x: *x, normal, free: Mat3::zeros() };
            }
            let x = &if in_plane { Vec3::new(x.x, x.y, 0.0) } else { *x };
            let Some((nearest, _)) = cells.nearest(&places, x, f64::INFINITY) else {
                return Vertex { x: *x, normal: Vec3::zeros(), free: Mat3::zeros() };
            };
            let nearest = &points[nearest];
            let held_there = set(nearest);
            let mut normal = nearest.normal * (1e-9 * spacing * spacing);
            cells.visit_near(&nearest.x, SMOOTH * spacing, |k| {
                let p = &points[k as usize];
                let near = 1.0 - (p.x - nearest.x).norm() / (SMOOTH * spacing);
                let goes_on = p.normal.dot(&nearest.normal) > SAME_FACE;
                if near > 0.0 && goes_on && set(p) == held_there {
                    normal += p.normal * (p.area * near);
                }
            });
            let normal = normal.normalize();
            let what_is_held = projectors(held.holds(), held_there, &normal);
            let free = what_is_held.iter().fold(Mat3::identity(), |free, (_, projector)| free - projector);
            Vertex { x: x - shape.signed_distance(x) * normal, normal, free }
        };
        let materials = at_points(&setup.mechanics, vertices)?;
        let vertices = vertices.par_iter().map(vertex).collect();
        Ok(Self { vertices, materials, settled: Settled::default() })
    }

    /// Number of the material at vertex `i`.
    fn number(&self, i: usize) -> usize {
        self.materials.get(i).map_or(0, |cell| usize::from(cell.materials[0]))
    }

    /// The material at vertex `i`, and the factor of its moduli.
    fn material<'a>(&self, solid: &'a SolidSetup, i: usize) -> (&'a dyn Material, f64) {
        let factor = self.materials.get(i).map_or(1.0, |cell| cell.factors[0]);
        (&**solid.materials().nth(self.number(i)).unwrap_or(&solid.material), factor)
    }

    /// Factors of the tractions at time `t` as every material has relaxed to them.
    fn relaxed_factors(
        &self,
        loading: &Loading<'_>,
        tractions: &Tractions<'_>,
        t: f64,
        at_rest: bool,
    ) -> Vec<Vec<f64>> {
        let of = |material: &Arc<dyn Material>| {
            let relaxation_time = if at_rest { 0.0 } else { material.relaxation_time() };
            tractions.factors(|curve| self.relaxed_factor(curve, t, relaxation_time))
        };
        loading.solid.materials().map(of).collect()
    }

    /// Fits of the gradient at the places that are read.
    pub fn fits(&self, cloud: &Cloud<'_>) -> Vec<GradientFit> {
        self.vertices.par_iter().map(|v| cloud.gradient_fit(&v.x)).collect()
    }

    /// Strain and stress of every vertex at time `t`, from the displacement u of the particles and u + T v with the longest T. The traction
    /// is not known near particles that are `pushed` by forces from outside (nothing: there are none). `relaxed_stress` gives
    /// beta and K at a vertex of that material; `None` if it does not relax.
    pub fn read(
        &self,
        loading: &Loading<'_>,
        (cloud, fits): (&Cloud<'_>, &[GradientFit]),
        pushed: &[bool],
        t: f64,
        relaxed_stress: impl Fn(usize, &dyn Material) -> Option<BetaAndK> + Sync,
        (u, effective): (impl Fn(usize) -> Vec3 + Sync, impl Fn(usize) -> Vec3 + Sync),
    ) -> Vec<VertexStrain> {
        let longest = loading.solid.relaxation_time();
        let tractions = Tractions::new(loading);
        let at_present = tractions.factors(|curve| curve.at(t));
        let relaxed = self.relaxed_factors(loading, &tractions, t, false);
        let read = |(i, (vertex, fit)): (usize, (&Vertex, &GradientFit))| {
            let is_pushed = !pushed.is_empty() && cloud.rests_on(fit, pushed);
            let free = if is_pushed { Mat3::zeros() } else { vertex.free };
            let now = |f: &Mat3| tractions.at(vertex, &at_present, f);
            let (material, factor) = self.material(loading.solid, i);
            let relaxation_time = material.relaxation_time();
            let g = cloud.gradient(fit, &u);
            let rate =
                if longest > 0.0 { (cloud.gradient(fit, &effective) - g) / longest } else { Mat3::zeros() };
            let (beta, k) = relaxed_stress(i, material).unwrap_or((1.0, SymTensor::default()));
            let stiffness = match material.law() {
                Law::Linear(stiffness) => stiffness * (beta * factor),
                Law::FiniteStrain(law) => {
                    let turn = self.materials.get(i).and_then(|cell| cell.turns).map(|turns| turns[0]);
                    let law = Scaled { law, factor, turn };
                    let law = RelaxedLaw { law: &law, factor: beta, relaxed: k.to_matrix() };
                    // The area that a fit gives the surface stays, whatever changes across it.
                    let traction = now(&(Mat3::identity() + g));
                    let f = with_nominal_traction(&law, (&vertex.normal, &free), &g, &rate, &traction);
                    let (strain, stress) =
                        Law::FiniteStrain(&law).measures(relaxation_time, &(f - Mat3::identity()), &rate);
                    let turned = f.try_inverse().map(|inverse| inverse.transpose() * vertex.normal);
                    let normal = turned.map_or(vertex.normal, |n| n.normalize());
                    let local = LocalState { deformation: f, strain, stress, is_small_strain: false };
                    return VertexStrain { normal, local, material: self.number(i) };
                }
            };
            let gradient_of =
                |g: Mat3, traction: Vec3| with_traction(&stiffness, (&vertex.normal, &free), &g, &traction);
            let settled = self.left(i, t, relaxation_time)
                + tractions.at(vertex, &relaxed[self.number(i)], &Mat3::identity())
                + k.dot(&vertex.normal);
            let gradient = gradient_of(g, settled);
            let strain = SymTensor::symmetric_part(&gradient);
            let stress = if relaxation_time > 0.0 {
                let effective = gradient_of(g + rate * relaxation_time, now(&Mat3::identity()));
                stiffness.stress(SymTensor::symmetric_part(&effective))
            } else {
                stiffness.stress(strain) - k
            };
            let deformation = Mat3::identity() + gradient;
            let local = LocalState { deformation, strain, stress, is_small_strain: true };
            VertexStrain { normal: vertex.normal, local, material: self.number(i) }
        };
        self.vertices.par_iter().zip(fits).enumerate().map(read).collect()
    }

    /// Starts from the displacement u of the particles, which were deformed before they were loaded.
    pub fn start_from(
        &mut self,
        solid: &SolidSetup,
        (cloud, fits): (&Cloud<'_>, &[GradientFit]),
        u: impl Fn(usize) -> Vec3 + Sync,
    ) {
        let of = |(i, (vertex, fit)): (usize, (&Vertex, &GradientFit))| {
            let (material, factor) = self.material(solid, i);
            let strain = SymTensor::symmetric_part(&cloud.gradient(fit, &u));
            material.stiffness().stress(strain).dot(&vertex.normal) * factor
        };
        let traction = self.vertices.par_iter().zip(fits).enumerate().map(of).collect();
        self.settled = Settled { time: 0.0, traction };
    }

    /// Remembers C e n of this moment: the loads are about to change.
    pub fn settle(&mut self, loading: &Loading<'_>, t: f64, at_rest: bool) {
        let remembers =
            |m: &Arc<dyn Material>| m.relaxation_time() > 0.0 && m.law().finite_strain().is_none();
        if !loading.solid.materials().any(remembers) {
            return;
        }
        let tractions = Tractions::new(loading);
        let relaxed = self.relaxed_factors(loading, &tractions, t, at_rest);
        let each = |(i, vertex): (usize, &Vertex)| {
            let relaxation_time =
                if at_rest { 0.0 } else { self.material(loading.solid, i).0.relaxation_time() };
            self.left(i, t, relaxation_time)
                + tractions.at(vertex, &relaxed[self.number(i)], &Mat3::identity())
        };
        let traction = self.vertices.par_iter().enumerate().map(each).collect();
        self.settled = Settled { time: t, traction };
    }

    /// What a traction at factor 1 has made of C e n up to time `t`, from nothing at the settled time.
    fn relaxed_factor(&self, curve: &Curve, t: f64, relaxation: f64) -> f64 {
        if relaxation > 0.0 { curve.relaxed(self.settled.time, t, relaxation) } else { curve.at(t) }
    }

    /// What is left at time `t` of the settled C e n of vertex `i`.
    fn left(&self, i: usize, t: f64, relaxation: f64) -> Vec3 {
        let Settled { time, traction } = &self.settled;
        let factor = if relaxation > 0.0 { ((time - t) / relaxation).exp() } else { 0.0 };
        traction.get(i).copied().unwrap_or_default() * factor
    }
}

/// The loads on a surface at factor 1, with their curves.
struct Tractions<'a> {
    loads: Vec<(SurfaceTraction<'a>, &'a Curve)>,
    tolerance: f64,
}

impl<'a> Tractions<'a> {
    fn new(loading: &Loading<'a>) -> Self {
        let of = |load: &'a Load| (SurfaceTraction::new(&load.kind, loading.surface), &load.curve);
        Self { loads: loading.loads.iter().map(of).collect(), tolerance: TOLERANCE * loading.spacing }
    }

    /// What that makes of the curve of each.
    fn factors(&self, factor: impl Fn(&Curve) -> f64) -> Vec<f64> {
        self.loads.iter().map(|(_, curve)| factor(curve)).collect()
    }

    /// The sum of all at a vertex with the deformation gradient `f`, each times its factor.
    fn at(&self, vertex: &Vertex, factors: &[f64], f: &Mat3) -> Vec3 {
        let of = |((traction, _), factor): (&(SurfaceTraction<'_>, &Curve), &f64)| {
            traction.at(&vertex.x, &vertex.normal, f, self.tolerance) * *factor
        };
        self.loads.iter().zip(factors).map(of).sum()
    }
}

/// The displacement gradient `g`, changed across the surface with normal n so that its stress has the components of that
/// traction which `free` projects on.
fn with_traction(material: &Stiffness, (n, free): (&Vec3, &Mat3), g: &Mat3, traction: &Vec3) -> Mat3 {
    let fit = SymTensor::symmetric_part(g);
    let across = |a: Vec3| SymTensor::symmetric_part(&(a * n.transpose()));
    // Unit where the traction is not known, so that nothing changes there.
    let acoustic = Mat3::from_columns(&std::array::from_fn::<_, 3, _>(|i| {
        let a = free.column(i).into_owned();
        free * material.stress(across(a)).dot(n) + Vec3::ith(i, 1.0) - a
    }));
    let missing = free * (traction - material.stress(fit).dot(n));
    acoustic.try_inverse().map_or(*g, |inverse| g + inverse * missing * n.transpose())
}

/// Steps of Newton's method for the deformation gradient at a vertex, and the missing traction at which it is found.
const MAX_STEPS: usize = 12;
/// See [`MAX_STEPS`].
const FOUND: f64 = 1e-10;

/// F = 1 + `g` + a (x) n with P(F, `rate`) n equal to that traction in the components that `free` projects on.
fn with_nominal_traction(
    law: &dyn FiniteStrain,
    (n, free): (&Vec3, &Mat3),
    g: &Mat3,
    rate: &Mat3,
    traction: &Vec3,
) -> Mat3 {
    let fit = Mat3::identity() + g;
    let mut f = fit;
    let missing = |f: &Mat3| free * (traction - (law.first_piola(f) + law.viscous_piola(f, rate)) * n);
    let mut rest = missing(&f);
    let scale = law.tangent(&Mat3::identity(), &(n * n.transpose())).norm();
    for _ in 0..MAX_STEPS {
        if rest.norm() <= FOUND * scale {
            return f;
        }
        // Unit where the traction is not known, so that nothing changes there.
        let acoustic = Mat3::from_columns(&std::array::from_fn::<_, 3, _>(|i| {
            let a = free.column(i).into_owned();
            free * law.tangent(&f, &(a * n.transpose())) * n + Vec3::ith(i, 1.0) - a
        }));
        let Some(step) = acoustic.try_inverse().map(|inverse| inverse * rest) else { return fit };
        let mut length = 1.0;
        loop {
            let next = f + length * step * n.transpose();
            let left = missing(&next);
            if next.determinant() > 0.0 && left.norm() < rest.norm() {
                (f, rest) = (next, left);
                break;
            }
            length *= 0.5;
            if length < 1e-3 {
                return fit;
            }
        }
    }
    fit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{KelvinVoigt, NeoHookean};

    #[test]
    fn a_nominal_traction_is_met_at_large_strain_and_the_rest_stays() {
        let material = NeoHookean::new(1.0, 10.0, 0.45, 0.1).unwrap();
        let law = material.law().finite_strain().unwrap();
        let n = Vec3::new(1.0, -2.0, 0.5).normalize();
        let g = Mat3::new(0.1, -0.3, 0.2, 0.05, 0.2, -0.1, 0.4, 0.15, -0.25);
        let (t, flat) = (Vec3::new(0.3, -0.2, 1.0), Mat3::identity() - n * n.transpose());
        for rate in [Mat3::zeros(), g.transpose() * 0.3] {
            for free in [Mat3::identity(), flat, Mat3::zeros()] {
                let f = with_nominal_traction(law, (&n, &free), &g, &rate, &t);
                let piola = law.first_piola(&f) + law.viscous_piola(&f, &rate);
                assert!((free * (piola * n - t)).norm() < 1e-8);
                let changed = f - Mat3::identity() - g;
                assert!((changed * flat).amax() < 1e-12);
                assert!((changed - free * changed).amax() < 1e-12);
            }
        }
    }

    #[test]
    fn what_is_known_of_the_traction_is_met_and_the_rest_stays() {
        let material = KelvinVoigt::new(1.0, 10.0, 0.45, 0.0).unwrap();
        let n = Vec3::new(1.0, -2.0, 0.5).normalize();
        let g = Mat3::new(0.1, -0.3, 0.2, 0.05, 0.2, -0.1, 0.4, 0.15, -0.25);
        let t = Vec3::new(0.3, -0.2, 1.0);
        let flat = Mat3::identity() - n * n.transpose();
        let tilted = Mat3::identity() - Vec3::x() * Vec3::x().transpose();
        for free in [Mat3::identity(), flat, tilted, Mat3::zeros()] {
            let e = SymTensor::symmetric_part(&with_traction(&material.stiffness(), (&n, &free), &g, &t));
            assert!((free * (material.stiffness().stress(e).dot(&n) - t)).norm() < 1e-12);
            let changed = e.to_matrix() - SymTensor::symmetric_part(&g).to_matrix();
            assert!((flat * changed * flat).amax() < 1e-12);
            // What is held stays as the fit has it: the change is a (x) n with a free.
            let a = 2.0 * changed * n - n * n.dot(&(changed * n));
            assert!((a - free * a).norm() < 1e-12);
        }
    }
}
