//! Which material each particle holds, by where it was in the undeformed body.
//!
//! The gradient of a particle is a mean of the gradient along the lines to its neighbours, with the weights w |N . X|^2 across a
//! plane with the normal N. So near an interface it is the mean over a laminate in which each material has its share of those lines.

use crate::error::InvalidInput;
use crate::lattice::{Lattice, Neighbour};
use crate::material::{Composition, Interface};
use crate::setup::{ModulusField, SolidSetup};
use crate::tensor::{Mat3, Vec3};
use nalgebra::Rotation3;
use rayon::prelude::*;

/// Samples along the line to a neighbour.
const SAMPLES: usize = 10;
/// Share below which a material beside another is left out.
const LEAST_SHARE: f64 = 0.005;

/// What each of the particles at `positions` holds, whose neighbours are those of `lattice`; `None`: the same everywhere.
///
/// # Errors
/// A modulus that is not positive.
pub(super) fn compositions(
    solid: &SolidSetup,
    positions: &[Vec3],
    lattice: &Lattice,
) -> Result<Option<Vec<Composition>>, InvalidInput> {
    if !solid.is_by_place() {
        return Ok(None);
    }
    let cell = |x: &Vec3| composition(solid, x, &lattice.neighbours);
    let mut cells: Vec<Composition> = positions.par_iter().map(cell).collect();
    scale_moduli(solid, positions, &mut cells)?;
    turn_fibres(solid, positions, &mut cells)?;
    Ok(Some(cells))
}

/// The moduli of a field at some places.
fn moduli(field: &ModulusField, places: &[Vec3]) -> Result<Vec<f64>, InvalidInput> {
    let moduli = (field.0)(places);
    let bad = places.iter().zip(&moduli).find(|(_, modulus)| !(modulus.is_finite() && **modulus > 0.0));
    match bad {
        None if moduli.len() == places.len() => Ok(moduli),
        None => Err(InvalidInput::new(
            "material.modulus",
            format!("{} values", moduli.len()),
            format!("{} are wanted, one for each place", places.len()),
            "return an array with one number for each position",
        )),
        Some((x, modulus)) => Err(InvalidInput::new(
            "material.modulus",
            format!("{modulus} Pa at ({:.4}, {:.4}, {:.4})", x.x, x.y, x.z),
            "Young's modulus must be a positive number everywhere in the body",
            "fill the gaps of the map, or make it larger than the body",
        )),
    }
}

/// The material at each of some points; nothing if it is the same everywhere.
///
/// # Errors
/// A modulus that is not positive, a fibre without a direction.
pub(super) fn at_points(solid: &SolidSetup, places: &[Vec3]) -> Result<Vec<Composition>, InvalidInput> {
    if !solid.is_by_place() {
        return Ok(Vec::new());
    }
    let mut cells: Vec<Composition> =
        places.par_iter().map(|x| Composition::pure(material_at(solid, x), 1.0)).collect();
    scale_moduli(solid, places, &mut cells)?;
    turn_fibres(solid, places, &mut cells)?;
    Ok(cells)
}

/// Cells and numbers in them that are of material `k`.
fn holders(cells: &[Composition], k: usize) -> Vec<(usize, usize)> {
    (cells.iter().enumerate())
        .flat_map(|(a, cell)| [0, 1].map(|i| (a, i, cell.materials[i])))
        .filter_map(|(a, i, material)| (usize::from(material) == k).then_some((a, i)))
        .collect()
}

