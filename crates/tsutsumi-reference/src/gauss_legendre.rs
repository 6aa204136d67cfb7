//! Gauss–Legendre quadrature on panels that shrink towards one end.

/// Positive nodes and weights of the ten-point rule on [−1, 1] (zeros of the Legendre polynomial P₁₀).
const RULE: [(f64, f64); 5] = [
    (0.148_874_338_981_631_2, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_36),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// The integral of a function from zero to `end`, on `num_panels` panels that halve towards zero.
///
/// Exact to rounding for a function that is smooth on a panel of its own length, whatever its scale near zero, as long
/// as that scale is not much below `end / 2^num_panels`.
pub(crate) fn integrate_graded(end: f64, num_panels: usize, function: impl Fn(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    let mut right = end;
    for panel in 1..=num_panels {
        let left = if panel == num_panels { 0.0 } else { 0.5 * right };
        sum += integrate_panel(left, right, &function);
        right = left;
    }
    sum
}

/// The integral over one panel.
pub(crate) fn integrate_panel(left: f64, right: f64, function: &impl Fn(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
    half * RULE.iter().map(|(x, w)| w * (function(middle - half * x) + function(middle + half * x))).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ten-point rule is exact for polynomials up to degree 19: ∫₀¹ 20 x¹⁹ dx = 1.
    #[test]
    fn one_panel_is_exact_to_degree_nineteen() {
        let value = integrate_graded(1.0, 1, |x| 20.0 * x.powi(19));
        assert!((value - 1.0).abs() < 1e-14, "{value}");
    }

    /// ∫₀¹ ε/(x + ε)² dx = 1/(1 + ε): a spike of width 10⁻⁵.
    #[test]
    fn a_narrow_spike_at_zero_is_caught() {
        let width = 1e-5;
        let value = integrate_graded(1.0, 24, |x| width / (x + width).powi(2));
        assert!((value - 1.0 / (1.0 + width)).abs() < 1e-12, "{value}");
    }
}
