//! The data of an SVG path, in few characters.

use super::curve::Point;

/// A line through points, to a tenth of a pixel. Steps from point to point are shorter to write than places; as whole
/// tenths they add up without error. A single point becomes a dot.
pub(super) fn path_data(points: &[Point]) -> String {
    let whole = |point: &Point| ((point.0 * 10.0).round() as i64, (point.1 * 10.0).round() as i64);
    let mut points = points.iter().map(whole);
    let Some(first) = points.next() else { return String::new() };
    let mut data = format!("M{} {}", tenth(first.0), tenth(first.1));
    let mut last = first;
    let mut steps = 0;
    for point in points {
        let (x, y) = (tenth(point.0 - last.0), tenth(point.1 - last.1));
        data += if steps == 0 { "l" } else { " " };
        data += &if y.starts_with('-') { format!("{x}{y}") } else { format!("{x} {y}") };
        (last, steps) = (point, steps + 1);
    }
    if steps == 0 {
        data += "h0";
    }
    data
}

/// A number to a tenth.
pub(super) fn tenths(value: f64) -> String {
    tenth((value * 10.0).round() as i64)
}

fn tenth(tenths: i64) -> String {
    let sign = if tenths < 0 { "-" } else { "" };
    match (tenths.unsigned_abs() / 10, tenths.unsigned_abs() % 10) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, part) => format!("{sign}.{part}"),
        (whole, part) => format!("{sign}{whole}.{part}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_between_points_add_up() {
        let points: Vec<Point> =
            (0..100).map(|index| (f64::from(index) * 0.333, f64::from(index % 7) * 1.77)).collect();
        let data = path_data(&points).replace('-', " -").replace(['M', 'l'], " ");
        let numbers: Vec<f64> = data.split_whitespace().map(|number| number.parse().unwrap()).collect();
        let (x, y) = (numbers.iter().step_by(2).sum::<f64>(), numbers.iter().skip(1).step_by(2).sum::<f64>());
        let last = points[99];
        assert!((x - last.0).abs() < 0.051 && (y - last.1).abs() < 0.051, "{x} {y} for {last:?}");
    }

    #[test]
    fn short_and_exact() {
        assert_eq!(path_data(&[(1.0, 2.25), (1.5, -3.0), (1.4, 0.0)]), "M1 2.3l.5-5.3 -.1 3");
        assert_eq!((path_data(&[(1.0, 2.0)]), path_data(&[])), ("M1 2h0".to_owned(), String::new()));
    }
}