/// Turns materials in cells at `positions` so that their fibres go along the fields.
fn turn_fibres(
    solid: &SolidSetup,
    positions: &[Vec3],
    cells: &mut [Composition],
) -> Result<(), InvalidInput> {
    let fields = std::iter::once(&solid.fibres).chain(solid.parts.iter().map(|part| &part.fibres));
    for (k, (material, field)) in solid.materials().zip(fields).enumerate() {
        let Some(field) = field else { continue };
        let Some(fibre) = material.fibre() else {
            return Err(InvalidInput::new(
                "material.fibres",
                "",
                format!("the law \"{}\" has no fibres", material.name()),
                "take \"holzapfel-gasser-ogden\", or remove the field",
            ));
        };
        let holders = holders(cells, k);
        let places: Vec<Vec3> = holders.iter().map(|(a, _)| positions[*a]).collect();
        for ((a, i), (x, direction)) in holders.iter().zip(places.iter().zip(field.at_all(&places))) {
            let Some(unit) = direction.try_normalize(0.0).filter(|d| d.iter().all(|x| x.is_finite())) else {
                return Err(InvalidInput::new(
                    "material.fibres",
                    format!("{:?} at ({:.4}, {:.4}, {:.4})", direction.as_slice(), x.x, x.y, x.z),
                    "has no direction, and every place in the body needs one",
                    "move the place where the field vanishes out of the body",
                ));
            };
            // A fibre has no sign.
            let unit = if unit.dot(&fibre) < 0.0 { -unit } else { unit };
            if let Some(turn) = Rotation3::rotation_between(&fibre, &unit) {
                cells[*a].turns.get_or_insert([Mat3::identity(); 2])[*i] = *turn.matrix();
            }
        }
    }
    Ok(())
}

/// Sets the factors of cells at `positions` by the fields of moduli.
fn scale_moduli(
    solid: &SolidSetup,
    positions: &[Vec3],
    cells: &mut [Composition],
) -> Result<(), InvalidInput> {
    let fields = std::iter::once(&solid.modulus).chain(solid.parts.iter().map(|part| &part.modulus));
    for (k, (material, field)) in solid.materials().zip(fields).enumerate() {
        let Some(field) = field else { continue };
        let holders = holders(cells, k);
        let places: Vec<Vec3> = holders.iter().map(|(a, _)| positions[*a]).collect();
        for ((a, i), modulus) in holders.iter().zip(moduli(field, &places)?) {
            cells[*a].factors[*i] = modulus / material.young_modulus();
        }
    }
    Ok(())
}

/// Number of the material at a point: of the last part that it is in.
fn material_at(solid: &SolidSetup, x: &Vec3) -> u16 {
    let part = solid.parts.iter().rposition(|part| part.place.contains(x));
    part.map_or(0, |k| (k + 1) as u16)
}

/// Samples on the lines to neighbours in one material: their weight, and the mean of their offsets times that.
struct Found {
    material: u16,
    weight: f64,
    moment: Vec3,
}

