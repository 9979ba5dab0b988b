use crate::{Dash, Point};

/// Splits a line into its strokes; a solid line is one.
pub(crate) fn strokes(points: &[Point], dash: Dash) -> Vec<Vec<Point>> {
    let lengths = dash.lengths();
    if lengths.is_empty() {
        return vec![points.to_vec()];
    }
    let mut strokes = Vec::new();
    let (mut index, mut left) = (0, lengths[0]);
    let mut drawn = points.first().map_or_else(Vec::new, |&first| vec![first]);
    for pair in points.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let distance = (to.0 - from.0).hypot(to.1 - from.1);
            if distance <= left {
                left -= distance;
                drawn.push(to);
                break;
            }
            let share = left / distance;
            from = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            drawn.push(from);
            if index % 2 == 0 {
                strokes.push(std::mem::take(&mut drawn));
            }
            index = (index + 1) % lengths.len();
            (left, drawn) = (lengths[index], vec![from]);
        }
    }
    if index % 2 == 0 && drawn.len() > 1 {
        strokes.push(drawn);
    }
    strokes
}

/// Returns the outline of a stroke as polygons of one orientation, whose union it is: a rectangle for each straight piece, with
/// flat ends, and a disc at each bend.
pub(crate) fn outlines(points: &[Point], width: f64) -> Vec<Vec<Point>> {
    let half = 0.5 * width;
    let directions: Vec<Option<Point>> = points
        .windows(2)
        .map(|pair| {
            let (x, y) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            let length = x.hypot(y);
            (length > 0.0).then(|| (x / length, y / length))
        })
        .collect();
    let mut polygons = Vec::new();
    let mut before: Option<Point> = None;
    for (pair, direction) in points.windows(2).zip(directions) {
        let Some((x, y)) = direction else { continue };
        let corner = |at: Point, side: f64| (at.0 - side * half * y, at.1 + side * half * x);
        polygons.push(vec![
            corner(pair[0], -1.0),
            corner(pair[1], -1.0),
            corner(pair[1], 1.0),
            corner(pair[0], 1.0),
        ]);
        if before.is_some_and(|(u, v)| u * x + v * y < STRAIGHT) {
            polygons.push(disc(pair[0], half));
        }
        before = Some((x, y));
    }
    polygons
}

/// Cosine of the bend below which pieces are joined by a disc: 2°, at which the gap is invisible.
const STRAIGHT: f64 = 0.9994;

/// Number of corners of a disc: it deviates by less than 0.02 of a pixel at a radius of 8 pixels.
const CORNERS: u32 = 48;

/// Returns a disc as a polygon.
pub(crate) fn disc(center: Point, radius: f64) -> Vec<Point> {
    let corner = |index: u32| {
        let (sine, cosine) = libm::sincos(f64::from(index) * std::f64::consts::TAU / f64::from(CORNERS));
        (center.0 + radius * cosine, center.1 + radius * sine)
    };
    (0..CORNERS).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_line_of_many_points_keeps_its_pattern() {
        let points: Vec<Point> = (0..101).map(|i| (f64::from(i) * 0.5, 0.0)).collect();
        let strokes = strokes(&points, Dash::Long);
        let ends: Vec<(f64, f64)> =
            strokes.iter().map(|points| (points[0].0, points[points.len() - 1].0)).collect();
        let expected = [(0.0, 9.0), (12.0, 21.0), (24.0, 33.0), (36.0, 45.0), (48.0, 50.0)];
        assert_eq!(ends.len(), expected.len());
        for (end, expected) in ends.iter().zip(expected) {
            assert!((end.0 - expected.0).abs() < 1e-9 && (end.1 - expected.1).abs() < 1e-9, "{end:?}");
        }
    }

    #[test]
    fn pieces_of_a_stroke_turn_in_one_direction() {
        let area = |polygon: &Vec<Point>| -> f64 {
            let next = polygon.iter().cycle().skip(1);
            polygon.iter().zip(next).map(|(a, b)| 0.5 * (a.0 * b.1 - b.0 * a.1)).sum()
        };
        let polygons = outlines(&[(0.0, 0.0), (10.0, 0.0), (10.0, 0.0), (10.0, 5.0)], 2.0);
        let areas: Vec<f64> = polygons.iter().map(area).collect();
        assert_eq!(areas.len(), 3);
        assert!((areas[0] - 20.0).abs() < 1e-9 && (areas[1] - 10.0).abs() < 1e-9);
        assert!((areas[2] - std::f64::consts::PI).abs() < 0.02);
    }
}
