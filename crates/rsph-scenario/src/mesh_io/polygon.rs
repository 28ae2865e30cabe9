//! Polygons into triangles.

use super::fan;
use rsph_core::tensor::Vec3;

/// Most corners of a face: each ear is compared with all of them.
pub(super) const MAX_CORNERS: usize = 2000;

/// The triangles of a polygon of these vertices, which may have dents: two fewer than it has corners. Every corner stays, those on
/// straight sides too, which libraries that cut ears drop: the faces beside it have them.
pub(super) fn triangles(polygon: &[u32], vertices: &[Vec3]) -> Vec<[u32; 3]> {
    let corners: Option<Vec<Vec3>> = polygon.iter().map(|&v| vertices.get(v as usize).copied()).collect();
    match corners {
        Some(corners) if corners.len() > 3 => {
            cut_ears(&corners).into_iter().map(|t| t.map(|corner| polygon[corner])).collect()
        }
        // Whoever reads the file refuses vertices that are not there.
        _ => fan(polygon).collect(),
    }
}

/// Triangles by the numbers of their corners; fans where nothing is dented.
fn cut_ears(corners: &[Vec3]) -> Vec<[usize; 3]> {
    let normal = normal(corners);
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::with_capacity(corners.len().saturating_sub(2));
    while left.len() > 3 {
        let n = left.len();
        let ear = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        let is_ear = |i: usize| {
            let tips = ear(i).map(|v| corners[v]);
            turn(tips, normal) > 0.0
                && left.iter().map(|&v| corners[v]).all(|x| tips.contains(&x) || !is_within(x, tips, normal))
        };
        // A polygon that is flat, or crosses itself, may have none: any corner will do.
        let i = (1..=n).find(|&i| is_ear(i % n)).unwrap_or(1) % n;
        triangles.push(ear(i));
        left.remove(i);
    }
    triangles.extend(left.first_chunk::<3>());
    triangles
}

/// The normal of a polygon, as long as twice its area (Newell's method).
fn normal(corners: &[Vec3]) -> Vec3 {
    let Some(first) = corners.first() else { return Vec3::zeros() };
    corners.windows(2).map(|pair| (pair[0] - first).cross(&(pair[1] - first))).sum()
}

/// Twice the area of the triangle, negative where it turns against `normal`.
fn turn([a, b, c]: [Vec3; 3], normal: Vec3) -> f64 {
    (b - a).cross(&(c - a)).dot(&normal)
}

/// Whether x lies in the triangle, seen along `normal`, or on its border.
fn is_within(x: Vec3, [a, b, c]: [Vec3; 3], normal: Vec3) -> bool {
    [[a, b, x], [b, c, x], [c, a, x]].into_iter().all(|side| turn(side, normal) >= 0.0)
}
