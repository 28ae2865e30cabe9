//! Clamps, rollers and symmetry planes on a flat face: mirror ghosts.
//!
//! Every particle a near the plane sees the mirror images of its neighbours. The image of particle m
//! moves with u_g = s u_m + (1 - s) u_D, component by component: s = -1 where the component is held
//! (so that u = u_D on the plane, wherever the plane lies between lattice layers), s = +1 where it is
//! free (a roller). Ghosts are a linear function of the particles, so that the force on a particle,
//! its image's force included, stays the exact derivative of the discrete energy.

use crate::kernel::QuarticSpline;
use crate::lattice::Lattice;
use crate::ops::{Fold, Folds};
use crate::setup::Motion;
use crate::tensor::Vec3;
use std::collections::HashMap;

/// Distance from a cell face, in cells, within which a plane counts as lying on it.
const ON_FACE: f64 = 1e-9;

/// An axis-aligned mirror plane.
#[derive(Clone, Copy, Debug)]
pub struct MirrorPlane {
    /// Normal axis 0, 1, 2.
    pub axis: usize,
    /// Coordinate on that axis.
    pub at: f64,
    /// Components held at the plane.
    pub fix: [bool; 3],
    /// Motion of the plane.
    pub motion: Option<Motion>,
}

/// One ghost in the neighbourhood of a particle.
#[derive(Clone, Copy, Debug)]
pub struct Ghost {
    /// The particle that it mirrors.
    pub partner: u32,
    /// Which [`Group`] it belongs to.
    pub group: u32,
    /// w(r) = -W'(r)/r.
    pub w: f64,
    /// X = x_ghost - x_a.
    pub x: Vec3,
    /// Diagonal of the reflection.
    pub reflection: Vec3,
    /// s, the sign with which each component is mirrored.
    pub sign: Vec3,
}

/// Ghosts that were mirrored at the same plane, or at the same two or three planes in a corner.
#[derive(Clone, Debug)]
pub struct Group {
    planes: Vec<usize>,
    /// Diagonal of the reflection.
    pub reflection: Vec3,
    /// s, the sign with which each component is mirrored.
    pub sign: Vec3,
    /// Whether all of its planes are folds of the lattice.
    pub folded: bool,
}

impl Group {
    /// Every set of planes with different axes: a face, an edge, a corner.
    pub fn all(planes: &[MirrorPlane]) -> Vec<Self> {
        (1..1_usize << planes.len())
            .map(|set| (0..planes.len()).filter(|p| set >> p & 1 == 1).collect::<Vec<_>>())
            .filter(|g| (0..3).all(|axis| g.iter().filter(|&&p| planes[p].axis == axis).count() <= 1))
            .map(|group| {
                let (mut reflection, mut sign) = (Vec3::repeat(1.0), Vec3::repeat(1.0));
                for plane in group.iter().map(|&p| &planes[p]) {
                    reflection[plane.axis] = -1.0;
                    for i in 0..3 {
                        sign[i] *= if plane.fix[i] { -1.0 } else { 1.0 };
                    }
                }
                Self { planes: group, reflection, sign, folded: false }
            })
            .collect()
    }

    /// The mirror image of a place.
    pub fn image(&self, planes: &[MirrorPlane], x: &Vec3) -> Vec3 {
        let mut image = *x;
        for plane in self.planes.iter().map(|&p| &planes[p]) {
            image[plane.axis] = 2.0 * plane.at - image[plane.axis];
        }
        image
    }

    /// The constant (1 - s) u_D of its ghosts' displacement, where `plane_value(p)` is u_D (or its rate) of
    /// plane number p.
    pub fn offset(&self, planes: &[MirrorPlane], plane_value: impl Fn(usize) -> Vec3) -> Vec3 {
        let mut out = Vec3::zeros();
        for &p in &self.planes {
            let u_d = plane_value(p);
            for i in 0..3 {
                if planes[p].fix[i] {
                    out[i] = 2.0 * u_d[i] - out[i];
                }
            }
        }
        out
    }
}

