//! Forces and moments of folds: derivatives of the energy with respect to a shift and a rotation of the face and its mirror.

use super::{Folds, Following, Link};
use crate::boundary::reaction::{Arms, Reaction};
use crate::lattice::Lattice;
use crate::tensor::Vec3;
use crate::tiles::Tile;

/// The sums that images take part in.
#[derive(Clone, Copy)]
pub struct ImageSums<'a> {
    /// The lattice with the images.
    pub lattice: &'a Lattice,
    /// How images follow the field z that was spread.
    pub following: &'a Following,
    /// z of a particle.
    pub z: &'a dyn Fn(usize) -> Vec3,
    /// Volume of a particle.
    pub volume: &'a dyn Fn(usize) -> f64,
    /// kappa.
    pub hourglass: f64,
    /// What kappa is multiplied by for a particle.
    pub modulus: &'a dyn Fn(usize) -> f64,
    /// Sums of the second sweep.
    pub sums: &'a [Tile],
}

impl std::fmt::Debug for ImageSums<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ImageSums").field("hourglass", &self.hourglass).finish_non_exhaustive()
    }
}

impl ImageSums<'_> {
    /// G = -dE/dz of the image of a link, as if it followed nothing.
    fn force(&self, link: &Link) -> Vec3 {
        let (b, set) = (link.particle as usize, link.mirrors);
        let image = self.following.image(set, &(self.z)(b));
        let mut springs = Vec3::zeros();
        // A particle sees an image as its own image is seen by the other one.
        for neighbour in &self.lattice.neighbours {
            if let Some(seen) = self.lattice.seen(b, neighbour).filter(|seen| seen.mirrors == set) {
                let vw = (self.volume)(seen.particle) * (self.modulus)(seen.particle) * neighbour.w;
                springs += vw * (image - (self.z)(seen.particle));
            }
        }
        link.force(self.sums) - self.hourglass * link.volume * springs
    }
}

impl Folds {
    /// Keeps how images have followed their particles up to now, when the body is remeshed.
    pub fn remember_remesh(&mut self) {
        self.at_remesh = self.following.offsets;
    }

    /// Adds what every boundary carries by the faces that are folds, from the `sums` of the second sweep; z_D is that of the last
    /// [`Folds::set_targets`].
    ///
    /// An image in the mirrors 1 to m is the last of x_j = S_j x_(j-1) + offset_j. A face that turns with its mirror by omega moves x_j
    /// by omega x x_j - S_j omega x x_(j-1), in the components that it does not hold as well: there they follow the mirror.
    pub fn add_reactions(&self, sums: &ImageSums<'_>, arms: &Arms<'_>, reactions: &mut [Reaction]) {
        for link in &self.links {
            let g = sums.force(link);
            let (a, mut set) = (link.particle as usize, 0);
            let mut before = arms.place(a);
            for fold in self.faces.iter().filter(|fold| link.mirrors & fold.mirror.bit() != 0) {
                set |= fold.mirror.bit();
                let place = self.image_place(sums.lattice, arms, a, set);
                for k in 0..3 {
                    let sign = if fold.owners[k].is_some() { -1.0 } else { 1.0 };
                    // What later mirrors make of it.
                    let later = self.following.signs[link.mirrors as usize][k]
                        * self.following.signs[set as usize][k];
                    let force = Vec3::ith(k, -later * g[k]);
                    if let Some(i) = fold.owners[k].or(fold.owners[fold.mirror.axis]) {
                        reactions[i].add(&place, &force);
                        reactions[i].add(&before, &(-sign * force));
                    }
                }
                before = place;
            }
        }
    }

    /// Where a force on the image of particle `a` in that set of mirrors acts.
    fn image_place(&self, lattice: &Lattice, arms: &Arms<'_>, a: usize, set: u8) -> Vec3 {
        let on_lattice = lattice.position(a);
        let mut place = on_lattice;
        for fold in self.faces.iter().filter(|fold| set & fold.mirror.bit() != 0) {
            let k = fold.mirror.axis;
            place[k] = 2.0 * fold.at - place[k];
        }
        let signs = &self.following.signs[set as usize];
        // From the lattice of the last remesh back to the undeformed body, and on.
        place -= signs.component_mul(&(on_lattice - arms.reference(a))) + self.at_remesh[set as usize];
        if arms.displacement.is_some() {
            place += self.following.image(set, &arms.moved(a));
        }
        place
    }

    /// Places and areas on the faces, with a boundary that holds each.
    pub fn held_places(&self) -> impl Iterator<Item = (usize, Vec3, f64)> + '_ {
        self.places.iter().flat_map(|(_, fold, x, area)| {
            let owners = self.faces[*fold].owners;
            (0..3)
                .filter(move |k| !owners[..*k].contains(&owners[*k]))
                .filter_map(move |k| Some((owners[k]?, *x, *area)))
        })
    }
}
