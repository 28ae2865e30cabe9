//! Which law holds in which particle: one everywhere, or several by place.
//!
//! In a tile of one law vector registers evaluate it for all particles at once, whatever their moduli; a tile that holds several laws,
//! an interface or fibres that turn from place to place goes particle by particle.

use super::stress::Hooke;
use crate::material::{
    Composition, Law, Material, MaterialSet, PronyTerm, Stiffness, energy_beyond, second_piola,
};
use crate::tensor::lanes::Tensors;
use crate::tensor::{Mat3, SymTensor};
use crate::tiles::{LANES, Tile, Tiles};
use std::sync::Arc;

/// Numbers of a stiffness.
pub(super) const STIFFNESS: usize = 36;
/// Numbers of dP/dF.
pub(super) const TANGENT: usize = 81;

/// The materials of a body.
#[derive(Clone, Debug)]
pub(crate) struct Materials {
    set: MaterialSet,
    /// Whether all laws are linear and have the same relaxation time.
    linear: bool,
    /// The longest relaxation time (s).
    relaxation_time: f64,
    /// Young's modulus (Pa) of the first material.
    young_modulus: f64,
    places: Option<Box<Places>>,
}

/// Materials by place.
#[derive(Clone, Debug)]
pub(super) struct Places {
    cells: Vec<Composition>,
    kinds: Vec<Kind>,
    /// Stress of every material, if it is linear.
    hookes: Vec<Hooke>,
    /// Factor of the moduli of every particle, a tile for each tile.
    factor: Vec<Tile>,
    /// Young's modulus of every particle over that of the first material; beside an interface, where displacements have a kink
    /// that is no hourglass, that of the softer one.
    pub(super) modulus: Vec<Tile>,
    /// Stiffness of the particles of tiles of several laws, row by row.
    pub(super) stiffness: Vec<Tile>,
    /// Number of those tiles.
    pub(super) mixed: usize,
}

/// What a tile holds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// One law.
    Pure(u16),
    /// Several, an interface or fibres that turn: its number among such tiles.
    Mixed(u32),
}

impl Materials {
    /// One material everywhere.
    pub(super) fn uniform(material: Arc<dyn Material>) -> Self {
        Self::new(MaterialSet::new(std::iter::once(material)))
    }

    fn new(set: MaterialSet) -> Self {
        let relaxation_time = set.materials().map(|m| m.relaxation_time()).fold(0.0, f64::max);
        let is_linear = |m: &Arc<dyn Material>| {
            matches!(m.law(), Law::Linear(_)) && m.relaxation_time().to_bits() == relaxation_time.to_bits()
        };
        let linear = set.materials().all(is_linear);
        let young_modulus = set.materials().next().map_or(0.0, |m| m.young_modulus());
        Self { linear, relaxation_time, young_modulus, set, places: None }
    }

    /// Those `materials`, of which every particle has its cell.
    pub(super) fn by_place(
        materials: impl Iterator<Item = Arc<dyn Material>>,
        cells: Vec<Composition>,
        tiles: &Tiles,
    ) -> Self {
        let mut new = Self::new(MaterialSet::new(materials));
        let mut places = Places {
            hookes: (0..new.set.len() as u16).map(|m| Hooke::new(new.set.stiffness_of(m))).collect(),
            kinds: Vec::with_capacity(tiles.len()),
            factor: tiles.field(1),
            modulus: tiles.field(1),
            stiffness: Vec::new(),
            mixed: 0,
            cells,
        };
        for t in 0..tiles.len() {
            let here = (0..LANES).filter_map(|l| tiles.particle(t, l).map(|a| (l, &places.cells[a])));
            let here: Vec<(usize, &Composition)> = here.collect();
            let first = here.first().map_or(0, |(_, cell)| cell.materials[0]);
            let is_pure = here.iter().all(|(_, cell)| cell.is_plain() && cell.materials[0] == first);
            for (l, cell) in &here {
                let stiffness = new.set.stiffness(cell);
                places.factor[t].0[*l] = cell.factors[0];
                places.modulus[t].0[*l] = new.set.softest(cell) / new.young_modulus;
                if !is_pure {
                    places.stiffness.resize((places.mixed + 1) * STIFFNESS, Tile::default());
                    for (k, c) in stiffness.0.as_flattened().iter().enumerate() {
                        places.stiffness[places.mixed * STIFFNESS + k].0[*l] = *c;
                    }
                }
            }
            places.kinds.push(if is_pure { Kind::Pure(first) } else { Kind::Mixed(places.mixed as u32) });
            places.mixed += usize::from(!is_pure);
        }
        new.places = Some(Box::new(places));
        new
    }

