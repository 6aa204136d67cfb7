//! The colour map viridis: perceptually uniform, readable for colour-blind people and in grey print.

use super::style::Color;

/// Number of distinct colours: enough to look continuous, few enough to draw all particles of one colour as one path.
pub(super) const LEVELS: usize = 200;

/// Coefficients of 1, t, t², … for red, green and blue: a least-squares fit of degree 6 to the published table.
///
/// # Reference
///
/// Table: Smith and van der Walt (2015), matplotlib colour maps (CC0). Fit: Zucker (2019), shadertoy WlfXRN (CC0).
const COEFFICIENTS: [[f64; 3]; 7] = [
    [0.277_727_327, 0.005_407_345, 0.334_099_805],
    [0.105_093_043, 1.404_613_530, 1.384_590_163],
    [-0.330_861_829, 0.214_847_559, 0.095_095_163],
    [-4.634_230_499, -5.799_100_973, -19.332_440_956],
    [6.228_269_936, 14.179_933_367, 56.690_552_601],
    [4.776_384_998, -13.745_145_378, -65.353_032_633],
    [-5.435_455_856, 4.645_852_612, 26.312_435_250],
];

/// The colour at a place between 0 (dark violet) and 1 (yellow).
pub(super) fn viridis(place: f64) -> Color {
    let place = place.clamp(0.0, 1.0);
    let mut channels = [0; 3];
    for (index, channel) in channels.iter_mut().enumerate() {
        let intensity = COEFFICIENTS.iter().rev().fold(0.0, |sum, powers| sum * place + powers[index]);
        *channel = (255.0 * intensity.clamp(0.0, 1.0)).round() as u8;
    }
    Color(channels)
}

/// The level, 0 to [`LEVELS`] − 1, of a value within a range; values outside get the nearest end.
pub(super) fn level(value: f64, [low, high]: [f64; 2]) -> usize {
    let place = ((value - low) / (high - low)).clamp(0.0, 1.0);
    ((place * LEVELS as f64) as usize).min(LEVELS - 1)
}

/// The colour of a level: that of its middle.
pub(super) fn level_color(level: usize) -> Color {
    viridis((level as f64 + 0.5) / LEVELS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries of the published table, to within 3 % of full intensity.
    #[test]
    fn fit_agrees_with_published_table() {
        let table = [
            (0.0, [68, 1, 84]),
            (0.25, [59, 82, 139]),
            (0.5, [33, 145, 140]),
            (0.75, [94, 201, 98]),
            (1.0, [253, 231, 37]),
        ];
        for (place, expected) in table {
            let Color(found) = viridis(place);
            for channel in 0..3 {
                assert!((f64::from(found[channel]) - f64::from(expected[channel])).abs() <= 8.0, "{place}: {found:?}");
            }
        }
    }

    #[test]
    fn levels_cover_the_range_and_its_outside() {
        assert_eq!(level(0.0, [0.0, 2.0]), 0);
        assert_eq!(level(2.0, [0.0, 2.0]), LEVELS - 1);
        assert_eq!(level(-9.0, [0.0, 2.0]), 0);
        assert_eq!(level(9.0, [0.0, 2.0]), LEVELS - 1);
        assert_eq!(level(1.0, [0.0, 2.0]), LEVELS / 2);
    }
}
