//! Collapse of a column of water on a dry bed: Ritter's solution and the experiments of Martin and Moyce.

use schemars::JsonSchema;
use serde::Deserialize;

/// Water behind a dam that vanishes, on a dry horizontal bed without friction, by the shallow water equations.
///
/// # Equation
///
/// ```text
/// h = (2 c_0 − x/t)²/(9 g)        v = ⅔ (c_0 + x/t)        −c_0 t ≤ x ≤ 2 c_0 t        c_0 = √(g h_0)
/// ```
///
/// `x` is positive away from the water, zero at the dam. Shallow water theory neglects vertical acceleration: the real
/// front starts more slowly and stays behind, so that 2 √(g h_0) is an upper bound for its speed.
///
/// # Reference
///
/// Ritter, Zeitschrift des Vereines Deutscher Ingenieure 36 (1892); recalled, and tested against the equations
/// themselves.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DamBreak {
    /// Depth of the water h_0 (m).
    pub depth: f64,
    /// Gravity g (m/s²).
    pub gravity: f64,
}

impl DamBreak {
    /// The position (m) of the front at a time (s).
    pub fn front(&self, time: f64) -> f64 {
        2.0 * self.celerity() * time
    }

    /// The depth h of the water (m) at a position (m), at a time (s).
    pub fn depth(&self, position: f64, time: f64) -> f64 {
        let celerity = self.celerity();
        if position <= -celerity * time {
            self.depth
        } else if position >= self.front(time) {
            0.0
        } else {
            (2.0 * celerity - position / time).powi(2) / (9.0 * self.gravity)
        }
    }

    /// The velocity v of the water (m/s) at a position (m), at a time (s); zero where there is none.
    pub fn velocity(&self, position: f64, time: f64) -> f64 {
        let celerity = self.celerity();
        if position <= -celerity * time || position >= self.front(time) {
            0.0
        } else {
            2.0 / 3.0 * (celerity + position / time)
        }
    }

    /// c_0, the speed at which the water behind the dam learns of it (m/s).
    fn celerity(&self) -> f64 {
        (self.gravity * self.depth).sqrt()
    }
}

/// Front of a column twice as high as wide (n² = 2, a = 2.25 in): time t √(2g/a) (–), position z/a (–).
///
/// Martin & Moyce, Philosophical Transactions of the Royal Society A 244 (1952) 312–324; taken from the validation data
/// of public codes, not from the article. Codes disagree on whether time is scaled with √(2g/a) or √(g/a). The
/// experiments start about 0.05 s late, because of the diaphragm.
pub const MARTIN_MOYCE_FRONT: [(f64, f64); 15] = [
    (0.832, 1.217),
    (1.219, 1.474),
    (1.997, 2.292),
    (2.547, 2.995),
    (3.345, 4.134),
    (4.034, 4.944),
    (4.418, 5.881),
    (5.091, 6.980),
    (5.685, 7.945),
    (6.306, 8.966),
    (6.822, 9.986),
    (7.439, 10.963),
    (8.031, 11.977),
    (8.633, 13.005),
    (9.237, 13.970),
];

/// Front of the column early on, in finer steps: time t √(2g/a) (–), position z/a (–). Source as of
/// [`MARTIN_MOYCE_FRONT`].
pub const MARTIN_MOYCE_FRONT_EARLY: [(f64, f64); 15] = [
    (0.41, 1.11),
    (0.84, 1.22),
    (1.19, 1.44),
    (1.43, 1.67),
    (1.63, 1.89),
    (1.83, 2.11),
    (1.98, 2.33),
    (2.20, 2.56),
    (2.32, 2.78),
    (2.51, 3.00),
    (2.65, 3.22),
    (2.83, 3.44),
    (2.98, 3.67),
    (3.11, 3.89),
    (3.33, 4.11),
];

/// Height of what is left of the column: time t √(g/a) (–), height over the initial height (–). Source as of
/// [`MARTIN_MOYCE_FRONT`]; mind the other scale of time.
pub const MARTIN_MOYCE_HEIGHT: [(f64, f64); 17] = [
    (0.56, 0.94),
    (0.77, 0.89),
    (0.93, 0.83),
    (1.08, 0.78),
    (1.28, 0.72),
    (1.46, 0.67),
    (1.66, 0.61),
    (1.84, 0.56),
    (2.00, 0.50),
    (2.21, 0.44),
    (2.45, 0.39),
    (2.70, 0.33),
    (3.06, 0.28),
    (3.44, 0.22),
    (4.20, 0.17),
    (5.25, 0.11),
    (7.40, 0.06),
];

