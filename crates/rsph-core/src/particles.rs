//! Particles as a structure of arrays, and the table that describes their columns.
//!
//! Integrator, remesher, checkpoint, output and the bindings iterate over [`COLUMNS`]: a new field
//! is one entry of that table.

use crate::tensor::{SymTensor, Vec3};
use std::sync::Arc;

/// Names of the columns that a set of particles can carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Field {
    /// Reference position X of the particle: its place in the undeformed body.
    Reference,
    /// Displacement u = x - X.
    Displacement,
    /// Velocity v, Eq. (4).
    Velocity,
    /// Mass m.
    Mass,
    /// Volume V of the undeformed body that the particle stands for, of height one in the plane.
    Volume,
    /// Density rho, Eqs. (1), (11).
    Density,
    /// Strain e, Eqs. (7), (13).
    Strain,
    /// Stress sigma, Eq. (5).
    Stress,
    /// Signed distance to the surface, negative inside: the level set of Eq. (15).
    LevelSet,
    /// Von Mises' equivalent stress.
    VonMises,
    /// Colour c: 1 inside a body that moves as told, 0 outside of it, Eqs. (8), (17); 1 in a fluid beside
    /// a solid, the characteristic function of Eq. (19).
    Colour,
    /// Pressure p of a fluid that carries sound, or -tr sigma / 3 of a solid.
    Pressure,
    /// Deformation gradient F = dx/dX.
    DeformationGradient,
    /// Volume after and before, det F.
    VolumeRatio,
    /// Green's and Lagrange's strain E = (F^T F - 1)/2.
    GreenLagrangeStrain,
    /// Hencky's strain ln V.
    HenckyStrain,
    /// Principal stretches, eigenvalues of V.
    PrincipalStretch,
    /// Principal strains.
    PrincipalStrain,
    /// Direction of the largest principal strain.
    PrincipalDirection1,
    /// Direction of the middle principal strain.
    PrincipalDirection2,
    /// Direction of the smallest principal strain.
    PrincipalDirection3,
    /// Largest shear strain in any plane.
    MaxShearStrain,
    /// Principal stresses.
    PrincipalStress,
    /// Largest shear stress in any plane.
    MaxShearStress,
    /// First Piola-Kirchhoff stress P.
    FirstPiolaStress,
    /// Second Piola-Kirchhoff stress S.
    SecondPiolaStress,
    /// Number of the material that holds the larger share of the particle's cell, in a body of several.
    Material,
    /// Stress to which the first term of a Prony series has relaxed.
    RelaxedStress1,
    /// The same of the second term.
    RelaxedStress2,
    /// The same of the third term.
    RelaxedStress3,
    /// The same of the fourth term.
    RelaxedStress4,
    /// The same of the fifth term.
    RelaxedStress5,
    /// The same of the sixth term.
    RelaxedStress6,
}

/// How a column comes by its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evolution {
    /// Part of the state: advanced in time by the integrator or carried unchanged by the particle.
    State,
    /// Part of the state that results do not show.
    Internal,
    /// Recomputed from the state when a snapshot is taken.
    Derived,
}

/// What makes a column extensive: the weight under which remeshing conserves it, Eq. (17).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extensive {
    /// Conserved as it is (mass, volume).
    Itself,
    /// Conserved times mass (velocity: momentum).
    ByMass,
    /// Conserved times volume (strain, level set).
    ByVolume,
}

/// One row of the column table.
#[derive(Clone, Copy, Debug)]
pub struct ColumnSpec {
    /// Which column.
    pub field: Field,
    /// Name in files and Python.
    pub name: &'static str,
    /// 1 for a scalar, 3 for a vector or principal values, 6 for a symmetric tensor (XX YY ZZ XY YZ XZ), 9 for a matrix, row by row.
    pub components: usize,
    /// What the components are called; nothing for a scalar.
    pub suffixes: &'static [&'static str],
    /// State or derived.
    pub evolution: Evolution,
    /// Under which weight it is conserved.
    pub extensive: Extensive,
    /// SI unit.
    pub unit: &'static str,
}

