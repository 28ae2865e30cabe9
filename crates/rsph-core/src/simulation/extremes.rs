//! How far a body is strained and turned, and whether its law is made for that.

use crate::grid::Bounds;
use crate::material::{Material, Range, rotation_of};
use crate::tensor::{Mat3, Vec3};
use rayon::prelude::*;

/// A displacement beyond this share of the body's diagonal is large.
const LARGE_DISPLACEMENT: f64 = 0.1;

/// Displacement gradients below this have no strain or turn that matters, and are passed over.
const NEGLIGIBLE: f64 = 0.04;

/// A largest value, and where in the undeformed body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extreme {
    /// The value.
    pub value: f64,
    /// Where.
    pub place: Vec3,
}

/// The largest strain, turn and displacement in a body; strains and turns below 4 % count as none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremes {
    /// Of a length, |l / L - 1|, in any direction.
    pub strain: Extreme,
    /// Of an angle (rad).
    pub turn: Extreme,
    /// Of a displacement, less that of the body as a whole.
    pub displacement: Extreme,
}

impl Extremes {
    /// Extremes over particles at `places` (m) of the undeformed body, with these displacements (m) and their gradients.
    pub(super) fn new(places: &[Vec3], displacements: &[Vec3], gradients: &[Mat3]) -> Self {
        let mean = displacements.iter().sum::<Vec3>() / displacements.len().max(1) as f64;
        let of = |a: usize| {
            let f = Mat3::identity() + gradients[a];
            let at = |value| Extreme { value, place: places[a] };
            let displacement = at((displacements[a] - mean).norm());
            if gradients[a].norm() < NEGLIGIBLE {
                return Self { displacement, ..Self::default() };
            }
            let squares = (f.transpose() * f).symmetric_eigenvalues();
            let strain = squares.map(|s| (s.max(0.0).sqrt() - 1.0).abs()).max();
            let cosine = rotation_of(&f).map_or(-1.0, |r| 0.5 * (r.trace() - 1.0));
            Self { strain: at(strain), turn: at(cosine.clamp(-1.0, 1.0).acos()), displacement }
        };
        let all: Vec<Self> = (0..places.len()).into_par_iter().map(of).collect();
        all.into_iter().fold(Self::default(), |sum, one| sum.with(&one))
    }

    /// The larger ones of both.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let larger = |a: Extreme, b: Extreme| if b.value > a.value { b } else { a };
        Self {
            strain: larger(self.strain, other.strain),
            turn: larger(self.turn, other.turn),
            displacement: larger(self.displacement, other.displacement),
        }
    }

    /// As twelve numbers.
    pub fn to_numbers(&self) -> [f64; 12] {
        let mut numbers = [0.0; 12];
        for (numbers, e) in numbers.chunks_mut(4).zip([self.strain, self.turn, self.displacement]) {
            numbers.copy_from_slice(&[e.value, e.place.x, e.place.y, e.place.z]);
        }
        numbers
    }

    /// From the numbers of [`Extremes::to_numbers`].
    pub fn from_numbers(numbers: &[f64; 12]) -> Self {
        let [strain, turn, displacement] = std::array::from_fn(|k| {
            let of = &numbers[4 * k..4 * k + 4];
            Extreme { value: of[0], place: Vec3::new(of[1], of[2], of[3]) }
        });
        Self { strain, turn, displacement }
    }

    /// What to know where they are beyond what the material of a body with these bounds is for.
    pub(super) fn note(&self, material: &dyn Material, bounds: &Bounds) -> Option<String> {
        let Range { strain, turn } = material.range();
        let size = bounds.size().norm();
        let at = |e: &Extreme| format!("({:.4}, {:.4}, {:.4})", e.place.x, e.place.y, e.place.z);
        let mut found = Vec::new();
        if self.strain.value > strain {
            found.push(format!("the body is strained by {:.2} at {}", self.strain.value, at(&self.strain)));
        }
        if self.turn.value > turn {
            let degrees = self.turn.value.to_degrees();
            found.push(format!("it turns by {degrees:.0} degrees at {}", at(&self.turn)));
        }
        if turn.is_finite() && self.displacement.value > LARGE_DISPLACEMENT * size {
            let share = 100.0 * self.displacement.value / size;
            found.push(format!("it moves by {share:.0} % of its size at {}", at(&self.displacement)));
        }
        if found.is_empty() {
            return None;
        }
        let for_turns = if turn.is_finite() {
            format!(" and turns up to {:.0} degrees", turn.to_degrees())
        } else {
            String::new()
        };
        Some(format!(
            "{}: the law \"{}\" is for strains up to {strain}{for_turns}, and beyond stress, strain and shape are wrong by about as \
             much; take model = \"neo-hookean\", with the same parameters, or another law for large strain",
            found.join(", "),
            material.name(),
        ))
    }
}