    /// The same in the images that particles have on a lattice with these tiles.
    pub(super) fn on(self, tiles: &Tiles) -> Self {
        match self.places {
            None => self,
            Some(places) => Self::by_place(self.set.materials().cloned(), places.cells, tiles),
        }
    }

    /// With another material in the place of number `k`.
    pub(super) fn with_material(&self, k: usize, material: &Arc<dyn Material>, tiles: &Tiles) -> Self {
        let others = self.set.materials().enumerate();
        let materials = others.map(|(i, other)| Arc::clone(if i == k { material } else { other }));
        match &self.places {
            None => Self::new(MaterialSet::new(materials)),
            Some(places) => Self::by_place(materials, places.cells.clone(), tiles),
        }
    }

    /// Whether there is more than one material.
    pub(super) fn is_several(&self) -> bool {
        self.set.len() > 1
    }

    pub(crate) fn is_linear(&self) -> bool {
        self.linear
    }

    pub(crate) fn relaxation_time(&self) -> f64 {
        self.relaxation_time
    }

    /// Young's modulus (Pa) of the first material.
    pub(crate) fn young_modulus(&self) -> f64 {
        self.young_modulus
    }

    /// Young's modulus (Pa) of a particle.
    pub(crate) fn young_modulus_of(&self, (tile, lane): (usize, usize)) -> f64 {
        self.young_modulus * self.modulus(tile, lane)
    }

    /// Young's modulus of a particle over that of the first material.
    pub(super) fn modulus(&self, tile: usize, lane: usize) -> f64 {
        self.places.as_ref().map_or(1.0, |places| places.modulus[tile].0[lane])
    }

    /// The largest ratio of the moduli of pressure and shear waves, (lambda + 2 mu) / mu, of any material.
    pub(crate) fn largest_ratio_of_moduli(&self) -> f64 {
        let of = |m: &Arc<dyn Material>| m.p_wave_modulus() / m.shear_modulus();
        self.set.materials().map(of).fold(0.0, f64::max)
    }

    /// Stiffness of the first material.
    pub(crate) fn first_stiffness(&self) -> &Stiffness {
        self.set.stiffness_of(0)
    }

    pub(super) fn places(&self) -> Option<&Places> {
        self.places.as_deref()
    }

    /// The cell of a particle.
    pub(super) fn cell(&self, particle: usize) -> Composition {
        self.places.as_ref().map_or(Composition::pure(0, 1.0), |places| places.cells[particle])
    }

    /// Density (kg/m^3) of a particle.
    pub(super) fn density(&self, particle: usize) -> f64 {
        self.set.density(&self.cell(particle))
    }

    /// Whether the material that holds the larger share of a particle is for small strain.
    pub(super) fn is_small_strain(&self, particle: usize) -> bool {
        matches!(self.set.material(self.cell(particle).materials[0]).law(), Law::Linear(_))
    }

    /// C : e of a particle, with its stiffness C in the undeformed state.
    pub(super) fn hooke(&self, particle: usize, strain: SymTensor) -> SymTensor {
        match &self.places {
            None => self.first_stiffness().stress(strain),
            Some(places) => self.set.hooke(&places.cells[particle], strain),
        }
    }