/// The column table.
pub const COLUMNS: &[ColumnSpec] = &[
    column(Field::Reference, "reference", 3, Evolution::State, Extensive::ByMass, "m"),
    column(Field::Displacement, "displacement", 3, Evolution::State, Extensive::ByMass, "m"),
    column(Field::Velocity, "velocity", 3, Evolution::State, Extensive::ByMass, "m/s"),
    column(Field::Mass, "mass", 1, Evolution::State, Extensive::Itself, "kg"),
    column(Field::Volume, "volume", 1, Evolution::State, Extensive::Itself, "m^3"),
    column(Field::Density, "density", 1, Evolution::State, Extensive::ByVolume, "kg/m^3"),
    column(Field::Strain, "strain", 6, Evolution::State, Extensive::ByVolume, "1"),
    column(Field::Stress, "stress", 6, Evolution::Derived, Extensive::ByVolume, "Pa"),
    column(Field::LevelSet, "level_set", 1, Evolution::State, Extensive::ByVolume, "m"),
    column(Field::VonMises, "von_mises", 1, Evolution::Derived, Extensive::ByVolume, "Pa"),
    column(Field::Colour, "colour", 1, Evolution::State, Extensive::ByVolume, "1"),
    column(Field::Pressure, "pressure", 1, Evolution::State, Extensive::ByVolume, "Pa"),
    measure(Field::DeformationGradient, "deformation_gradient", &MATRIX, "1"),
    measure(Field::VolumeRatio, "volume_ratio", &[], "1"),
    measure(Field::GreenLagrangeStrain, "green_lagrange_strain", &TENSOR, "1"),
    measure(Field::HenckyStrain, "hencky_strain", &TENSOR, "1"),
    measure(Field::PrincipalStretch, "principal_stretch", &PRINCIPAL, "1"),
    measure(Field::PrincipalStrain, "principal_strain", &PRINCIPAL, "1"),
    measure(Field::PrincipalDirection1, "principal_direction_1", &VECTOR, "1"),
    measure(Field::PrincipalDirection2, "principal_direction_2", &VECTOR, "1"),
    measure(Field::PrincipalDirection3, "principal_direction_3", &VECTOR, "1"),
    measure(Field::MaxShearStrain, "max_shear_strain", &[], "1"),
    measure(Field::PrincipalStress, "principal_stress", &PRINCIPAL, "Pa"),
    measure(Field::MaxShearStress, "max_shear_stress", &[], "Pa"),
    measure(Field::FirstPiolaStress, "first_piola_stress", &MATRIX, "Pa"),
    measure(Field::SecondPiolaStress, "second_piola_stress", &TENSOR, "Pa"),
    column(Field::Material, "material", 1, Evolution::Derived, Extensive::ByVolume, "1"),
    column(Field::RelaxedStress1, "relaxed_stress_1", 6, Evolution::Internal, Extensive::ByVolume, "Pa"),
    column(Field::RelaxedStress2, "relaxed_stress_2", 6, Evolution::Internal, Extensive::ByVolume, "Pa"),
    column(Field::RelaxedStress3, "relaxed_stress_3", 6, Evolution::Internal, Extensive::ByVolume, "Pa"),
    column(Field::RelaxedStress4, "relaxed_stress_4", 6, Evolution::Internal, Extensive::ByVolume, "Pa"),
    column(Field::RelaxedStress5, "relaxed_stress_5", 6, Evolution::Internal, Extensive::ByVolume, "Pa"),
    column(Field::RelaxedStress6, "relaxed_stress_6", 6, Evolution::Internal, Extensive::ByVolume, "Pa"),
];

/// The stresses to which the terms of a Prony series have relaxed.
pub const RELAXED_STRESSES: [Field; 6] = [
    Field::RelaxedStress1,
    Field::RelaxedStress2,
    Field::RelaxedStress3,
    Field::RelaxedStress4,
    Field::RelaxedStress5,
    Field::RelaxedStress6,
];

/// What components are called: of vectors, ...
pub const VECTOR: [&str; 3] = ["x", "y", "z"];
/// ... of symmetric tensors, ...
pub const TENSOR: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "xz"];
/// ... of matrices, ...
pub const MATRIX: [&str; 9] = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"];
/// ... and principal values, the largest first.
pub const PRINCIPAL: [&str; 3] = ["1", "2", "3"];

/// What the components of a field with so many of them are called.
pub const fn suffixes(components: usize) -> &'static [&'static str] {
    match components {
        3 => &VECTOR,
        6 => &TENSOR,
        9 => &MATRIX,
        _ => &[],
    }
}

/// A column that is computed where it is asked for.
const fn measure(
    field: Field,
    name: &'static str,
    suffixes: &'static [&'static str],
    unit: &'static str,
) -> ColumnSpec {
    let components = if suffixes.is_empty() { 1 } else { suffixes.len() };
    let (evolution, extensive) = (Evolution::Derived, Extensive::ByVolume);
    ColumnSpec { field, name, components, suffixes, evolution, extensive, unit }
}

