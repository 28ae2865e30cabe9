//! What a scenario, the schema and Python need to know of a material model, and the models that there are.

use super::kelvin_voigt::positive;
use super::{KelvinVoigt, MAX_TERMS, Material, PRONY, PronyTerm, REGISTRY, Relaxing};
use crate::error::InvalidInput;
use std::fmt::Debug;
use std::sync::{Arc, PoisonError, RwLock};

/// What a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number.
    Number,
    /// A number; this one if it is left out.
    Default(f64),
    /// A number that may be left out.
    OptionalNumber,
    /// Three numbers.
    Vector,
    /// Three numbers that may be left out.
    OptionalVector,
    /// One to six numbers.
    List,
    /// One to six pairs of numbers, which may be left out.
    Pairs,
}

impl Kind {
    /// Fewest and most numbers.
    pub fn count(self) -> (usize, usize) {
        match self {
            Self::Number | Self::Default(_) => (1, 1),
            Self::OptionalNumber => (0, 1),
            Self::Vector => (3, 3),
            Self::OptionalVector => (0, 3),
            Self::List => (1, 6),
            Self::Pairs => (0, 2 * MAX_TERMS),
        }
    }

    /// Whether it is one number and not several in brackets.
    pub fn is_number(self) -> bool {
        self.count().1 == 1
    }
}

/// One parameter of a material model.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Key in scenario files.
    pub key: &'static str,
    /// Unit in SI.
    pub unit: &'static str,
    /// What it is.
    pub doc: &'static str,
    /// What it takes.
    pub kind: Kind,
}

impl Parameter {
    /// A number that must be given.
    pub const fn new(key: &'static str, unit: &'static str, doc: &'static str) -> Self {
        Self { key, unit, doc, kind: Kind::Number }
    }

    /// The same with a value if it is left out.
    #[must_use]
    pub const fn or(self, default: f64) -> Self {
        Self { kind: Kind::Default(default), ..self }
    }

    /// The same, which may be left out.
    #[must_use]
    pub const fn optional(self) -> Self {
        let kind = match self.kind {
            Kind::Vector | Kind::OptionalVector => Kind::OptionalVector,
            _ => Kind::OptionalNumber,
        };
        Self { kind, ..self }
    }

    /// The same of three numbers.
    #[must_use]
    pub const fn vector(self) -> Self {
        Self { kind: Kind::Vector, ..self }
    }

    /// The same of one to six numbers.
    #[must_use]
    pub const fn list(self) -> Self {
        Self { kind: Kind::List, ..self }
    }

    /// Its value if it is left out; `None`: it may not be.
    pub fn default(&self) -> Option<Vec<f64>> {
        match self.kind {
            Kind::Default(value) => Some(vec![value]),
            Kind::OptionalNumber | Kind::OptionalVector | Kind::Pairs => Some(Vec::new()),
            Kind::Number | Kind::Vector | Kind::List => None,
        }
    }
}

/// The values of a model's parameters, in their order.
#[derive(Clone, Debug)]
pub struct Values {
    parameters: &'static [Parameter],
    values: Vec<Vec<f64>>,
}

impl Values {
    /// The numbers of a parameter, none if it was left out.
    pub fn list(&self, key: &str) -> &[f64] {
        let place = self.parameters.iter().position(|p| p.key == key);
        place.and_then(|k| self.values.get(k)).map_or(&[], Vec::as_slice)
    }

    /// A number; NaN if it was left out.
    pub fn number(&self, key: &str) -> f64 {
        self.optional(key).unwrap_or(f64::NAN)
    }

    /// A number that may have been left out.
    pub fn optional(&self, key: &str) -> Option<f64> {
        self.list(key).first().copied()
    }

    /// The values of the parameters [`ISOTROPIC`].
    pub(super) fn isotropic(&self) -> [f64; 4] {
        ISOTROPIC.map(|p| self.number(p.key))
    }
}

/// Builds a material from the values of its parameters.
pub type Build = fn(&Values) -> Result<Arc<dyn Material>, InvalidInput>;

/// One row of the registry: what a scenario, the schema and Python need to know of a model.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Name in scenario files.
    pub name: &'static str,
    /// One line for `--help`, schema and docs.
    pub doc: &'static str,
    /// Parameters, in order.
    pub parameters: &'static [Parameter],
    /// Builds the material.
    pub build: Build,
}

