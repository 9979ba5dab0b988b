use cranny_spatial::FARTHEST_M;

use crate::PointCloud;
use crate::cloud::read_cloud::ReadCloud;

/// Collector of points, which drops those that are not finite and refuses those that are too far away.
pub(crate) struct Collector {
    points: Vec<[f32; 3]>,
    dropped: usize,
}

impl Collector {
    /// Collector of `count` points, of which the source is known to have as many.
    pub fn new(count: usize) -> Self {
        Self { points: Vec::with_capacity(count), dropped: 0 }
    }

    pub fn add(&mut self, point: [f64; 3]) -> Result<(), String> {
        if !point.iter().all(|number| number.is_finite()) {
            self.dropped += 1;
            return Ok(());
        }
        if let Some(far) = point.iter().find(|number| number.abs() > FARTHEST_M) {
            let index = self.points.len() + self.dropped;
            return Err(format!(
                "point {index} has the coordinate {far}, but points are given in metres, at most {FARTHEST_M} from \
                 the origin"
            ));
        }
        #[allow(clippy::cast_possible_truncation, reason = "points are stored as f32")]
        self.points.push(point.map(|number| number as f32));
        Ok(())
    }

    pub fn finish(self) -> Result<ReadCloud, String> {
        let Self { points, dropped } = self;
        match (points.is_empty(), dropped) {
            (true, 0) => Err("the cloud has no points".to_owned()),
            (true, _) => Err(format!(
                "the cloud has no valid point: all {dropped} have a coordinate that is not finite"
            )),
            _ => Ok(ReadCloud { cloud: PointCloud::of(points), dropped }),
        }
    }
}

impl ReadCloud {
    /// Returns the cloud of points (m) from another source than a file. Those with a coordinate that is not finite are dropped and
    /// counted.
    ///
    /// # Errors
    /// A sentence on a coordinate beyond 1000 m, or on a cloud without a valid point.
    pub fn of_points(points: &[[f64; 3]]) -> Result<Self, String> {
        let mut collector = Collector::new(points.len());
        for point in points {
            collector.add(*point)?;
        }
        collector.finish()
    }
}