/// All mirror ghosts of a body.
#[derive(Clone, Debug, Default)]
pub struct Mirror {
    planes: Vec<MirrorPlane>,
    /// Planes on cell faces: the kernel sums of the lattice see the images of particles there by
    /// themselves.
    folds: Folds,
    groups: Vec<Group>,
    starts: Vec<u32>,
    seen: Vec<Seen>,
    /// The different ghosts but for their partners: lattice and images of it leave few distances.
    kinds: Vec<Ghost>,
}

/// Ghosts in the neighbourhood of a particle that follow each other along x, in short.
#[derive(Clone, Copy, Debug)]
struct Seen {
    /// Partner of the first; the others' follow.
    partner: u32,
    /// Which of the kinds the first is; the others' follow.
    kind: u32,
    count: u32,
}

impl Mirror {
    /// The ghosts of `lattice`'s particles at the undeformed `positions`; `body(a)` says whether sums see
    /// particle a.
    pub fn new(
        lattice: &Lattice,
        positions: &[Vec3],
        planes: Vec<MirrorPlane>,
        body: impl Fn(usize) -> bool,
    ) -> Self {
        let origin = lattice.origin;
        let kernel = QuarticSpline::<3>::new(lattice.smoothing_length);
        let support = kernel.support() * (1.0 - 1e-9);
        let of_plane: Vec<Option<Fold>> = planes.iter().map(|p| fold(lattice, positions, p, &body)).collect();
        let mut groups = Group::all(&planes);
        for group in &mut groups {
            group.folded = group.planes.iter().all(|&p| of_plane[p].is_some());
        }
        let (mut starts, mut seen): (_, Vec<Seen>) = (vec![0], Vec::new());
        // Kinds that follow each other along x have following numbers.
        let nothing = Ghost {
            partner: 0,
            group: 0,
            w: 0.0,
            x: Vec3::zeros(),
            reflection: Vec3::zeros(),
            sign: Vec3::zeros(),
        };
        let reach = (support / lattice.spacing).ceil() as isize + 1;
        let row = vec![nothing; 2 * reach as usize + 1];
        let (mut kinds, mut rows) = (Vec::new(), HashMap::new());
        for (a, x_a) in positions.iter().enumerate() {
            let cell = lattice.coordinates(a).map(|c| c as isize);
            for (g, group) in groups.iter().enumerate() {
                let (reflection, sign) = (group.reflection, group.sign);
                let image = group.image(&planes, x_a);
                let middle =
                    ((group.image(&planes, &origin).x - origin.x) / lattice.spacing).round() as isize;
                // |x_ghost(m) - x_a| = |x_m - image of a|: search around the image.
                let low: [isize; 3] = std::array::from_fn(|i| {
                    ((image[i] - origin[i] - support) / lattice.spacing - 0.5).ceil() as isize
                });
                let high: [isize; 3] = std::array::from_fn(|i| {
                    ((image[i] - origin[i] + support) / lattice.spacing - 0.5).floor() as isize
                });
                for k in low[2]..=high[2] {
                    for j in low[1]..=high[1] {
                        for i in low[0]..=high[0] {
                            let Some(m) = lattice.particle([i, j, k]) else { continue };
                            let x = (positions[m] - image).component_mul(&reflection);
                            let r = x.norm();
                            if r > 0.0 && r < support {
                                // Along a mirrored axis the sum of the two cells tells the distance.
                                let apart: [isize; 3] = std::array::from_fn(|axis| {
                                    [i, j, k][axis] - reflection[axis] as isize * cell[axis]
                                });
                                let first = *rows.entry((g, apart[1], apart[2])).or_insert_with(|| {
                                    kinds.extend_from_slice(&row);
                                    kinds.len() - row.len()
                                });
                                let kind = first + (apart[0] - middle + reach) as usize;
                                if kinds[kind].w == 0.0 {
                                    let w = kernel.gradient_weight(r);
                                    kinds[kind] =
                                        Ghost { partner: 0, group: g as u32, w, x, reflection, sign };
                                }
                                let kind = kind as u32;
                                let first = starts[a] as usize;
                                match seen[first..].last_mut() {
                                    Some(s)
                                        if s.partner + s.count == m as u32 && s.kind + s.count == kind =>
                                    {
                                        s.count += 1;
                                    }
                                    _ => seen.push(Seen { partner: m as u32, kind, count: 1 }),
                                }
                            }
                        }
                    }
                }
            }
            starts.push(seen.len() as u32);
            debug_assert_eq!(starts.len(), a + 2);
        }
        let of_plane: Vec<Fold> = of_plane.into_iter().flatten().collect();
        let folds = Folds::new(&of_plane);
        seen.shrink_to_fit();
        Self { planes, folds, groups, starts, seen, kinds }
    }