#[cfg(test)]
mod tests {
    use super::*;

    const DAM: DamBreak = DamBreak { depth: 1.5, gravity: 9.81 };

    /// h_t + (h v)_x = 0 and v_t + v v_x + g h_x = 0 by central differences, whose error and rounding stay below 1e-7
    /// of the terms, which are of order one to ten.
    #[test]
    fn it_solves_the_shallow_water_equations() {
        let step = 1e-4;
        for (x, t) in [(-2.0, 0.8), (0.0, 0.8), (3.0, 0.8), (3.0, 2.0)] {
            let by_time = |f: &dyn Fn(f64, f64) -> f64| (f(x, t + step) - f(x, t - step)) / (2.0 * step);
            let by_position = |f: &dyn Fn(f64, f64) -> f64| (f(x + step, t) - f(x - step, t)) / (2.0 * step);
            let depth = |x: f64, t: f64| DAM.depth(x, t);
            let velocity = |x: f64, t: f64| DAM.velocity(x, t);
            let mass = by_time(&depth) + by_position(&|x, t| depth(x, t) * velocity(x, t));
            let momentum = by_time(&velocity) + velocity(x, t) * by_position(&velocity) + 9.81 * by_position(&depth);
            assert!(mass.abs() < 1e-7 && momentum.abs() < 1e-6, "{mass}, {momentum} at {x} m, {t} s");
        }
    }

    /// What stands beyond the dam has left the reservoir: Simpson's rule is exact for a parabola.
    #[test]
    fn no_water_is_lost() {
        let time = 0.7;
        let (back, front) = (-(9.81_f64 * 1.5).sqrt() * time, DAM.front(time));
        let simpson = |a: f64, b: f64| {
            (b - a) / 6.0 * (DAM.depth(a, time) + 4.0 * DAM.depth(0.5 * (a + b), time) + DAM.depth(b, time))
        };
        assert!((simpson(0.0, front) - (-1.5 * back - simpson(back, 0.0))).abs() < 1e-12);
        assert_eq!((DAM.depth(front, time), DAM.depth(back, time)), (0.0, 1.5));
    }

    /// The measured front stays behind Ritter's, which started at z = a with h_0 = n² a = 2 a: z/a < 1 + 2 T.
    #[test]
    fn the_measured_front_stays_behind_ritters() {
        for (time, position) in MARTIN_MOYCE_FRONT.into_iter().chain(MARTIN_MOYCE_FRONT_EARLY) {
            // T = t √(2g/a), and the front's speed is 2 √(2 g a).
            assert!(position < 1.0 + 2.0 * time);
        }
        // A misprinted digit would break the order: fronts advance, heights fall.
        for front in [MARTIN_MOYCE_FRONT, MARTIN_MOYCE_FRONT_EARLY] {
            assert!(front.is_sorted_by(|a, b| a.0 < b.0 && a.1 < b.1));
        }
        assert!(MARTIN_MOYCE_HEIGHT.is_sorted_by(|a, b| a.0 < b.0 && a.1 > b.1));
    }

    /// The two series of the front are of one experiment in one scale of time: interpolated in the coarse one, the fine
    /// one stays within a tenth of the column's width (with the other scale it would be off by its own size).
    #[test]
    fn the_two_series_of_the_front_agree() {
        let mut num_compared = 0;
        for (time, position) in MARTIN_MOYCE_FRONT_EARLY {
            let pair = MARTIN_MOYCE_FRONT.windows(2).find(|pair| pair[0].0 <= time && time <= pair[1].0);
            if let Some(&[from, to]) = pair {
                let share = (time - from.0) / (to.0 - from.0);
                let between = from.1 + share * (to.1 - from.1);
                assert!((position - between).abs() < 0.1, "{position} is not {between} at {time}");
                num_compared += 1;
            }
        }
        assert_eq!(num_compared, 14, "only the first time is before the coarse series");
    }
}
