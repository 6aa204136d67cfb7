//! Tests of whole figures, by reading back what was drawn.

use super::*;

const NASTY: [f64; 9] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, 0.0, -0.0, -3.0, 1e-200];

fn page_of(figure: &impl Figure) -> Drawing {
    figure.layout(&Typeface::embedded().unwrap())
}

/// All numbers of the paths of one class.
fn numbers(svg: &str, class: &str) -> Vec<Vec<f64>> {
    let document = roxmltree::Document::parse(svg).unwrap();
    let paths = document.descendants().filter(|node| node.attribute("class") == Some(class));
    let split = |text: &str| {
        let parts = text.split(|character: char| !"0123456789.-".contains(character));
        parts.filter(|part| !part.is_empty()).map(|part| part.parse().unwrap()).collect()
    };
    paths.map(|node| split(node.attribute("d").unwrap())).collect()
}

/// The words of an SVG, in the order of drawing.
fn words(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).unwrap();
    document.descendants().filter_map(|node| node.attribute("aria-label").map(String::from)).collect()
}

/// Left, top, right, bottom of a path `M x y H x V y H x Z`.
fn sides(rectangle: &[f64]) -> [f64; 4] {
    [rectangle[0], rectangle[1], rectangle[2], rectangle[3]]
}

fn line_chart(x: Vec<f64>, y: Vec<f64>) -> LineChart {
    let curve = Curve { label: "a < b & \"c\"".into(), x, y, style: CurveStyle::Line, place: None };
    LineChart { x_label: "time (s)".into(), y_label: "σ′ (kPa)".into(), curves: vec![curve], ..LineChart::default() }
}

/// A body of 4 by 8 particles that fills the grid from the origin to its size.
fn body([width, height]: [f64; 2]) -> ParticleChart {
    let half = [width / 8.0, height / 16.0];
    let mut chart = ParticleChart { grid_x: vec![0.0, width], grid_y: vec![0.0, height], ..ParticleChart::default() };
    for index in 0..32 {
        let [column, row] = [f64::from(index % 4), f64::from(index / 4)];
        chart.position.push([(2.0 * column + 1.0) * half[0], (2.0 * row + 1.0) * half[1]]);
        chart.half_size.push(half);
        chart.value.push(f64::from(index));
    }
    chart
}

/// An empty folder of its own for a test.
fn empty_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("tsutsumi-figures-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn the_curve_lies_in_the_frame_and_grows_downwards_if_told() {
    let mut chart = line_chart(vec![0.0, 10.0, 20.0], vec![0.0, 30.0, 41.0]);
    for y_down in [false, true] {
        chart.y_down = y_down;
        let svg = page_of(&chart).to_svg();
        let [left, top, right, bottom] = sides(&numbers(&svg, "frame")[0]);
        let curve = &numbers(&svg, "curve")[0];
        for point in curve.chunks_exact(2) {
            assert!((left..=right).contains(&point[0]) && (top..=bottom).contains(&point[1]), "{point:?}");
        }
        assert_eq!(curve[5] > curve[1], y_down);
    }
}

/// A second curve over the same times, with the label of the first.
fn second(y: Vec<f64>) -> SecondAxis {
    let curves = line_chart(vec![0.0, 10.0, 20.0], y).curves;
    SecondAxis { label: "rate (mm/s)".into(), curves, ..SecondAxis::default() }
}

#[test]
fn a_curve_below_has_its_own_frame_over_the_same_axis() {
    let mut chart = line_chart(vec![0.0, 10.0, 20.0], vec![0.0, 30.0, 41.0]);
    chart.below = Some(second(vec![0.0, 3e-3, 4.1e-3]));
    let svg = page_of(&chart).to_svg();
    let [upper, lower] = [0, 1].map(|index| sides(&numbers(&svg, "frame")[index]));
    assert!(upper[3] < lower[1] && upper[0] == lower[0] && upper[2] == lower[2], "{upper:?} {lower:?}");
    let [above, below] = [0, 1].map(|index| numbers(&svg, "curve")[index].clone());
    for (one, other) in above.chunks_exact(2).zip(below.chunks_exact(2)) {
        // The same shape, moved down: rounded to hundredths of a point.
        assert!((one[0] - other[0]).abs() < 0.011, "{one:?} {other:?}");
        assert!((one[1] - upper[1] - (other[1] - lower[1])).abs() < 0.021, "{one:?} {other:?}");
    }
    let words = words(&svg);
    let count = |word: &str| words.iter().filter(|known| *known == word).count();
    assert_eq!([count("time (s)"), count("20"), count("a < b & \"c\"")], [1, 2, 1], "{words:?}");
    assert!(words.contains(&"rate (×10⁻³ mm/s)".to_owned()), "{words:?}");
}

