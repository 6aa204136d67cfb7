//! Axes: ranges that cover the data, and ticks at round numbers.

/// How an axis maps numbers to lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AxisScale {
    /// Equal differences take equal lengths.
    #[default]
    Linear,
    /// Equal ratios take equal lengths. Values that are not positive cannot be drawn and leave a gap in their curve.
    Logarithmic,
}

impl AxisScale {
    /// Whether a value can be drawn. Numbers beyond ±1e150 cannot: their differences could overflow.
    pub(super) fn can_draw(self, value: f64) -> bool {
        match self {
            Self::Linear => value.is_finite() && value.abs() <= 1e150,
            Self::Logarithmic => (1e-150..=1e150).contains(&value),
        }
    }

    /// The number that grows evenly along the axis.
    fn even(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => value.log10(),
        }
    }
}

/// A number written along an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// Where it stands, in units of the data.
    pub(super) value: f64,
    /// What is written there, without the common power of ten.
    pub(super) label: String,
}

/// How far data may go beyond the last tick, as part of their range.
const END_STRIP: f64 = 0.02;

/// Range and ticks of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// Smallest value on the axis.
    pub(super) low: f64,
    /// Largest value on the axis.
    pub(super) high: f64,
    /// Ticks with numbers, ascending.
    pub(super) ticks: Vec<Tick>,
    /// Ticks without numbers, ascending.
    pub(super) minor: Vec<f64>,
    /// The labels are to be multiplied by ten to this power.
    pub(super) exponent: i32,
    scale: AxisScale,
}

impl Axis {
    /// An axis that ends at ticks at or beyond the ends of the range, with about `intervals` intervals.
    pub(super) fn loose(range: [f64; 2], scale: AxisScale, intervals: usize) -> Self {
        match scale {
            AxisScale::Linear => Self::loose_linear(range, intervals),
            AxisScale::Logarithmic => Self::loose_logarithmic(range, intervals),
        }
    }

    /// A linear axis that ends exactly at the ends of the range, with about `intervals` intervals between its ticks.
    pub(super) fn tight([low, high]: [f64; 2], intervals: usize) -> Self {
        let step = round_step((high - low) / intervals as f64);
        // A range may lie between two round numbers; finer steps find at least two ticks in it.
        [step, step / 2.0, step / 5.0, step / 10.0]
            .into_iter()
            .map(|finer| Self::linear([low, high], round_step(finer)))
            .find(|axis| axis.ticks.len() >= 2)
            .unwrap_or_else(|| Self::linear([low, high], step))
    }

    /// The finest axis, of at most `most` intervals, whose labels fit.
    pub(super) fn finest(most: usize, build: impl Fn(usize) -> Self, fits: impl Fn(&Self) -> bool) -> Self {
        let few_enough = |axis: &Self| axis.ticks.len() <= most + 2;
        (2..=most).rev().map(&build).find(|axis| few_enough(axis) && fits(axis)).unwrap_or_else(|| build(1))
    }

    /// Where a value lies: 0 at the low end, 1 at the high end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        let [low, high] = [self.scale.even(self.low), self.scale.even(self.high)];
        (self.scale.even(value) - low) / (high - low)
    }

    /// The axis title with the common power of ten put before the unit.
    pub(super) fn title(&self, label: &str) -> String {
        if self.exponent == 0 {
            return label.to_owned();
        }
        let factor = format!("×{}", power_of_ten(self.exponent));
        // A dash in the place of the unit says that there is none.
        let label = ["(-)", "(–)", "(−)"].iter().find_map(|none| label.strip_suffix(none)).unwrap_or(label).trim_end();
        match label.rfind('(') {
            Some(place) if label.ends_with(')') => format!("{}({factor} {}", &label[..place], &label[place + 1..]),
            _ => format!("{label} ({factor})"),
        }
    }

    fn loose_linear([low, high]: [f64; 2], intervals: usize) -> Self {
        let step = round_step((high - low) / intervals as f64);
        // Data that pass a tick by a little (a heave of 0.1 mm in a settlement of 50 mm) do not cost a whole empty interval.
        let strip = END_STRIP * (high - low);
        let first = ((low + strip) / step).floor() * step;
        let last = ((high - strip) / step).ceil() * step;
        Self::linear([first.min(low), last.max(high)], step)
    }

    fn linear([low, high]: [f64; 2], step: f64) -> Self {
        let first = (low / step - 1e-9).ceil();
        let count = ((high / step + 1e-9).floor() - first).max(-1.0) as usize + 1;
        let values: Vec<f64> = (0..count).map(|index| (first + index as f64) * step).collect();
        let exponent = common_exponent(low.abs().max(high.abs()));
        let ticks =
            values.iter().map(|value| Tick { value: *value, label: plain_label(*value, step, exponent) }).collect();
        Self { low, high, ticks, minor: Vec::new(), exponent, scale: AxisScale::Linear }
    }

    fn loose_logarithmic([low, high]: [f64; 2], intervals: usize) -> Self {
        let first = (low.log10() + 1e-9).floor() as i32;
        let last = ((high.log10() - 1e-9).ceil() as i32).max(first + 1);
        let stride = ((last - first) as usize).div_ceil(intervals.max(1));
        let powers: Vec<i32> = (first..=last).step_by(stride).collect();
        let ticks = powers.iter().map(|power| Tick { value: 10_f64.powi(*power), label: power_label(*power, &powers) });
        let ticks = ticks.collect();
        let minor = if stride == 1 { minor_decades(first, last) } else { Vec::new() };
        let [low, high] = [10_f64.powi(first), 10_f64.powi(last)];
        Self { low, high, ticks, minor, exponent: 0, scale: AxisScale::Logarithmic }
    }
}

