//! Numbers in time: the history of a run, and what is read off it.

use std::path::Path;

use super::quantity::Quantity;

/// One quantity in time.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Series {
    /// Times (s), increasing.
    pub(super) time: Vec<f64>,
    /// One value for each time, in SI units.
    pub(super) value: Vec<f64>,
}

impl Series {
    /// The value at a time (s), linear in between; none outside of the times.
    pub(super) fn at(&self, time: f64) -> Option<f64> {
        let last = *self.time.last()?;
        // Runs end at the same time but for the rounding of a sum of steps.
        let time = if (time - last).abs() <= 1e-9 * last.abs() { last } else { time };
        let after = self.time.partition_point(|&known| known < time);
        match (after.checked_sub(1), self.time.get(after)) {
            (_, Some(&exact)) if exact == time => Some(self.value[after]),
            (Some(before), Some(_)) => {
                let [t0, t1] = [self.time[before], self.time[after]];
                let share = (time - t0) / (t1 - t0);
                Some(self.value[before] + share * (self.value[after] - self.value[before]))
            }
            _ => None,
        }
    }

    /// The change from each time to the next over the time between, given at the middle.
    ///
    /// ```text
    /// ẋ((t_i + t_{i+1})/2) = (x_{i+1} − x_i)/(t_{i+1} − t_i)
    /// ```
    pub(super) fn rate(&self) -> Series {
        let pairs = self.time.windows(2).zip(self.value.windows(2));
        let (time, value) = pairs.map(|(t, x)| (0.5 * (t[0] + t[1]), (x[1] - x[0]) / (t[1] - t[0]))).unzip();
        Series { time, value }
    }

    /// The part between two times (s), both included.
    pub(super) fn within(&self, window: Option<[f64; 2]>) -> Series {
        let Some([from, to]) = window else { return self.clone() };
        let points = self.time.iter().zip(&self.value).filter(|(time, _)| (from..=to).contains(*time));
        let (time, value) = points.map(|(time, value)| (*time, *value)).unzip();
        Series { time, value }
    }
}

/// `history.csv` in memory.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct History {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl History {
    /// Reads the history of a results folder.
    ///
    /// # Errors
    /// What is wrong with the file, in words.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let told = |error: csv::Error| format!("cannot read `{}`: {error}", path.display());
        let mut reader = csv::Reader::from_path(path).map_err(told)?;
        let names: Vec<String> = reader.headers().map_err(told)?.iter().map(str::to_owned).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for row in reader.records() {
            for (column, cell) in columns.iter_mut().zip(&row.map_err(told)?) {
                let number = cell.parse().map_err(|_| format!("`{}` holds `{cell}`, no number", path.display()))?;
                column.push(number);
            }
        }
        Ok(History { names, columns })
    }

    fn column(&self, name: &str) -> Option<&Vec<f64>> {
        let place = self.names.iter().position(|known| known == name)?;
        Some(&self.columns[place])
    }

    /// The times of the rows (s).
    pub(super) fn times(&self) -> &[f64] {
        self.column("time").map_or(&[], Vec::as_slice)
    }

    /// A column in time.
    pub(super) fn series(&self, column: &str) -> Option<Series> {
        Some(Series { time: self.times().to_vec(), value: self.column(column)?.clone() })
    }

    /// A quantity in time.
    pub(super) fn quantity(&self, quantity: &Quantity) -> Option<Series> {
        let series = self.series(&quantity.column)?;
        Some(if quantity.is_rate { series.rate() } else { series })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parabola() -> Series {
        let time: Vec<f64> = [0.0, 1.0, 3.0, 4.0].to_vec();
        let value = time.iter().map(|t| t * t).collect();
        Series { time, value }
    }

    #[test]
    fn between_its_times_a_series_is_linear_and_outside_there_is_nothing() {
        let series = parabola();
        assert_eq!([series.at(1.0), series.at(2.0), series.at(0.0)], [Some(1.0), Some(5.0), Some(0.0)]);
        assert_eq!([series.at(-0.1), series.at(4.1), Series::default().at(0.0)], [None; 3]);
        assert_eq!(series.at(4.0 + 1e-10), Some(16.0), "rounding at the end");
    }

    /// The difference quotient of a parabola is its derivative at the middle, exactly.
    #[test]
    fn the_rate_stands_at_the_middle() {
        let rate = parabola().rate();
        assert_eq!(rate.time, [0.5, 2.0, 3.5]);
        assert_eq!(rate.value, [1.0, 4.0, 7.0]);
        assert_eq!(Series::default().rate(), Series::default());
    }

    #[test]
    fn a_window_includes_its_ends() {
        assert_eq!(parabola().within(Some([1.0, 3.0])).time, [1.0, 3.0]);
    }
}
