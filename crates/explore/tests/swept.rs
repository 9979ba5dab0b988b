use cranny_explore::swept_cells;
use cranny_sense::{Camera, DepthImage, SeenMap, SeenSettings, SensorModel, Unseen, View};
use cranny_shape::Aabb;
use cranny_spatial::{Point, Pose, Stream, Vector};
use cranny_test_robots::BALL_RADIUS_M;

use crate::scene::robot;

/// A map of which nothing is seen.
fn unseen_map() -> SeenMap {
    let camera = Camera::with_field_of_view([32, 24], 1.0, Pose::identity()).unwrap();
    let depth = DepthImage::new(32, 24, vec![f32::NAN; 768]).unwrap();
    let view = View::new("blind", camera, depth, SensorModel::default()).unwrap();
    let region = Aabb { center: Point::origin(), half_extents: Vector::repeat(0.64) };
    let settings =
        SeenSettings { region, cell_m: 0.02, fine: Vec::new(), fine_m: 0.01, unseen: Unseen::Solid };
    SeenMap::new(&[view], &[], settings).unwrap()
}

#[test]
fn a_ball_along_edges_sweeps_the_cells_of_capsules() {
    let map = unseen_map();
    let path = [vec![-0.3, 0.0, 0.1], vec![0.2, 0.25, -0.1], vec![0.2, -0.2, 0.0]];
    let cells = swept_cells(&robot(), &path, &map, false);
    let distance_m = |point: &Point| {
        let ends = path.windows(2).map(|edge| [0, 1].map(|end| Point::from_slice(&edge[end])));
        let of_edge = |[a, b]: [Point; 2]| {
            let share = ((point - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
            (a + (b - a) * share - point).norm()
        };
        ends.map(of_edge).fold(f64::INFINITY, f64::min)
    };
    // No point of the capsules is left out.
    let mut random = Stream::new(5, 0);
    let mut inside = 0;
    while inside < 4000 {
        let point = Point::from(Vector::from_fn(|_, _| random.uniform_between(-0.4, 0.4)));
        if distance_m(&point) < BALL_RADIUS_M {
            inside += 1;
            assert!(cells.iter().any(|cell| cell.aabb.contains(&point)), "{point}");
        }
    }
    // Each cell comes close to them: at most the reach of a sample and half its diagonal beside.
    for cell in &cells {
        let beyond_m = distance_m(&cell.aabb.center) - BALL_RADIUS_M - cell.aabb.half_extents.norm();
        assert!(beyond_m < 0.011, "{beyond_m}");
        assert!(!cell.is_occupied && cell.first.edge < 2);
    }
    // The first cells are met at the start, the last ones on the last edge; nothing is met twice.
    assert!(cells[0].first.edge == 0 && cells.last().unwrap().first.edge == 1);
    assert!(cells.windows(2).all(|pair| {
        let place = |cell: &cranny_explore::MetCell| (cell.first.edge as f64) + cell.first.at;
        place(&pair[0]) <= place(&pair[1])
    }));
    let mut centers: Vec<_> = cells.iter().map(|cell| cell.aabb.center.coords.data.0).collect();
    centers.sort_by(|a, b| a.partial_cmp(b).unwrap());
    centers.dedup();
    assert_eq!(centers.len(), cells.len());
    let at_rest = swept_cells(&robot(), &path[..1], &map, false);
    assert!(!at_rest.is_empty() && at_rest.len() < cells.len() / 4);
}
