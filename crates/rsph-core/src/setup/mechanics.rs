//! What moves the particles, and remeshing.

use super::{Boundary, Foundation, InteractionSetting, Load, MaterialPart, ModulusField};
use crate::flow::Flow;
use crate::kernel::RemeshKernel;
use crate::material::Material;
use crate::vector_field::VectorField;
use std::sync::Arc;

/// What moves the particles.
#[derive(Clone, Debug)]
pub enum Mechanics {
    /// A solid: stresses, loads and clamps.
    Solid(SolidSetup),
    /// A given velocity field, section 3 of the paper.
    Prescribed(Prescription),
    /// A fluid beside a solid on a line, section 4 of the paper.
    Interaction(InteractionSetting),
}

/// What only a solid has.
#[derive(Clone, Debug)]
pub struct SolidSetup {
    /// Of what, where no part says otherwise.
    pub material: Arc<dyn Material>,
    /// Its name in results of a body of several materials.
    pub material_name: String,
    /// Its modulus where that differs from place to place.
    pub modulus: Option<ModulusField>,
    /// Direction of its fibres where that differs from place to place; of any length but zero.
    pub fibres: Option<VectorField>,
    /// Other materials by place; each lies over those before it.
    pub parts: Vec<MaterialPart>,
    /// What is held.
    pub boundaries: Vec<Boundary>,
    /// What pushes.
    pub loads: Vec<Load>,
    /// What it rests on.
    pub foundations: Vec<Foundation>,
}

impl SolidSetup {
    /// A free body.
    pub fn new(material: Arc<dyn Material>) -> Self {
        let material_name = material.name().to_owned();
        let (parts, boundaries, loads, foundations) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { material, material_name, modulus: None, fibres: None, parts, boundaries, loads, foundations }
    }

    /// All materials, that of the rest of the body first.
    pub fn materials(&self) -> impl Iterator<Item = &Arc<dyn Material>> {
        std::iter::once(&self.material).chain(self.parts.iter().map(|part| &part.material))
    }

    /// Names of [`materials`](Self::materials).
    pub fn material_names(&self) -> impl Iterator<Item = &str> {
        std::iter::once(&*self.material_name).chain(self.parts.iter().map(|part| &*part.name))
    }

    /// The longest relaxation time of its materials (s).
    pub fn relaxation_time(&self) -> f64 {
        self.materials().map(|m| m.relaxation_time()).fold(0.0, f64::max)
    }

    /// Puts a material in the place of number `k` of [`materials`](Self::materials).
    pub fn set_material(&mut self, k: usize, material: &Arc<dyn Material>) {
        if k == 0 {
            self.material = Arc::clone(material);
        } else if let Some(part) = self.parts.get_mut(k - 1) {
            part.material = Arc::clone(material);
        }
    }

    /// The fields of modulus and fibres of number `k` of [`materials`](Self::materials).
    pub fn fields_mut(&mut self, k: usize) -> Option<(&mut Option<ModulusField>, &mut Option<VectorField>)> {
        if k == 0 {
            return Some((&mut self.modulus, &mut self.fibres));
        }
        self.parts.get_mut(k - 1).map(|part| (&mut part.modulus, &mut part.fibres))
    }

    /// Whether material differs from place to place.
    pub fn is_by_place(&self) -> bool {
        self.modulus.is_some() || self.fibres.is_some() || !self.parts.is_empty()
    }

    /// The next moment after time `t` that a time step of about `dt` should not pass over, for what loads and motions do
    /// there.
    pub fn moment_after(&self, t: f64, dt: f64) -> Option<f64> {
        let of_loads = self.loads.iter().filter_map(|load| load.curve.moment_after(t, dt));
        let motions = self.boundaries.iter().filter_map(|boundary| boundary.motion.as_ref());
        let of_motions = motions.filter_map(|motion| motion.moment_after(t, dt));
        of_loads.chain(of_motions).min_by(f64::total_cmp)
    }
}

/// A body whose particles carry a colour (1 inside, 0 outside) along a given velocity field.
#[derive(Clone, Debug)]
pub struct Prescription {
    /// Density (kg/m^3).
    pub density: f64,
    /// What the particles follow.
    pub flow: Flow,
    /// Half width, in spacings, of the band in which the colour falls from 1 to 0 across the surface
    /// of the undeformed body; 0: it jumps.
    pub band: f64,
    /// Value of C(x), Eq. (8), that makes the surface; between 0 and 1.
    pub iso: f64,
}

/// When particles are remeshed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RemeshTrigger {
    /// Never.
    #[default]
    Never,
    /// Every so many steps, at least 1.
    Steps(u64),
    /// At the first step that ends this much time, or more, after the last remeshing.
    Interval(f64),
    /// When a stretch since the last remeshing, or under a linear law the displacement gradient, has changed by more than
    /// [`STRAIN`] anywhere.
    Strain,
}

/// Strain after which particles are remeshed by [`RemeshTrigger::Strain`].
pub const STRAIN: f64 = 0.25;

/// Remeshing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remesh {
    /// When.
    pub trigger: RemeshTrigger,
    /// With which kernel.
    pub kernel: RemeshKernel,
    /// Whether the level set of a solid becomes the distance from its present surface at each remeshing;
    /// else it stays what it was on the material.
    pub restore_level_set: bool,
}
