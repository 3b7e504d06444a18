//! A curve on a screen: what of its samples must be drawn so that it looks as if all were.

use std::collections::BTreeSet;

/// A place on the screen, in pixels or dots: `x` to the right, `y` down.
pub(super) type Point = (f64, f64);

/// A curve with more corners than this is a band, and its outline will do.
const BAND: usize = 1500;

/// Points that stand for many. The line through them passes every point within `tolerance`; where that takes too many,
/// they are the lowest and the highest point of each column of the screen, in their order. No peak is lost.
pub(super) fn thinned(points: impl Iterator<Item = Point>, tolerance: f64) -> Vec<Point> {
    let points: Vec<Point> = points.collect();
    corners(&points, tolerance).unwrap_or_else(|| outline(&points))
}

/// The lines that stand for a curve that may go round many times, as a locus does: what is drawn already is not drawn again. To
/// half a pixel, and then as [`thinned`].
pub(super) fn retraced(points: impl Iterator<Item = Point>, tolerance: f64) -> Vec<Vec<Point>> {
    let half = |value: f64| (value * 2.0).round() as i64;
    let mut drawn = BTreeSet::new();
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    let mut last = None;
    for point in points {
        let cell = (half(point.0), half(point.1));
        let from = last.replace(cell);
        if from == Some(cell) {
            continue;
        }
        let start = from.unwrap_or(cell);
        let is_new = drawn.insert((start.min(cell), start.max(cell)));
        let place = |(x, y): (i64, i64)| (x as f64 / 2.0, y as f64 / 2.0);
        match pieces.last_mut() {
            Some(piece) if is_new && piece.last() == Some(&place(start)) => piece.push(place(cell)),
            _ if is_new => pieces.push(vec![place(start), place(cell)]),
            _ => {}
        }
    }
    pieces.into_iter().map(|piece| corners(&piece, tolerance.max(0.5)).unwrap_or(piece)).collect()
}

/// Ramer, Douglas and Peucker: keep the ends, and of what is between them the farthest off, if it is too far off.
fn corners(points: &[Point], tolerance: f64) -> Option<Vec<Point>> {
    let Some(last) = points.len().checked_sub(1) else { return Some(Vec::new()) };
    let mut kept = vec![0, last];
    let mut spans = vec![(0, last)];
    while let Some((first, last)) = spans.pop() {
        let off = |index: usize| distance(points[index], points[first], points[last]);
        let farthest = (first + 1..last).map(|index| (off(index), index)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, farthest)) = farthest.filter(|(off, _)| *off > tolerance) {
            kept.push(farthest);
            spans.extend([(first, farthest), (farthest, last)]);
        }
        if kept.len() > BAND {
            return None;
        }
    }
    kept.sort_unstable();
    kept.dedup();
    Some(kept.into_iter().map(|index| points[index]).collect())
}

fn outline(points: &[Point]) -> Vec<Point> {
    points.chunk_by(|a, b| a.0.round() == b.0.round()).flat_map(extremes).collect()
}

/// The lowest and the highest point of a column, in their order.
fn extremes(column: &[Point]) -> Vec<Point> {
    let numbered = || column.iter().enumerate();
    let lowest = numbered().min_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let highest = numbered().max_by(|a, b| a.1.1.total_cmp(&b.1.1));
    let (Some((low, _)), Some((high, _))) = (lowest, highest) else { return Vec::new() };
    let mut kept = vec![column[low.min(high)], column[low.max(high)]];
    kept.dedup();
    kept
}

/// How far a point is from the line between two others.
fn distance(point: Point, from: Point, to: Point) -> f64 {
    let (along, off) = ((to.0 - from.0, to.1 - from.1), (point.0 - from.0, point.1 - from.1));
    let square = along.0 * along.0 + along.1 * along.1;
    let part =
        if square > 0.0 { ((off.0 * along.0 + off.1 * along.1) / square).clamp(0.0, 1.0) } else { 0.0 };
    length((off.0 - part * along.0, off.1 - part * along.1))
}

/// Screens are small: no need for the slow `hypot`, which also differs from machine to machine.
fn length((x, y): Point) -> f64 {
    (x * x + y * y).sqrt()
}