const fn column(
    field: Field,
    name: &'static str,
    components: usize,
    evolution: Evolution,
    extensive: Extensive,
    unit: &'static str,
) -> ColumnSpec {
    ColumnSpec { field, name, components, suffixes: suffixes(components), evolution, extensive, unit }
}

impl Field {
    /// The row of the column table.
    pub fn spec(self) -> &'static ColumnSpec {
        &COLUMNS[self as usize]
    }

    /// The field of that name in files and Python.
    pub fn from_name(name: &str) -> Option<Self> {
        shown_columns().find(|c| c.name == name).map(|c| c.field)
    }
}

/// The rows of the column table that results show.
pub fn shown_columns() -> impl Iterator<Item = &'static ColumnSpec> {
    COLUMNS.iter().filter(|c| c.evolution != Evolution::Internal)
}

/// One column: `components x len` values, component by component (structure of arrays), shared with
/// the snapshots taken of it and copied only when it is written while a snapshot still holds it.
#[derive(Clone, Debug)]
pub struct Column {
    data: Arc<Vec<f64>>,
    len: usize,
}

impl Column {
    /// A column of zeros.
    pub fn zeros(components: usize, len: usize) -> Self {
        Self { data: Arc::new(vec![0.0; components * len]), len }
    }

    /// A column from its values, component by component; `data.len()` is a multiple of `len`.
    pub fn from_vec(data: Vec<f64>, len: usize) -> Self {
        debug_assert!(len == 0 || data.len().is_multiple_of(len));
        Self { data: Arc::new(data), len }
    }

    /// A column of values that others hold as well.
    pub fn shared(data: Arc<Vec<f64>>, len: usize) -> Self {
        debug_assert!(len == 0 || data.len().is_multiple_of(len));
        Self { data, len }
    }

    /// A vector column from one vector a particle.
    pub fn from_vectors(v: &[Vec3]) -> Self {
        let n = v.len();
        let mut data = vec![0.0; 3 * n];
        for (a, x) in v.iter().enumerate() {
            for i in 0..3 {
                data[i * n + a] = x[i];
            }
        }
        Self::from_vec(data, n)
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of components.
    pub fn components(&self) -> usize {
        self.data.len().checked_div(self.len).unwrap_or(0)
    }

    /// All values, component by component.
    pub fn values(&self) -> &[f64] {
        &self.data
    }

    /// All values for writing; copies first if a snapshot still holds them.
    pub fn values_mut(&mut self) -> &mut [f64] {
        Arc::<Vec<f64>>::make_mut(&mut self.data)
    }

    /// The shared storage, for zero-copy views.
    pub fn share(&self) -> Arc<Vec<f64>> {
        Arc::clone(&self.data)
    }

    /// Component `i`, one value a particle.
    pub fn component(&self, i: usize) -> &[f64] {
        &self.data[i * self.len..(i + 1) * self.len]
    }

    /// The vector of particle `a` of a column of three components.
    #[inline(always)]
    pub fn vector(&self, a: usize) -> Vec3 {
        Vec3::new(self.data[a], self.data[self.len + a], self.data[2 * self.len + a])
    }

    /// Sets the vector of particle `a`.
    pub fn set_vector(&mut self, a: usize, v: &Vec3) {
        let n = self.len;
        let d = self.values_mut();
        for i in 0..3 {
            d[i * n + a] = v[i];
        }
    }

    /// The symmetric tensor of particle `a` of a column of six components.
    pub fn tensor(&self, a: usize) -> SymTensor {
        SymTensor(std::array::from_fn(|i| self.data[i * self.len + a]))
    }
}

/// A set of particles: one [`Column`] for every row of [`COLUMNS`] (empty when a dynamics has no use
/// for it).
#[derive(Clone, Debug)]
pub struct Particles {
    columns: Vec<Column>,
    len: usize,
}

impl Particles {
    /// `len` particles whose columns are all empty.
    pub fn new(len: usize) -> Self {
        Self { columns: COLUMNS.iter().map(|_| Column::zeros(0, 0)).collect(), len }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether the column is carried.
    pub fn has(&self, field: Field) -> bool {
        !self.columns[field as usize].is_empty()
    }

    /// A column; empty when it is not carried.
    pub fn column(&self, field: Field) -> &Column {
        &self.columns[field as usize]
    }

    /// A column for writing.
    pub fn column_mut(&mut self, field: Field) -> &mut Column {
        &mut self.columns[field as usize]
    }

    /// Replaces a column; its length is that of the set.
    ///
    /// # Panics
    /// When it has another length.
    pub fn set(&mut self, field: Field, column: Column) {
        assert_eq!(column.len(), self.len, "column {} has the wrong length", field.spec().name);
        self.columns[field as usize] = column;
    }
}