    /// Energy per undeformed volume (J/m^3) of a spring of a particle's law that is stretched by this displacement gradient from where it
    /// has the stress A = `relaxed`.
    pub(super) fn energy_beyond(&self, particle: usize, gradient: &Mat3, relaxed: SymTensor) -> f64 {
        let cell = self.cell(particle);
        let from_stiffness = |stress: SymTensor| {
            let left = stress - relaxed;
            0.5 * left.double_dot(self.set.stiffness(&cell).strain(left))
        };
        if self.linear {
            return from_stiffness(self.hooke(particle, SymTensor::symmetric_part(gradient)));
        }
        let f = Mat3::identity() + gradient;
        self.set.with_law(&cell, |law| {
            energy_beyond(law, &f, &relaxed.to_matrix())
                .unwrap_or_else(|| from_stiffness(second_piola(law, &f).unwrap_or_default()))
        })
    }

    /// Prony series of the material that holds the larger share of a particle.
    pub(super) fn prony_terms(&self, particle: usize) -> &[PronyTerm] {
        self.set.material(self.number(particle) as u16).prony()
    }

    /// Number of the material that holds the larger share of a particle.
    pub(super) fn number(&self, particle: usize) -> usize {
        self.places.as_ref().map_or(0, |places| usize::from(places.cells[particle].materials[0]))
    }

    /// Prony series of all materials.
    pub(super) fn all_prony_terms(&self) -> impl Iterator<Item = &[PronyTerm]> {
        self.set.materials().map(|material| material.prony())
    }

    /// Terms of the longest Prony series.
    pub(super) fn most_prony_terms(&self) -> usize {
        self.all_prony_terms().map(<[PronyTerm]>::len).max().unwrap_or(0)
    }

    /// Energy per undeformed volume (J/m^3) of a particle at this displacement gradient; infinite where it is turned inside out.
    pub(super) fn energy_density(&self, particle: usize, gradient: &Mat3) -> f64 {
        if self.linear {
            let strain = SymTensor::symmetric_part(gradient);
            return 0.5 * self.hooke(particle, strain).double_dot(strain);
        }
        let f = Mat3::identity() + gradient;
        match &self.places {
            None => self.set.law(0).energy(&f),
            Some(places) => self.set.with_law(&places.cells[particle], |law| law.energy(&f)),
        }
    }

    /// Change of P of a particle at F with dF.
    pub(super) fn tangent(&self, particle: usize, f: &Mat3, df: &Mat3) -> Mat3 {
        self.set.with_law(&self.cell(particle), |law| law.tangent(f, df))
    }

    /// The displacement gradient in the material that holds the larger share of a particle.
    pub(super) fn larger_layer(&self, particle: usize, gradient: &Mat3) -> Mat3 {
        self.set.larger_layer(&self.cell(particle), gradient)
    }

    /// Strain and Cauchy stress (Pa) of a particle as results show them.
    pub(super) fn measures(&self, particle: usize, gradient: &Mat3, rate: &Mat3) -> [SymTensor; 2] {
        self.set.measures(&self.cell(particle), gradient, rate)
    }

    /// P(F, dF/dt) of the first `count` particles from `lane` on of a tile.
    pub(super) fn stresses(
        &self,
        (tiles, tile, lane): (&Tiles, usize, usize),
        count: usize,
        f: &Tensors,
        f_rate: Option<&Tensors>,
        piola: &mut Tensors,
    ) {
        let Some(places) = &self.places else {
            return self.set.law(0).stresses(count, f, f_rate, piola);
        };
        match places.kinds[tile] {
            Kind::Pure(material) => {
                self.set.law(material).stresses(count, f, f_rate, piola);
                places.scale(tile, lane, count, piola);
            }
            Kind::Mixed(_) => {
                for l in 0..count {
                    let Some(a) = tiles.particle(tile, lane + l) else { continue };
                    let f = f.get(l);
                    let stress = self.set.with_law(&places.cells[a], |law| {
                        let viscous = f_rate.map(|rate| law.viscous_piola(&f, &rate.get(l)));
                        law.first_piola(&f) + viscous.unwrap_or_default()
                    });
                    piola.set(l, &stress);
                }
            }
        }
    }