/// The range of the values that can be drawn; none if there are no such values.
pub(super) fn range_of(values: impl Iterator<Item = f64>, scale: AxisScale) -> Option<[f64; 2]> {
    values.filter(|value| scale.can_draw(*value)).fold(None, |range, value| match range {
        None => Some([value, value]),
        Some([low, high]) => Some([value.min(low), value.max(high)]),
    })
}

/// The range, or a wider one around it if its ends agree (to nine digits), as a constant has no range of its own.
pub(super) fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    let size = low.abs().max(high.abs());
    if high - low > 1e-9 * size && high - low > 1e-150 {
        return [low, high];
    }
    let margin = if size > 1e-140 { 0.05 * size } else { 1.0 };
    [low - margin, high + margin]
}

/// A linear range with a margin, so that a plateau does not lie on the frame. An end near zero gets none: zero is where
/// most axes should start.
pub(super) fn padded([low, high]: [f64; 2]) -> [f64; 2] {
    let margin = 0.03 * (high - low);
    let strip = END_STRIP * (high - low);
    let lower = if (-strip..=margin).contains(&low) { low.min(0.0) } else { low - margin };
    let upper = if (-margin..=strip).contains(&high) { high.max(0.0) } else { high + margin };
    [lower, upper]
}

/// The number 1, 2 or 5 times a power of ten that is nearest (by ratio).
fn round_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let digit = match step / power {
        ratio if ratio < 1.42 => 1.0,
        ratio if ratio < 3.17 => 2.0,
        ratio if ratio < 7.08 => 5.0,
        _ => 10.0,
    };
    digit * power
}

/// The power of ten (a multiple of three) taken out of labels whose largest has this size; 0 for sizes easily read.
fn common_exponent(size: f64) -> i32 {
    if size == 0.0 || (1e-2..1e5).contains(&size) {
        return 0;
    }
    3 * ((size.log10() + 1e-9) / 3.0).floor() as i32
}

/// A number with as many decimals as its step needs, and a true minus sign.
fn plain_label(value: f64, step: f64, exponent: i32) -> String {
    let power = 10_f64.powi(exponent);
    let decimals = (-(step / power).log10() - 1e-9).ceil().clamp(0.0, 15.0) as usize;
    let text = format!("{:.decimals$}", value / power);
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().any(|digit| ('1'..='9').contains(&digit)) => format!("−{digits}"),
        Some(digits) => digits.to_owned(),
        None => text,
    }
}

/// A decade: written out if all decades of the axis are easily read, as a power of ten otherwise.
fn power_label(power: i32, all: &[i32]) -> String {
    if all.iter().any(|other| !(-3..=4).contains(other)) {
        return power_of_ten(power);
    }
    let decimals = (-power).max(0) as usize;
    format!("{:.decimals$}", 10_f64.powi(power))
}

/// Ten to a power, with raised digits.
fn power_of_ten(power: i32) -> String {
    let digits = power.to_string();
    let raised = digits.chars().map(|character| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        _ => '⁰',
    });
    format!("10{}", raised.collect::<String>())
}

