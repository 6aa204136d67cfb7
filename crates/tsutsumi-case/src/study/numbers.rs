//! The numbers of a figure as a file: one column per curve, over the times of all of them.

use super::series::Series;
use super::table::{into_bytes, precise};

/// Times nearer to each other than this part of themselves are one: runs end on time but for the rounding of a sum.
const SAME_TIME: f64 = 1e-9;

/// The curves of a figure as CSV: `time (s)` and one column for each; cells are empty where a curve has no point.
pub(super) fn curves_csv(curves: &[(String, Series)]) -> Result<Vec<u8>, csv::Error> {
    let mut times: Vec<f64> = curves.iter().flat_map(|(_, series)| series.time.iter().copied()).collect();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|later, earlier| is_same(*later, *earlier));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = curves.iter().map(|(name, _)| name.as_str());
    writer.write_record(std::iter::once("time (s)").chain(names))?;
    let mut places = vec![0; curves.len()];
    for time in times {
        let mut row = vec![precise(time)];
        for ((_, series), place) in curves.iter().zip(&mut places) {
            let here = series.time.get(*place).is_some_and(|own| is_same(*own, time));
            let value = series.value.get(*place).filter(|value| here && value.is_finite());
            row.push(value.map_or_else(String::new, |value| precise(*value)));
            *place += usize::from(here);
        }
        writer.write_record(row)?;
    }
    into_bytes(writer)
}

fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME_TIME * one.abs().max(other.abs())
}

/// A table of numbers as CSV.
pub(super) fn columns_csv<const N: usize>(
    head: [&str; N],
    rows: impl Iterator<Item = [f64; N]>,
) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(head)?;
    for row in rows {
        writer.write_record(row.map(precise))?;
    }
    into_bytes(writer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_stand_side_by_side_over_all_times() {
        let series = |time: &[f64], value: &[f64]| Series { time: time.to_vec(), value: value.to_vec() };
        let curves = [
            ("a".to_owned(), series(&[0.0, 1.0, 2.0], &[1.0, 2.0, f64::NAN])),
            ("b".to_owned(), series(&[1.0 + 1e-12, 3.0], &[5.0, 6.0])),
        ];
        let text = String::from_utf8(curves_csv(&curves).unwrap()).unwrap();
        let short = text.replace(".0000000000000000e0", "");
        assert_eq!(short, "time (s),a,b\n0,1,\n1,2,5\n2,,\n3,,6\n");
    }
}