impl Model {
    /// Its parameters and those of every model.
    pub fn all_parameters(&self) -> impl Iterator<Item = &'static Parameter> {
        self.parameters.iter().chain(std::iter::once(&PRONY))
    }

    /// The material of the values that `given` has for the keys of [`all_parameters`](Self::all_parameters).
    ///
    /// # Errors
    /// `material.<key>` of a parameter that is missing, has too few or too many numbers, or is out of range.
    pub fn make(&self, given: impl Fn(&str) -> Option<Vec<f64>>) -> Result<Arc<dyn Material>, InvalidInput> {
        let mut values = Vec::with_capacity(self.parameters.len());
        for p in self.parameters {
            let Some(numbers) = given(p.key).or_else(|| p.default()) else {
                let problem = format!("is missing: {} ({})", p.doc, p.unit);
                return Err(InvalidInput::new(format!("material.{}", p.key), "", problem, "give it a value"));
            };
            let (fewest, most) = p.kind.count();
            if !(fewest..=most).contains(&numbers.len()) {
                let wanted = if fewest == most { most.to_string() } else { format!("{fewest} to {most}") };
                return Err(InvalidInput::new(
                    format!("material.{}", p.key),
                    format!("{} numbers", numbers.len()),
                    format!("takes {wanted}: {} ({})", p.doc, p.unit),
                    "give as many numbers",
                ));
            }
            values.push(numbers);
        }
        let material = (self.build)(&Values { parameters: self.parameters, values })?;
        let Some(series) = given(PRONY.key).filter(|numbers| !numbers.is_empty()) else {
            return Ok(material);
        };
        let (pairs, rest) = series.as_chunks::<2>();
        if !rest.is_empty() {
            let problem = format!("takes pairs of numbers: {}", PRONY.doc);
            return Err(InvalidInput::new("material.prony", "", problem, "for example prony = [[0.5, 1.5]]"));
        }
        let terms = pairs.iter().map(|[share, time]| PronyTerm { share: *share, time: *time }).collect();
        Ok(Arc::new(Relaxing::new(material, terms)?))
    }
}

/// The parameters of an isotropic solid with Kelvin-Voigt damping.
pub(super) const ISOTROPIC: [Parameter; 4] = [
    Parameter::new("density", "kg/m^3", "density rho, undeformed"),
    Parameter::new("young_modulus", "Pa", "Young's modulus E, undeformed"),
    Parameter::new("poisson_ratio", "1", "Poisson's ratio nu, undeformed"),
    Parameter::new("relaxation_time", "s", "relaxation time T of the damping"),
];

/// What every law of tissue has besides its own: density, how the volume resists, damping.
pub(super) const TISSUE: [Parameter; 4] = [
    ISOTROPIC[0],
    Parameter::new("bulk_modulus", "Pa", "bulk modulus K; or else poisson_ratio").optional(),
    Parameter::new("poisson_ratio", "1", "Poisson's ratio nu at small strain; or else bulk_modulus")
        .optional(),
    ISOTROPIC[3].or(0.0),
];

/// The Kelvin-Voigt solid that a law is at small strain, from the values of [`TISSUE`] and the shear modulus there, of the parameter
/// `key`.
///
/// # Errors
/// Names the parameter that is out of range.
pub(super) fn tissue(
    values: &Values,
    (key, shear_modulus): (&str, f64),
) -> Result<KelvinVoigt, InvalidInput> {
    let [density, relaxation_time] = ["density", "relaxation_time"].map(|key| values.number(key));
    positive(key, shear_modulus, "it makes the shear modulus at small strain")?;
    match (values.optional("bulk_modulus"), values.optional("poisson_ratio")) {
        (Some(bulk_modulus), None) => {
            KelvinVoigt::of_moduli(density, shear_modulus, bulk_modulus, relaxation_time)
        }
        (None, Some(nu)) => KelvinVoigt::new(density, 2.0 * shear_modulus * (1.0 + nu), nu, relaxation_time),
        (None, None) => Err(InvalidInput::new(
            "material.poisson_ratio",
            "",
            "is missing: how the volume resists, as Poisson's ratio at small strain or as `bulk_modulus`",
            "for example poisson_ratio = 0.49",
        )),
        (Some(_), Some(_)) => Err(InvalidInput::new(
            "material.bulk_modulus",
            "",
            "and `poisson_ratio` exclude each other: each says how the volume resists",
            "remove one of the two",
        )),
    }
}

/// Models that were added to those of this crate.
static ADDED: RwLock<Vec<&'static Model>> = RwLock::new(Vec::new());

/// Adds a model of your own to those that scenarios know; one of the same name takes its place.
pub fn register(model: &'static Model) {
    ADDED.write().unwrap_or_else(PoisonError::into_inner).push(model);
}

/// All material models: those of this crate, then those of [`register`].
pub fn models() -> Vec<&'static Model> {
    let added = ADDED.read().unwrap_or_else(PoisonError::into_inner);
    let is_last = |k: usize| added[k + 1..].iter().all(|later| later.name != added[k].name);
    let own = REGISTRY.iter().filter(|m| added.iter().all(|a| a.name != m.name));
    own.chain((0..added.len()).filter(|k| is_last(*k)).map(|k| added[k])).collect()
}

/// The model of that name.
pub fn model(name: &str) -> Option<&'static Model> {
    models().into_iter().find(|m| m.name == name)
}
