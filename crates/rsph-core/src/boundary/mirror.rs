//! Mirror planes: clamps and rollers on straight faces of a body in the plane.
//!
//! The image of a particle moves with u_g = s u + (1 - s) u_D, component by component: s = -1 where the component is held,
//! s = +1 where it is free (a roller).

use crate::setup::Motion;
use crate::tensor::Vec3;

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

/// Ghosts that were mirrored at the same plane, or at the same two or three planes in a corner.
#[derive(Clone, Debug)]
pub struct Group {
    planes: Vec<usize>,
    /// Diagonal of the reflection.
    pub reflection: Vec3,
    /// s, the sign with which each component is mirrored.
    pub sign: Vec3,
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
                Self { planes: group, reflection, sign }
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