    /// The ghosts that particle `a` sees.
    #[inline(always)]
    pub fn ghosts_of(&self, a: usize) -> impl Iterator<Item = Ghost> + '_ {
        self.seen_by(a).iter().flat_map(|s| {
            (0..s.count).map(|i| {
                let kind = &self.kinds[(s.kind + i) as usize];
                Ghost { partner: s.partner + i, ..*kind }
            })
        })
    }

    /// Whether particle `a` sees a ghost.
    pub fn has_ghosts(&self, a: usize) -> bool {
        !self.seen_by(a).is_empty()
    }

    #[inline(always)]
    fn seen_by(&self, a: usize) -> &[Seen] {
        if self.seen.is_empty() {
            &[]
        } else {
            &self.seen[self.starts[a] as usize..self.starts[a + 1] as usize]
        }
    }

    /// The planes that the sums of the lattice know of.
    pub fn folds(&self) -> &Folds {
        &self.folds
    }

    /// Whether the sums of the lattice see a ghost by themselves; if not they must be completed.
    #[inline(always)]
    pub fn is_folded(&self, ghost: &Ghost) -> bool {
        self.groups[ghost.group as usize].folded
    }

    /// Whether there are ghosts that the sums of the lattice do not see.
    pub fn has_others(&self) -> bool {
        self.groups.iter().any(|g| !g.folded)
    }

    /// Whether there is any ghost.
    pub fn is_empty(&self) -> bool {
        self.seen.is_empty()
    }

    /// Number of groups.
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// The planes.
    pub fn planes(&self) -> &[MirrorPlane] {
        &self.planes
    }

    /// Whether any plane moves.
    pub fn moves(&self) -> bool {
        self.planes.iter().any(|p| p.motion.is_some())
    }

    /// For each group the constant (1 - s) u_D of its ghosts' displacement, where
    /// `plane_value(motion)` is u_D (or its rate).
    pub fn offsets(&self, out: &mut [Vec3], plane_value: impl Fn(&Motion) -> Vec3) {
        for (group, out) in self.groups.iter().zip(out) {
            *out = group.offset(&self.planes, |p| {
                self.planes[p].motion.as_ref().map_or_else(Vec3::zeros, &plane_value)
            });
        }
    }
}

/// The fold of a plane that lies on cell faces.
fn fold(
    lattice: &Lattice,
    positions: &[Vec3],
    plane: &MirrorPlane,
    body: impl Fn(usize) -> bool,
) -> Option<Fold> {
    let face = (plane.at - lattice.origin[plane.axis]) / lattice.spacing;
    if (face - face.round()).abs() > ON_FACE {
        return None;
    }
    let side: f64 = (0..positions.len())
        .filter(|&a| body(a))
        .map(|a| (positions[a][plane.axis] - plane.at).signum())
        .sum();
    let sign = plane.fix.map(|held| if held { -1.0 } else { 1.0 });
    Some(Fold { axis: plane.axis, face: face.round() as isize, above: side >= 0.0, sign })
}