/// Twice to nine times every power of ten from the first to before the last.
fn minor_decades(first: i32, last: i32) -> Vec<f64> {
    (first..last).flat_map(|power| (2..=9).map(move |digit| f64::from(digit) * 10_f64.powi(power))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn loose_ticks_cover_the_data() {
        let ranges =
            [[0.0, 12.3], [-4.7, 3.1], [1e-7, 9e-7], [0.1, 0.3], [1e6, 1e6 + 2.0], [-1e150, 1e150], [0.0, 5e-140]];
        for range in ranges {
            for intervals in 1..9 {
                let axis = Axis::loose(range, AxisScale::Linear, intervals);
                let slack = 1.001 * END_STRIP * (range[1] - range[0]);
                assert!(axis.low <= range[0] && axis.high >= range[1], "{range:?} {axis:?}");
                assert!(axis.ticks[0].value <= range[0] + slack, "{range:?} {axis:?}");
                assert!(axis.ticks[axis.ticks.len() - 1].value >= range[1] - slack, "{range:?} {axis:?}");
                assert!(axis.ticks.len() <= 2 * intervals + 3, "{range:?} {intervals} {axis:?}");
                assert!(axis.ticks.windows(2).all(|pair| pair[0].label != pair[1].label), "{range:?} {axis:?}");
            }
        }
    }

    #[test]
    fn loose_logarithmic_ticks_cover_the_data() {
        let axis = Axis::loose([0.02, 350.0], AxisScale::Logarithmic, 8);
        assert_eq!(labels(&axis), ["0.01", "0.1", "1", "10", "100", "1000"]);
        assert_eq!(axis.minor.len(), 5 * 8);
        assert!((axis.fraction(1.0) - 0.4).abs() < 1e-12);
        let one_value = Axis::loose([10.0, 10.0], AxisScale::Logarithmic, 8);
        assert_eq!([one_value.low, one_value.high], [10.0, 100.0]);
    }

    #[test]
    fn tight_ticks_lie_within_the_range() {
        for range in [[0.0, 1.0], [0.3, 0.9], [-7.2, -6.9], [0.0, 137.0], [4.1, 4.9]] {
            for intervals in 1..9 {
                let axis = Axis::tight(range, intervals);
                assert_eq!([axis.low, axis.high], range);
                assert!(axis.ticks.len() >= 2, "{range:?} {axis:?}");
                assert!(axis.ticks.iter().all(|tick| (-1e-9..=1.0 + 1e-9).contains(&axis.fraction(tick.value))));
            }
        }
    }

    #[test]
    fn labels_have_the_decimals_they_need() {
        assert_eq!(labels(&Axis::loose([0.0, 1.0], AxisScale::Linear, 5)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&Axis::loose([-10.0, 10.0], AxisScale::Linear, 4)), ["−10", "−5", "0", "5", "10"]);
    }

    #[test]
    fn large_and_small_numbers_share_a_power_of_ten_in_the_title() {
        let large = Axis::loose([0.0, 400_000.0], AxisScale::Linear, 4);
        assert_eq!(labels(&large), ["0", "100", "200", "300", "400"]);
        assert_eq!(large.title("time (s)"), "time (×10³ s)");
        let small = Axis::loose([0.0, 0.004], AxisScale::Linear, 4);
        assert_eq!(labels(&small), ["0", "1", "2", "3", "4"]);
        assert_eq!(small.title("strain"), "strain (×10⁻³)");
        assert_eq!(small.title("strain (–)"), "strain (×10⁻³)");
    }

    #[test]
    fn a_constant_gets_a_range_around_it() {
        assert_eq!(widened([0.0, 0.0]), [-1.0, 1.0]);
        assert_eq!(widened([100.0, 100.0]), [95.0, 105.0]);
        assert_eq!(widened([1.0, 2.0]), [1.0, 2.0]);
    }

    #[test]
    fn a_plateau_gets_a_margin_but_zero_stays_the_end() {
        assert_eq!(padded([0.0, 100.0]), [0.0, 103.0]);
        let heaved = padded([-0.1, 42.0]);
        assert_eq!(heaved[0], -0.1);
        let axis = Axis::loose(heaved, AxisScale::Linear, 5);
        assert_eq!(labels(&axis), ["0", "10", "20", "30", "40", "50"]);
        assert_eq!(axis.low, -0.1);
    }

    #[test]
    fn values_that_cannot_be_drawn_do_not_count() {
        let values = [f64::NAN, 3.0, f64::INFINITY, -2.0, 0.0];
        assert_eq!(range_of(values.into_iter(), AxisScale::Linear), Some([-2.0, 3.0]));
        assert_eq!(range_of(values.into_iter(), AxisScale::Logarithmic), Some([3.0, 3.0]));
        assert_eq!(range_of([f64::NAN].into_iter(), AxisScale::Linear), None);
    }
}