#[test]
fn a_curve_at_the_right_follows_the_axis_there() {
    let mut chart = line_chart(vec![0.0, 10.0, 20.0], vec![0.0, 30.0, 40.0]);
    chart.right = Some(SecondAxis { down: true, ..second(vec![0.0, 3.0, 4.0]) });
    let svg = page_of(&chart).to_svg();
    let [left, top, right, bottom] = sides(&numbers(&svg, "frame")[0]);
    let curves = numbers(&svg, "curve");
    // The axes are ten to one, and one of them is turned: the curves mirror each other.
    for (one, other) in curves[0].chunks_exact(2).zip(curves[1].chunks_exact(2)) {
        assert!((one[0] - other[0]).abs() < 0.011 && (left..=right).contains(&one[0]));
        assert!((one[1] - top - (bottom - other[1])).abs() < 0.021, "{one:?} {other:?}");
    }
    assert!(words(&svg).contains(&"rate (mm/s)".to_owned()));
}

#[test]
fn tick_numbers_stand_where_their_values_are() {
    let svg = page_of(&line_chart(vec![0.0, 20.0], vec![0.0, 40.0])).to_svg();
    let [left, top, right, bottom] = sides(&numbers(&svg, "frame")[0]);
    assert!(words(&svg).contains(&String::from("20")) && words(&svg).contains(&String::from("40")));
    let curve = &numbers(&svg, "curve")[0];
    // The data end at the last tick across; upwards the plateau margin adds an interval.
    assert_eq!([curve[0], curve[1], curve[2]], [left, bottom, right]);
    assert!(curve[3] > top);
}

#[test]
fn one_metre_is_equally_long_on_both_axes() {
    for size in [[1.0, 10.0], [10.0, 10.0], [20.0, 3.0], [100.0, 1.0]] {
        let svg = page_of(&body(size)).to_svg();
        let [left, top, right, bottom] = sides(&numbers(&svg, "frame")[0]);
        let grid = &numbers(&svg, "grid")[0];
        // Two upright lines `M x y V y`, then two lying ones `M x y H x`.
        let scale = [(grid[3] - grid[0]) / size[0], (grid[7] - grid[10]).abs() / size[1]];
        let rounding = 0.02 / size[0].min(size[1]);
        assert!((scale[0] - scale[1]).abs() <= rounding, "{size:?}: {scale:?}");
        assert!(right > left && bottom > top);
    }
}

#[test]
fn particles_have_their_size_and_place() {
    let svg = page_of(&body([4.0, 8.0])).to_svg();
    let [left, top, right, bottom] = sides(&numbers(&svg, "frame")[0]);
    let scale = (right - left) / 4.0;
    assert!((scale - (bottom - top) / 8.0).abs() < 0.01);
    // The first particle is the lowest left one; its gap takes 0.15 pt off each side.
    let first = &numbers(&svg, "particles")[0];
    assert!((first[0] - (left + 0.15)).abs() < 0.02 && (first[2] - (left + scale - 0.15)).abs() < 0.02, "{first:?}");
    assert!((first[3] - (bottom - 0.15)).abs() < 0.02, "{first:?}");
}

#[test]
fn degenerate_curves_give_a_picture() {
    for scale in [AxisScale::Linear, AxisScale::Logarithmic] {
        for style in [CurveStyle::Line, CurveStyle::Markers] {
            for [one, other] in NASTY.iter().flat_map(|one| NASTY.map(|other| [*one, other])) {
                for points in [vec![], vec![one], vec![one, other], vec![1.0, one, 2.0, other, 5.0]] {
                    let mut chart = line_chart(points.clone(), points);
                    (chart.x_scale, chart.y_scale, chart.curves[0].style) = (scale, scale, style);
                    let svg = page_of(&chart).to_svg();
                    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{chart:?}");
                }
            }
        }
    }
    let empty = page_of(&LineChart::default());
    assert!(words(&empty.to_svg()).contains(&String::from("no data")));
    assert!(empty.to_png().is_ok());
}

