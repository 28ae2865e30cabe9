//! Folds: held faces that lie between two layers of cells, beyond which the particles have mirror images.
//!
//! The image of a field z is S z + (1 - S) z_D, S = -1 in the components that are held and 1 in the others. Rows at the face
//! see images as they see particles, so that they have a full neighbourhood. Images are linear in the field, and the force
//! on an image goes to its particle by S and to the face by 1 - S: it stays the derivative of the energy.

mod reaction;

pub use reaction::ImageSums;

use super::constraints::{Constraints, HeldPlane, projectors};
use crate::lattice::{Lattice, MIRROR_SETS, Mirror, has_mirror, reflection};
use crate::mesh::TriangleMesh;
use crate::tensor::{Mat3, Vec3};
use crate::tiles::Tile;
use rayon::prelude::*;
use std::ops::Range;

/// Distance from a plane between two layers of cells, in spacings, within which a face lies on it.
const ON_PLANE: f64 = 1e-6;
/// Cosine of the angle with the normal of the face below which other parts of the surface next to it are steep enough not to
/// meet their own images.
const STEEP: f64 = 0.75;
/// Farthest that weights of the surface reach, in spacings.
const SUPPORT: f64 = 5.0;

/// Most folds of a body: one below and one above on every axis.
const MAX_FOLDS: usize = 6;
/// Links that one partial sum covers: fixed, so that sums do not depend on the thread count.
const LINKS_PER_SUM: usize = 512;

/// A held face with its mirror.
#[derive(Clone, Copy, Debug)]
struct Fold {
    /// The boundaries that hold it, a bit each.
    boundaries: u32,
    /// The boundary that decides each component; the normal one is held.
    owners: [Option<usize>; 3],
    mirror: Mirror,
    /// Coordinate of the plane along its normal.
    at: f64,
}

/// The image of a particle, with the springs of the hourglass term between it and what sees it.
#[derive(Clone, Copy, Debug)]
struct Link {
    particle: u32,
    /// A set.
    mirrors: u8,
    /// Tile and lane of the image.
    place: (u32, u8),
    volume: f64,
    /// V_b sum V_a w over the particles a that see it.
    springs: f64,
}

/// How images follow their particles, by sets of mirrors.
#[derive(Clone, Debug)]
pub struct Following {
    /// Diagonal of S.
    pub signs: [Vec3; MIRROR_SETS],
    /// (1 - S) z_D.
    pub offsets: [Vec3; MIRROR_SETS],
}

impl Following {
    /// The image of a vector in that set of mirrors.
    pub fn image(&self, mirrors: u8, z: &Vec3) -> Vec3 {
        self.signs[mirrors as usize].component_mul(z) + self.offsets[mirrors as usize]
    }

    /// Images that are reflections, as those of vectors in a mirror.
    pub fn mirrored() -> Self {
        let signs = std::array::from_fn(|set| reflection(set as u8));
        Self { signs, offsets: [Vec3::zeros(); MIRROR_SETS] }
    }
}

/// Particles with their images behind them.
#[derive(Clone, Debug)]
pub struct Doubled {
    /// Places (m) of the particles, then of the images.
    pub positions: Vec<Vec3>,
    /// Volumes (m^3), in the same order.
    pub volume: Vec<f64>,
    /// Particle and set of mirrors of every image.
    pub images: Vec<(u32, u8)>,
    /// Diagonal of S, by sets of mirrors.
    pub signs: [Vec3; MIRROR_SETS],
}

/// All folds of a body.
#[derive(Clone, Debug)]
pub struct Folds {
    faces: Vec<Fold>,
    /// How images follow their particles.
    pub following: Following,
    /// By particle.
    links: Vec<Link>,
    /// Places on the faces beside a particle, and the areas there.
    places: Vec<(u32, usize, Vec3, f64)>,
    /// The fold that decides each component of images, by sets of mirrors, where S = -1.
    deciding: [[Option<usize>; 3]; MIRROR_SETS],
    /// Sums over some links each.
    partial: Vec<Pull>,
    /// Of the springs, in units of kappa.
    springs: Pull,
    /// On the body, of each fold.
    force: [Vec3; MAX_FOLDS],
    /// (1 - S) z_D of the displacement at the last remesh, by sets of mirrors.
    at_remesh: [Vec3; MIRROR_SETS],
}

/// Sums over links: a vector for each fold, and an energy.
type Pull = ([Vec3; MAX_FOLDS], f64);

