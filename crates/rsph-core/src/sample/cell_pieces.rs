//! The tissue in a cell that the surface cuts in two or more: what lies on each side of a gap is a piece of its own.

use super::sight::Sight;
use crate::tensor::Vec3;

/// Places along each edge of a cell.
const FINE: usize = 8;
/// Difference of two shares of a cell below which they count as equal, and the direction in which one is preferred.
const EVEN: f64 = 0.05;
const PREFERRED: [f64; 3] = [1.0, 0.7, 0.4];
/// Places of a cell.
const PLACES: usize = FINE * FINE * FINE;

/// A piece of the tissue in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellPiece {
    /// Share of the cell.
    pub(super) fraction: f64,
    /// A place in it, near its middle.
    pub(super) home: Vec3,
}

/// The pieces of the cell around `centre`, which lies inside to this fraction, the largest first; one at `centre` if the surface does not
/// pass between any two of its places.
pub(super) fn cell_pieces(sight: &Sight, centre: &Vec3, spacing: f64, fraction: f64) -> Vec<CellPiece> {
    let whole = vec![CellPiece { fraction, home: *centre }];
    let step = spacing / FINE as f64;
    let offset = |i: usize| (i as f64 + 0.5) * step - 0.5 * spacing;
    let place =
        |k: usize| centre + Vec3::new(offset(k % FINE), offset(k / FINE % FINE), offset(k / FINE / FINE));
    // Whether each place lies inside, where a line through it tells, and whether the surface passes between it and the next along each axis.
    let mut inside: [Option<bool>; PLACES] = [None; PLACES];
    let mut is_cut = [[false; PLACES]; 3];
    let mut any = false;
    let stride = [1, FINE, FINE * FINE];
    for axis in 0..3 {
        for first in (0..PLACES).filter(|k| (k / stride[axis]).is_multiple_of(FINE)) {
            let start = place(first);
            let end = start + Vec3::ith(axis, (FINE - 1) as f64 * step);
            let passages = sight.passages(&start, &end);
            if passages.is_empty() {
                continue;
            }
            any = true;
            let mut passed = passages.iter().peekable();
            let mut is_inside = passages[0].1;
            for i in 0..FINE {
                let here = first + i * stride[axis];
                inside[here] = Some(is_inside);
                let next = (i as f64 + 1.0) / (FINE - 1) as f64;
                while let Some((_, leaves)) = passed.next_if(|p| p.0 < next) {
                    is_inside = !leaves;
                    is_cut[axis][here] = true;
                }
            }
        }
    }
    if !any {
        return whole;
    }
    // Places that no passage parts are of one piece.
    let mut piece = [usize::MAX; PLACES];
    let mut pieces: Vec<(usize, Vec3, bool)> = Vec::new();
    for start in 0..PLACES {
        if piece[start] != usize::MAX {
            continue;
        }
        let number = pieces.len();
        let (mut members, mut next) = (vec![start], 0);
        piece[start] = number;
        while next < members.len() {
            let k = members[next];
            next += 1;
            for axis in 0..3 {
                let i = k / stride[axis] % FINE;
                let after = (i + 1 < FINE && !is_cut[axis][k]).then(|| k + stride[axis]);
                let before = (i > 0 && !is_cut[axis][k - stride[axis]]).then(|| k - stride[axis]);
                for other in after.into_iter().chain(before) {
                    if piece[other] == usize::MAX {
                        piece[other] = number;
                        members.push(other);
                    }
                }
            }
        }
        let votes: i32 = members.iter().filter_map(|k| inside[*k]).map(|i| if i { 1 } else { -1 }).sum();
        let middle = members.iter().map(|k| place(*k)).sum::<Vec3>() / members.len() as f64;
        pieces.push((members.len(), middle, votes > 0));
    }
    let count: usize = pieces.iter().filter(|p| p.2).map(|p| p.0).sum();
    let mut found: Vec<CellPiece> = pieces
        .iter()
        .enumerate()
        .filter(|(_, (_, _, is_inside))| *is_inside)
        .map(|(number, (members, middle, _))| {
            let of = (0..PLACES).filter(|k| piece[*k] == number).map(place);
            let home = of.min_by(|a, b| (a - middle).norm().total_cmp(&(b - middle).norm()));
            CellPiece {
                fraction: fraction * *members as f64 / count.max(1) as f64,
                home: home.unwrap_or(*centre),
            }
        })
        .collect();
    found.sort_by(|a, b| b.fraction.total_cmp(&a.fraction));
    // Pieces that see each other are one: the surface passes between them without a gap.
    let mut apart: Vec<CellPiece> = Vec::new();
    for piece in found {
        match apart.iter_mut().find(|other| !sight.is_blocked(&other.home, &piece.home)) {
            Some(other) => other.fraction += piece.fraction,
            None => apart.push(piece),
        }
    }
    apart.sort_by(|a, b| b.fraction.total_cmp(&a.fraction));
    // Of equal shares that on the same side of the gap in every cell along it.
    if let [a, b, ..] = &mut apart[..]
        && a.fraction - b.fraction < EVEN
        && (a.home - b.home).dot(&Vec3::from(PREFERRED)) < 0.0
    {
        std::mem::swap(a, b);
    }
    if apart.is_empty() { whole } else { apart }
}