/// What a particle at `x` with these neighbours holds.
fn composition(solid: &SolidSetup, x: &Vec3, neighbours: &[Neighbour]) -> Composition {
    let at = |offset: &Vec3| material_at(solid, &(x + offset));
    let own = at(&Vec3::zeros());
    if solid.parts.is_empty() || neighbours.iter().all(|n| at(&n.x) == own && at(&(0.5 * n.x)) == own) {
        return Composition::pure(own, 1.0);
    }
    let samples = (0..SAMPLES).map(|k| (k as f64 + 0.5) / SAMPLES as f64);
    // Every sample with its neighbour, the material there, and the offset.
    let samples: Vec<(&Neighbour, u16, Vec3)> = neighbours
        .iter()
        .flat_map(|n| samples.clone().map(move |part| (n, n.x * part)))
        .map(|(n, offset)| (n, at(&offset), offset))
        .collect();
    let mut found: Vec<Found> = Vec::new();
    for (n, material, offset) in &samples {
        let weight = n.w * n.x.norm_squared();
        let known = found.iter().position(|f| f.material == *material).unwrap_or_else(|| {
            found.push(Found { material: *material, weight: 0.0, moment: Vec3::zeros() });
            found.len() - 1
        });
        found[known].weight += weight;
        found[known].moment += offset * weight;
    }
    found.sort_by(|f, g| g.weight.total_cmp(&f.weight).then(f.material.cmp(&g.material)));
    let [first, second, ..] = &found[..] else { return Composition::pure(own, 1.0) };
    let across = second.moment / second.weight - first.moment / first.weight;
    let Some(normal) = across.try_normalize(f64::MIN_POSITIVE) else {
        return Composition::pure(own, 1.0);
    };
    // Their shares of the gradient along the normal.
    let share_of = |wanted: u16| -> f64 {
        let of = samples.iter().filter(|(_, material, _)| *material == wanted);
        of.map(|(n, ..)| n.w * n.x.dot(&normal).powi(2)).sum()
    };
    let [mut a, mut b] = [first.material, second.material].map(share_of);
    let (mut materials, mut normal) = ([first.material, second.material], normal);
    if b > a {
        ([a, b], materials, normal) = ([b, a], [materials[1], materials[0]], -normal);
    }
    let share = a / (a + b);
    if 1.0 - share < LEAST_SHARE {
        return Composition::pure(materials[0], 1.0);
    }
    let interface = Some(Interface { share, normal });
    Composition { materials, interface, ..Composition::pure(materials[0], 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::material::{KelvinVoigt, Material};
    use crate::region::Region;
    use crate::setup::MaterialPart;
    use std::sync::Arc;

    fn two(place: Region) -> SolidSetup {
        let of = |e| -> Arc<dyn Material> { Arc::new(KelvinVoigt::new(1.0, e, 0.3, 0.0).unwrap()) };
        let mut solid = SolidSetup::new(of(1.0));
        let part = MaterialPart {
            name: "stiff".into(),
            material: of(10.0),
            modulus: None,
            fibres: None,
            place: Arc::new(place),
        };
        solid.parts.push(part);
        solid
    }

    fn holds(solid: &SolidSetup, x: Vec3) -> Result<Composition, InvalidInput> {
        let grid = Grid { origin: x - Vec3::repeat(0.5), spacing: 1.0, cells: [1; 3] };
        let lattice = Lattice::new(&grid, &[[0; 3]], 0.8, 3);
        Ok(compositions(solid, &[x], &lattice)?.unwrap()[0])
    }

    #[test]
    fn near_a_plane_the_shares_are_those_of_the_gradient_of_a_ramp() {
        let normal = Vec3::new(1.0, -2.0, 0.5).normalize();
        let point = Vec3::repeat(0.1);
        let solid = two(Region::HalfSpace { point, normal });
        for distance in [-0.3, 0.1, 0.6] {
            let x = point + normal * distance;
            let cell = holds(&solid, x).unwrap();
            let grid = Grid { origin: x - Vec3::repeat(0.5), spacing: 1.0, cells: [1; 3] };
            let ramp = |offset: &Vec3| (distance + offset.dot(&normal)).min(0.0);
            let (mut sum, mut all) = (0.0, 0.0);
            for n in Lattice::new(&grid, &[[0; 3]], 0.8, 3).neighbours {
                sum += n.w * (ramp(&n.x) - ramp(&Vec3::zeros())) * n.x.dot(&normal);
                all += n.w * n.x.dot(&normal).powi(2);
            }
            let interface = cell.interface.unwrap();
            let (share, outward) = if cell.materials == [1, 0] {
                (interface.share, interface.normal)
            } else {
                (1.0 - interface.share, -interface.normal)
            };
            assert!(outward.dot(&normal) > 0.98, "{outward}");
            assert!((share - sum / all).abs() < 0.03, "{distance}: {share} {}", sum / all);
        }
        let far = holds(&solid, point - normal * 3.0).unwrap();
        assert_eq!(far, Composition::pure(1, 1.0));
    }

    #[test]
    fn moduli_of_a_field_are_factors_and_must_be_positive() {
        let mut solid = two(Region::Ball { centre: Vec3::zeros(), radius: 0.1 });
        solid.modulus = Some(ModulusField(Arc::new(|x| x.iter().map(|x| x.x).collect())));
        let found = holds(&solid, Vec3::x() * 3.0).unwrap();
        assert!(found.materials == [0, 0] && (found.factors[0] - 3.0).abs() < 1e-12);
        let error = holds(&solid, Vec3::x() * -3.0).unwrap_err();
        assert!(error.to_string().contains("positive"), "{error}");
    }
}