impl Default for Folds {
    fn default() -> Self {
        Self {
            faces: Vec::new(),
            following: Following {
                signs: [Vec3::repeat(1.0); MIRROR_SETS],
                offsets: [Vec3::zeros(); MIRROR_SETS],
            },
            links: Vec::new(),
            places: Vec::new(),
            deciding: [[None; 3]; MIRROR_SETS],
            partial: Vec::new(),
            springs: Pull::default(),
            force: [Vec3::zeros(); MAX_FOLDS],
            at_remesh: [Vec3::zeros(); MIRROR_SETS],
        }
    }
}

/// The fold on a plane that a boundary holds, if its face of `surface` lies between two layers of cells, is held alike
/// everywhere, and neither particles nor other parts of the surface nor gaps are in its way.
fn fold(
    plane: &HeldPlane,
    constraints: &Constraints,
    surface: &TriangleMesh,
    lattice: &Lattice,
) -> Option<Fold> {
    let (normal, spacing) = (plane.normal, lattice.spacing);
    let axis = normal.iamax();
    let above = normal[axis] > 0.0;
    let depth = |x: &Vec3| -plane.beyond(x) / spacing;
    let nearest = surface.vertices.iter().map(depth).fold(f64::INFINITY, f64::min);
    let at = plane.point[axis] - nearest * spacing * normal[axis];
    let layer = (at - lattice.origin[axis]) / spacing;
    if normal[axis].abs() < 1.0 - ON_PLANE * ON_PLANE || (layer - layer.round()).abs() > ON_PLANE {
        return None;
    }
    let mirror = Mirror { axis, above, layer: layer.round() as isize };
    let reach = lattice.weights.cut.isqrt();
    // What holds the face at the cells beside it.
    let mut boundaries = None;
    for a in 0..lattice.len() {
        let layers = lattice.coordinates(a)[axis] as isize - mirror.layer;
        let deep = if above { -layers } else { layers + 1 };
        if (layers >= 0) == above || (deep <= 2 * reach as isize && lattice.cuts.has(a)) {
            return None;
        }
        if layers == -isize::from(above) {
            let mut x = lattice.position(a);
            x[axis] = at;
            let here = constraints.held_at(&x, &normal)?;
            if *boundaries.get_or_insert(here) != here {
                return None;
            }
        }
    }
    let boundaries = boundaries?;
    let mut owners = [None; 3];
    for (i, projector) in projectors(&constraints.holds, boundaries, &normal) {
        for k in 0..3 {
            if projector[(k, k)] > 0.5 {
                owners[k] = Some(i);
            }
        }
    }
    let fits = |t: usize| {
        let is_flat = |x: &Vec3| (depth(x) - nearest).abs() < ON_PLANE;
        let mut corners = surface.corners(t).into_iter();
        if constraints.held_at(&surface.centroid(t), &surface.normal(t)).unwrap_or(0) & boundaries != 0 {
            return corners.all(|x| is_flat(&x));
        }
        surface.normal(t).dot(&normal) < STEEP || corners.all(|x| depth(&x) > reach as f64)
    };
    let is_fold = owners[axis].is_some() && (0..surface.triangles.len()).all(fits);
    is_fold.then_some(Fold { boundaries, owners, mirror, at })
}

impl Folds {
    /// The folds among the faces of `surface` that `constraints` hold, of a body with its particles on `lattice`; if it has been
    /// remeshed, only those that stay in their plane.
    pub fn new(constraints: &Constraints, surface: &TriangleMesh, lattice: &Lattice, remeshed: bool) -> Self {
        let reach = lattice.weights.cut.isqrt();
        let mut this = Self::default();
        let motion = |i: Option<usize>| i.and_then(|i| constraints.holds[i].motion.as_ref());
        for plane in constraints.planes() {
            let Some(fold) = fold(plane, constraints, surface, lattice) else { continue };
            // Images in two mirrors must not depend on their order.
            let agree = |other: &Fold| {
                if other.mirror.axis == fold.mirror.axis {
                    return other.mirror.layer.abs_diff(fold.mirror.layer) >= reach;
                }
                let both = |k: &usize| other.owners[*k].is_some() && fold.owners[*k].is_some();
                (0..3).filter(both).all(|k| motion(other.owners[k]) == motion(fold.owners[k]))
            };
            let leaves =
                motion(fold.owners[fold.mirror.axis]).is_some_and(|m| m.moves_along(fold.mirror.axis));
            if !(remeshed && leaves) && this.faces.iter().all(agree) {
                this.faces.push(fold);
            }
        }
        this.leave_lifts(constraints, surface, lattice.spacing);
        for set in 0..MIRROR_SETS {
            for (number, fold) in this.faces.iter().enumerate() {
                let is_seen = set as u8 & fold.mirror.bit() != 0;
                for k in (0..3).filter(|k| is_seen && fold.owners[*k].is_some()) {
                    this.following.signs[set][k] *= -1.0;
                    let deciding = &mut this.deciding[set][k];
                    *deciding = deciding.xor(Some(number));
                }
            }
        }
        this
    }

