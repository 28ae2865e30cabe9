//! Checks that the constructors of shapes share.

use crate::error::InvalidInput;
use crate::grid::Bounds;
use crate::tensor::Vec3;

/// A length that must be positive and finite.
pub(super) fn positive(key: &str, value: f64) -> Result<(), InvalidInput> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(InvalidInput::new(
        key,
        value,
        "a length must be a positive, finite number (length unit of the scenario, m in SI)",
        "give a length above zero",
    ))
}

/// Edge lengths that must be positive and finite.
pub(super) fn positive_vector(key: &str, value: &Vec3) -> Result<(), InvalidInput> {
    (0..3).try_for_each(|i| positive(&format!("{key}[{i}]"), value[i]))
}

/// A position that must be finite.
pub(super) fn finite(key: &str, value: &Vec3) -> Result<(), InvalidInput> {
    match (0..3).find(|&i| !value[i].is_finite()) {
        None => Ok(()),
        Some(i) => Err(InvalidInput::new(
            format!("{key}[{i}]"),
            value[i],
            "a coordinate must be a finite number (length unit of the scenario, m in SI)",
            "give three finite coordinates",
        )),
    }
}

/// Sizes (any unit) between which products of three lengths, and their squares, are numbers.
const SIZES: std::ops::RangeInclusive<f64> = 1e-30..=1e30;
/// Farther from the origin than so many times its size, the points of a body lose their digits.
const FARTHEST: f64 = 1e7;

/// A body whose size and place can be computed with; `dimension` is 3, or 2 for a plane one.
pub(crate) fn extent(key: &str, bounds: &Bounds, dimension: usize) -> Result<(), InvalidInput> {
    let size = bounds.size();
    let edges = || size.iter().take(dimension);
    let text = || edges().map(|s| format!("{s:.3e}")).collect::<Vec<_>>().join(" x ");
    let longest = edges().copied().fold(0.0, f64::max);
    if !edges().all(|s| SIZES.contains(s)) {
        return Err(InvalidInput::new(
            key,
            text(),
            format!(
                "its size is {}; each of these lengths must lie between {:e} and {:e}",
                text(),
                SIZES.start(),
                SIZES.end()
            ),
            "check its lengths, or the scale of its mesh",
        ));
    }
    let farthest =
        bounds.min.abs().sup(&bounds.max.abs()).iter().take(dimension).copied().fold(0.0, f64::max);
    if farthest > FARTHEST * longest {
        return Err(InvalidInput::new(
            key,
            text(),
            format!(
                "its size is {}, and it lies {farthest:.3e} from the origin, more than {FARTHEST:e} times as far: \
                 its points would lose their digits",
                text()
            ),
            "move it to the origin",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(min: [f64; 3], size: [f64; 3], dimension: usize) -> bool {
        let min = Vec3::from(min);
        extent("body.shape", &Bounds { min, max: min + Vec3::from(size) }, dimension).is_err()
    }

    #[test]
    fn sizes_and_places_that_can_not_be_computed_with_are_refused() {
        assert!(!refused([0.0; 3], [1.0, 2.0, 0.01], 3));
        assert!(!refused([5e6, 4e5, 0.0], [1.0, 2.0, 1.0], 3));
        assert!(!refused([0.0; 3], [1.0, 2.0, 0.0], 2));
        assert!(refused([0.0; 3], [1.0, 2.0, 0.0], 3));
        assert!(refused([0.0; 3], [1e31, 1.0, 1.0], 3));
        assert!(refused([0.0; 3], [1e-31, 1.0, 1.0], 3));
        assert!(refused([0.0; 3], [f64::NAN, 1.0, 1.0], 3));
        assert!(refused([0.0, 1e8, 0.0], [1.0; 3], 3));
    }
}
