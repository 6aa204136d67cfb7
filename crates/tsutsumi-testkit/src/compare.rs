//! Comparing numbers: closeness, and the order at which errors vanish.

/// Asserts |value − expected| ≤ tolerance. The message says what is off and by how much. NaN is never close.
#[track_caller]
pub fn assert_close(what: &str, value: f64, expected: f64, tolerance: f64) {
    let off = (value - expected).abs();
    assert!(off <= tolerance, "{what} is {value:e}, expected {expected:e} ± {tolerance:e}: off by {off:e}");
}

/// Asserts that two lists have the same length and |value − expected| ≤ tolerance throughout.
#[track_caller]
pub fn assert_all_close(what: &str, values: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(values.len(), expected.len(), "the number of values of {what}");
    for (i, (&value, &expected)) in values.iter().zip(expected).enumerate() {
        assert_close(&format!("{what} [{i}]"), value, expected, tolerance);
    }
}

/// The order p at which errors fall with the spacing, error = C h^p: the slope of the line through
/// (ln h, ln error) by least squares.
///
/// NaN for fewer than two pairs, or for an error that is not positive.
pub fn observed_order(errors: &[(f64, f64)]) -> f64 {
    let points = || errors.iter().map(|&(h, error)| (h.ln(), error.ln()));
    let count = errors.len() as f64;
    let (mean_x, mean_y) = points().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let covariance: f64 = points().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let variance: f64 = points().map(|(x, _)| (x - mean_x).powi(2)).sum();
    covariance / variance
}

/// The root of the mean square of the differences: an error over a profile.
pub fn root_mean_square(differences: &[f64]) -> f64 {
    (differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_a_power_law_is_its_exponent() {
        let errors: Vec<(f64, f64)> = [2.0, 1.0, 0.5, 0.1].iter().map(|&h: &f64| (h, 3.0 * h.powf(1.7))).collect();
        assert_close("order", observed_order(&errors), 1.7, 1e-13);
        assert!(observed_order(&errors[..1]).is_nan());
    }

    #[test]
    #[should_panic(expected = "base pressure is NaN, expected 1e0 ± 2e0")]
    fn nan_is_never_close() {
        assert_close("base pressure", f64::NAN, 1.0, 2.0);
    }

    #[test]
    fn the_root_mean_square_of_3_and_4() {
        assert_close("rms", root_mean_square(&[3.0, -4.0]), 12.5_f64.sqrt(), 1e-15);
    }
}