    /// Leaves out folds next to parts of the surface that are lifted: the weights of both would have to be the same.
    fn leave_lifts(&mut self, constraints: &Constraints, surface: &TriangleMesh, spacing: f64) {
        loop {
            let folded = self.faces.iter().fold(0, |set, fold| set | fold.boundaries);
            let is_lifted = |t: &usize| {
                let (corners, normal) = (surface.corners(*t), surface.normal(*t));
                let places = corners.into_iter().chain([surface.centroid(*t)]);
                places.filter_map(|x| constraints.held_at(&x, &normal)).any(|set| set & !folded != 0)
            };
            let lifted: Vec<usize> = (0..surface.triangles.len()).filter(is_lifted).collect();
            let before = self.faces.len();
            self.faces.retain(|fold| {
                let far = |x: Vec3| (x[fold.mirror.axis] - fold.at).abs() > SUPPORT * spacing;
                lifted.iter().all(|t| surface.corners(*t).into_iter().all(far))
            });
            if self.faces.len() == before {
                return;
            }
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Whether that boundary holds by a fold.
    pub fn has(&self, boundary: usize) -> bool {
        self.faces.iter().any(|f| f.boundaries >> boundary & 1 == 1)
    }

    /// Particles at `positions` with these volumes, and after them the images of those near a mirror.
    pub fn doubled(&self, positions: &[Vec3], volume: &[f64], spacing: f64) -> Doubled {
        let mut doubled = Doubled {
            positions: positions.to_vec(),
            volume: volume.to_vec(),
            images: Vec::new(),
            signs: self.following.signs,
        };
        for (a, x) in positions.iter().enumerate() {
            let mut found = vec![(*x, 0)];
            for fold in &self.faces {
                let Mirror { axis, .. } = fold.mirror;
                for k in 0..if (x[axis] - fold.at).abs() < SUPPORT * spacing { found.len() } else { 0 } {
                    let (mut x, set) = found[k];
                    if !has_mirror(set, axis) {
                        x[axis] = 2.0 * fold.at - x[axis];
                        found.push((x, set | fold.mirror.bit()));
                    }
                }
            }
            for (x, set) in &found[1..] {
                doubled.positions.push(*x);
                doubled.volume.push(volume[a]);
                doubled.images.push((a as u32, *set));
            }
        }
        doubled
    }

    /// The mirrors.
    pub fn mirrors(&self) -> Vec<Mirror> {
        self.faces.iter().map(|f| f.mirror).collect()
    }

    /// Normal axis and place of every mirror.
    pub fn planes(&self) -> impl Iterator<Item = (usize, f64)> {
        self.faces.iter().map(|f| (f.mirror.axis, f.at))
    }

    /// Finds the images of particles with these volumes on the lattice with the mirrors.
    /// `modulus` is that of the hourglass term of every particle, in units of kappa.
    pub fn take_images(
        &mut self,
        lattice: &Lattice,
        volume: impl Fn(usize) -> f64,
        modulus: impl Fn(usize) -> f64,
    ) {
        let mut links: Vec<Link> = lattice
            .images
            .iter()
            .map(|image| {
                let (a, (tile, lane)) = (image.particle as usize, image.place());
                // By symmetry the sum over what a particle sees in these mirrors.
                let seen = lattice.neighbours.iter().filter_map(|n| lattice.seen(a, n).map(|s| (s, n.w)));
                let springs: f64 = seen
                    .filter(|(seen, _)| seen.mirrors == image.mirrors)
                    .map(|(seen, w)| volume(seen.particle) * w * 0.5 * (modulus(a) + modulus(seen.particle)))
                    .sum();
                let (volume, place) = (volume(a), (tile as u32, lane as u8));
                let (particle, mirrors) = (image.particle, image.mirrors);
                Link { particle, mirrors, place, volume, springs: volume * springs }
            })
            .collect();
        links.sort_unstable_by_key(|l| (l.particle, l.mirrors));
        self.partial = vec![Pull::default(); links.len().div_ceil(LINKS_PER_SUM)];
        self.links = links;
        self.places = Vec::new();
        for (number, fold) in self.faces.iter().enumerate() {
            for a in 0..lattice.len() {
                let mut x = lattice.position(a);
                if (x[fold.mirror.axis] - fold.at).abs() < lattice.spacing {
                    x[fold.mirror.axis] = fold.at;
                    self.places.push((a as u32, number, x, volume(a) / lattice.spacing));
                }
            }
        }
    }

    /// Lets every face have the z_D of its boundary.
    pub fn set_targets(&mut self, target: &[Vec3]) {
        for set in 0..if self.is_empty() { 0 } else { MIRROR_SETS } {
            let place = |k: usize| {
                let boundary = self.deciding[set][k].and_then(|number| self.faces[number].owners[k]);
                boundary.map_or(0.0, |i| 2.0 * target[i][k])
            };
            self.following.offsets[set] = Vec3::from_fn(|k, _| place(k));
        }
    }

    /// Sums a vector and energies of every link, by the fold that decides a component.
    fn sum(&mut self, of: impl Fn(&Link) -> (Vec3, Vec3) + Sync) -> Pull {
        let deciding = &self.deciding;
        let partial = self.partial.par_iter_mut().zip(self.links.par_chunks(LINKS_PER_SUM));
        partial.for_each(|(partial, links)| {
            *partial = Pull::default();
            for link in links {
                let (vector, energy) = of(link);
                for (k, fold) in deciding[link.mirrors as usize].iter().enumerate() {
                    if let Some(fold) = fold {
                        partial.0[*fold][k] += vector[k];
                        partial.1 += energy[k];
                    }
                }
            }
        });
        self.partial.iter().fold(Pull::default(), |sum, partial| {
            (std::array::from_fn(|i| sum.0[i] + partial.0[i]), sum.1 + partial.1)
        })
    }

    /// Takes the springs between images and particles that see them, of the field z; `origin` is what sums have less of it.
    pub fn stretch(&mut self, z: impl Fn(usize) -> Vec3 + Sync, origin: &Vec3) {
        let offsets = self.following.offsets;
        self.springs = self.sum(|link| {
            let offset = offsets[link.mirrors as usize];
            let pull = (offset - 2.0 * z(link.particle as usize)) * link.springs;
            (pull, 0.5 * pull.component_mul(&(offset - 2.0 * origin)))
        });
    }

    /// Energy of the springs that the sums over particles leave out, after [`Folds::stretch`], in units of kappa.
    pub fn energy(&self) -> f64 {
        self.springs.1
    }

    /// From the sums of the second sweep, at images too, to the force of every face on the body.
    pub fn react(&mut self, kappa: f64, sums: &[Tile]) {
        let (taken, _) = self.sum(|link| (link.force(sums), Vec3::zeros()));
        self.force = std::array::from_fn(|i| 2.0 * (kappa * self.springs.0[i] - taken[i]));
    }

    /// Force of every face on the body and the power of its motion, after [`Folds::react`].
    pub fn reaction(&self, rate: &[Vec3]) -> (Vec3, f64) {
        self.faces.iter().zip(&self.force).fold((Vec3::zeros(), 0.0), |(sum, power), (fold, force)| {
            let work = |k: usize| fold.owners[k].map_or(0.0, |i| force[k] * rate[i][k]);
            (sum + force, power + (0..3).map(work).sum::<f64>())
        })
    }

    /// Forces on images that go to the particles in `range`, from the sums of the second sweep, as (particle, force).
    pub fn forces<'a>(
        &'a self,
        range: Range<usize>,
        sums: &'a [Tile],
    ) -> impl Iterator<Item = (usize, Vec3)> + 'a {
        let at = |a: usize| self.links.partition_point(|l| (l.particle as usize) < a);
        self.links[at(range.start)..at(range.end)].iter().map(move |link| {
            (
                link.particle as usize,
                link.force(sums).component_mul(&self.following.signs[link.mirrors as usize]),
            )
        })
    }

    /// The particles beside a face, each with a place on it, the projector on what is held there and the area.
    pub fn places(&self) -> impl Iterator<Item = (usize, Vec3, Mat3, f64)> + '_ {
        self.places.iter().map(|(a, fold, x, area)| {
            let held = self.faces[*fold].owners.map(|i| f64::from(u8::from(i.is_some())));
            (*a as usize, *x, Mat3::from_diagonal(&Vec3::from(held)), *area)
        })
    }
}

impl Link {
    /// The force on the image that sums of the second sweep make.
    #[inline(always)]
    fn force(&self, sums: &[Tile]) -> Vec3 {
        let (tile, lane) = self.place;
        Vec3::from_fn(|k, _| self.volume * sums[3 * tile as usize + k].0[lane as usize])
    }
}