/// The pieces of a dashed line: `on` long, then a gap of `off`, measured along the line.
pub(super) fn dashes(points: &[Point], on: f64, off: f64) -> Vec<[Point; 2]> {
    let mut pieces = Vec::new();
    let mut done = 0.0;
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let length = length((to.0 - from.0, to.1 - from.1));
        let at = |along: f64| {
            let part = if length > 0.0 { along / length } else { 0.0 };
            (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1))
        };
        let mut dash = done - done % (on + off);
        while dash < done + length {
            let (start, end) = ((dash - done).max(0.0), (dash + on - done).min(length));
            if start <= end {
                pieces.push([at(start), at(end)]);
            }
            dash += on + off;
        }
        done += length;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_trapezoid_needs_four_points() {
        let sample = |index: i32| {
            let x = f64::from(index) / 20.0;
            (x, x.min(100.0).min(400.0 - x))
        };
        let thin = thinned((0..=8000).map(sample), 0.1);
        assert_eq!(thin, [(0.0, 0.0), (100.0, 100.0), (300.0, 100.0), (400.0, 0.0)]);
    }

    #[test]
    fn a_spike_of_one_sample_stays() {
        let sample = |index: i32| (f64::from(index) / 100.0, if index == 12_345 { 7.0 } else { 0.0 });
        let spike = [(0.0, 0.0), (123.44, 0.0), (123.45, 7.0), (123.46, 0.0), (199.99, 0.0)];
        assert_eq!(thinned((0..20_000).map(sample), 0.001), spike);
    }

    #[test]
    fn a_band_keeps_its_outline() {
        let sample = |index: i32| (f64::from(index) / 100.0, f64::from(index * index % 997));
        let points: Vec<Point> = (0..20_000).map(sample).collect();
        let thin = thinned(points.iter().copied(), 0.1);
        assert!((200..=402).contains(&thin.len()), "{} points", thin.len());
        let highest = |points: &[Point], column: f64| {
            points.iter().filter(|point| point.0.round() == column).map(|point| point.1).fold(0.0, f64::max)
        };
        for column in 0..200 {
            let column = f64::from(column);
            assert_eq!(highest(&thin, column).to_bits(), highest(&points, column).to_bits());
        }
    }

    #[test]
    fn a_way_gone_twice_is_drawn_once() {
        let there_and_back = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (10.0, 0.0), (0.0, 0.0), (0.0, 5.0)];
        let pieces = retraced(there_and_back.into_iter().chain(there_and_back), 0.1);
        assert_eq!(pieces, [vec![(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)], vec![(0.0, 0.0), (0.0, 5.0)]]);
        assert_eq!(retraced([(1.0, 2.0)].into_iter(), 0.1), [[(1.0, 2.0); 2]]);
        assert!(retraced(std::iter::empty(), 0.1).is_empty());
    }

    #[test]
    fn few_points() {
        assert_eq!(thinned(std::iter::empty(), 0.1), []);
        assert_eq!(thinned([(3.0, 4.0)].into_iter(), 0.1), [(3.0, 4.0)]);
    }

    #[test]
    fn dashes_go_round_corners() {
        let pieces = dashes(&[(0.0, 0.0), (5.0, 0.0), (5.0, 5.0)], 4.0, 2.0);
        assert_eq!(pieces, [[(0.0, 0.0), (4.0, 0.0)], [(5.0, 1.0), (5.0, 5.0)]]);
    }

    proptest! {
        #[test]
        fn nothing_is_far_from_the_line(
            values in prop::collection::vec(0.0..100.0, 1..200),
            per_column in 1_u32..9,
        ) {
            let place = |(index, &y): (usize, &f64)| (index as f64 / f64::from(per_column), y);
            let points: Vec<Point> = values.iter().enumerate().map(place).collect();
            let thin = thinned(points.iter().copied(), 5.0);
            for &point in &points {
                let offs = thin.windows(2).map(|pair| distance(point, pair[0], pair[1]));
                let off = offs.fold(distance(point, thin[0], thin[0]), f64::min);
                prop_assert!(off <= 5.0, "{point:?} is {off} from the line");
            }
        }
    }
}