#[test]
fn degenerate_particles_give_a_picture() {
    for [one, other] in NASTY.iter().flat_map(|one| NASTY.map(|other| [*one, other])) {
        let chart = ParticleChart {
            position: vec![[one, other], [0.0, one]],
            half_size: vec![[other, one], [1e-3, other]],
            value: vec![one, other],
            value_range: Some([other, one]),
            grid_x: vec![one],
            outline: vec![[[one, 0.0], [other, 1.0]]],
            ..ParticleChart::default()
        };
        let page = page_of(&chart);
        let svg = page.to_svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{chart:?}");
        assert!(page.width < 600.0 && page.height < 600.0, "{chart:?}");
    }
}

#[test]
fn missing_values_and_positions_are_told() {
    let mut chart = body([1.0, 1.0]);
    chart.value[3] = f64::NAN;
    chart.position[5][1] = f64::NAN;
    let words = words(&page_of(&chart).to_svg());
    assert!(words.contains(&String::from("grey: 1 without value")), "{words:?}");
    assert!(words.contains(&String::from("not drawn: 1 without position")), "{words:?}");
}

#[test]
fn values_beyond_a_given_range_point_the_bar() {
    let mut chart = body([1.0, 1.0]);
    assert!(numbers(&page_of(&chart).to_svg(), "beyond").is_empty());
    chart.value_range = Some([-1.0, 10.0]);
    assert_eq!(numbers(&page_of(&chart).to_svg(), "beyond").len(), 2);
}

#[test]
fn a_legend_without_free_place_stands_above_the_frame() {
    let waves: Vec<f64> = (0..400).map(|index| (0.7 * f64::from(index)).sin()).collect();
    let chart = line_chart((0..400).map(f64::from).collect(), waves);
    let svg = page_of(&chart).to_svg();
    assert!(numbers(&svg, "legend").is_empty());
    // The sample of the legend is the last curve drawn.
    let sample = numbers(&svg, "curve").pop().unwrap();
    assert!(sample[1] < sides(&numbers(&svg, "frame")[0])[1]);
}

#[test]
fn a_legend_inside_stands_clear_of_the_curve() {
    let falling: Vec<f64> = (0..100).map(|index| (-0.1 * f64::from(index)).exp()).collect();
    let svg = page_of(&line_chart((0..100).map(f64::from).collect(), falling)).to_svg();
    let [left, top, right, bottom] = sides(&numbers(&svg, "legend")[0]);
    for point in numbers(&svg, "curve")[0].chunks_exact(2) {
        assert!(!((left..=right).contains(&point[0]) && (top..=bottom).contains(&point[1])), "{point:?}");
    }
}

#[test]
fn both_files_are_written_and_the_same_each_time() {
    let folder = empty_folder("same");
    let chart = body([1.0, 10.0]);
    chart.save(&folder.join("step-0.5")).unwrap();
    let first = [".svg", ".png"].map(|ending| fs::read(with_ending(&folder.join("step-0.5"), ending)).unwrap());
    chart.save(&folder.join("step-0.5")).unwrap();
    let second = [".svg", ".png"].map(|ending| fs::read(with_ending(&folder.join("step-0.5"), ending)).unwrap());
    assert!(first == second);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 2);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn errors_name_the_figure_and_leave_no_file() {
    let folder = empty_folder("errors");
    let short = line_chart(vec![0.0, 1.0], vec![0.0]).save(&folder.join("short")).unwrap_err();
    assert!(matches!(&short, FigureError::Length { expected: 2, found: 1, .. }), "{short}");
    assert!(short.to_string().contains("short"), "{short}");
    let mut chart = body([1.0, 1.0]);
    chart.value.pop();
    assert!(matches!(chart.save(&folder.join("value")), Err(FigureError::Length { expected: 32, found: 31, .. })));
    let missing = folder.join("missing").join("figure");
    assert!(matches!(body([1.0, 1.0]).save(&missing), Err(FigureError::Write { .. })));
    // A folder that has the name of the file: the partial file is written, but cannot be moved there.
    fs::create_dir(folder.join("taken.svg")).unwrap();
    assert!(matches!(body([1.0, 1.0]).save(&folder.join("taken")), Err(FigureError::Write { .. })));
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
    fs::remove_dir_all(folder).unwrap();
}