    /// Change of P when F changes by `df` times the first of `shares` and dF/dt by `df` times the second, of the first `count`
    /// particles from `lane` on of a tile; `mixed` are dP/dF of the particles of tiles of several laws.
    pub(super) fn tangents(
        &self,
        (tiles, tile, lane): (&Tiles, usize, usize),
        count: usize,
        [f, df]: [&Tensors; 2],
        shares: [f64; 2],
        mixed: &[Tile],
        change: &mut Tensors,
    ) {
        let Some(places) = &self.places else {
            return self.set.law(0).tangents(count, f, df, shares, change);
        };
        match places.kinds[tile] {
            Kind::Pure(material) => {
                self.set.law(material).tangents(count, f, df, shares, change);
                places.scale(tile, lane, count, change);
            }
            Kind::Mixed(number) => {
                let matrix = &mixed[number as usize * TANGENT..][..TANGENT];
                for l in 0..count {
                    let Some(a) = tiles.particle(tile, lane + l) else { continue };
                    let mut dp = Mat3::zeros();
                    for c in 0..9 {
                        let terms = (0..9).map(|d| matrix[9 * d + c].0[lane + l] * df.0[d][l]);
                        dp[(c / 3, c % 3)] = shares[0] * terms.sum::<f64>();
                    }
                    if shares[1] > 0.0 {
                        let (f, rate) = (f.get(l), df.get(l));
                        let viscous = self.set.with_law(&places.cells[a], |law| law.viscous_piola(&f, &rate));
                        dp += viscous * shares[1];
                    }
                    change.set(l, &dp);
                }
            }
        }
    }

    /// dP/dF of the particles of tiles of several laws at the F that `state` gives, for [`Materials::tangents`].
    pub(super) fn mixed_tangents(&self, tiles: &Tiles, state: impl Fn((usize, usize)) -> Mat3) -> Vec<Tile> {
        let Some(places) = &self.places else { return Vec::new() };
        let mut mixed = vec![Tile::default(); places.mixed * TANGENT];
        for (t, kind) in places.kinds.iter().enumerate() {
            let Kind::Mixed(number) = kind else { continue };
            for l in 0..LANES {
                let Some(a) = tiles.particle(t, l) else { continue };
                let columns = self.set.tangents(&places.cells[a], &state((t, l)));
                for (d, column) in columns.iter().enumerate() {
                    for c in 0..9 {
                        mixed[*number as usize * TANGENT + 9 * d + c].0[l] = column[(c / 3, c % 3)];
                    }
                }
            }
        }
        mixed
    }
}

impl Places {
    /// What a tile holds.
    #[inline(always)]
    pub(super) fn kind(&self, tile: usize) -> Kind {
        self.kinds[tile]
    }

    /// C : e of a material.
    #[inline(always)]
    pub(super) fn hooke(&self, material: u16) -> &Hooke {
        &self.hookes[usize::from(material)]
    }

    /// Factors of the moduli in a tile.
    #[inline(always)]
    pub(super) fn factor(&self, tile: usize) -> &Tile {
        &self.factor[tile]
    }

    /// Multiplies tensors of the first `count` particles from `lane` on of a tile by the factors of their moduli.
    #[inline(always)]
    fn scale(&self, tile: usize, lane: usize, count: usize, tensors: &mut Tensors) {
        for component in &mut tensors.0 {
            for (x, factor) in component.iter_mut().zip(&self.factor[tile].0[lane..lane + count]) {
                *x *= factor;
            }
        }
    }
}
