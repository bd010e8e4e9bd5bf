//! Selection of a few points that enclose as much of a planar set as possible.

use arrayvec::ArrayVec;

/// Maximum number of points that are selected. The polygon that they form extends to at least 97 % of the radius of a
/// circle in every direction.
pub(super) const MAX_POINTS: usize = 12;

/// Cosine of 30 degrees.
const COS_30: f64 = 0.866_025_403_784_438_6;

/// Unit vectors at multiples of 30 degrees.
const DIRECTIONS: [[f64; 2]; MAX_POINTS] = [
    [1.0, 0.0],
    [COS_30, 0.5],
    [0.5, COS_30],
    [0.0, 1.0],
    [-0.5, COS_30],
    [-COS_30, 0.5],
    [-1.0, 0.0],
    [-COS_30, -0.5],
    [-0.5, -COS_30],
    [0.0, -1.0],
    [0.5, -COS_30],
    [COS_30, -0.5],
];

/// Lead of a point over an earlier one that is attributed to rounding, relative to the size of the set.
const TIE_TOLERANCE: f64 = 1e-9;

/// Returns the indices of the points that are farthest along each of twelve directions, in counterclockwise order, each
/// once. `bias` is subtracted from the distance of a point along the direction, m, so that a lower point is preferred
/// to one above it.
pub(super) fn select_spread(points: &[[f64; 2]], bias: impl Fn(usize) -> f64) -> ArrayVec<usize, MAX_POINTS> {
    let size = points.iter().flatten().fold(0.0f64, |size, x| size.max(x.abs()));
    let mut selected: ArrayVec<usize, MAX_POINTS> = ArrayVec::new();
    for direction in DIRECTIONS {
        let along = |i: usize| points[i][0] * direction[0] + points[i][1] * direction[1] - bias(i);
        let farthest =
            (0..points.len()).reduce(|best, i| if along(i) > along(best) + TIE_TOLERANCE * size { i } else { best });
        if let Some(farthest) = farthest.filter(|i| !selected.contains(i)) {
            selected.push(farthest);
        }
    }
    selected
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: usize, turn: f64) -> Vec<[f64; 2]> {
        let angle = |i: usize| turn + std::f64::consts::TAU * i as f64 / corners as f64;
        (0..corners).map(|i| [angle(i).cos(), angle(i).sin()]).collect()
    }

    #[test]
    fn corners_of_small_polygons_are_all_selected() {
        for corners in 3..=6 {
            for turn in [0.0, 0.1, 0.37, 0.9] {
                let selected = select_spread(&polygon(corners, turn), |_| 0.0);
                assert_eq!(selected.len(), corners, "{corners} corners turned by {turn}");
            }
        }
        // At most a direction lies between two corners.
        assert_eq!(select_spread(&polygon(12, 0.1), |_| 0.0).len(), 12);
    }

    #[test]
    fn selected_points_enclose_most_of_a_circle() {
        let corners = polygon(360, 0.0);
        let selected = select_spread(&corners, |_| 0.0);
        assert_eq!(selected.len(), MAX_POINTS);
        for (i, a) in selected.iter().enumerate() {
            let b = selected[(i + 1) % MAX_POINTS];
            let middle = [0, 1].map(|k| 0.5 * (corners[*a][k] + corners[b][k]));
            assert!(middle[0].hypot(middle[1]) > 0.96);
        }
    }

    #[test]
    fn inner_points_are_not_selected() {
        let mut points = polygon(4, 0.2);
        points.extend([[0.0, 0.0], [0.1, 0.2], [0.4, 0.4]]);
        assert_eq!(select_spread(&points, |_| 0.0).as_slice().iter().max(), Some(&3));
    }
}
