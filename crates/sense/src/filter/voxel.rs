use crate::{PointCloud, SenseError};

/// Number of voxels along each axis, on each side of the origin, that a key can hold: 21 bits an axis.
const MOST_VOXELS: f64 = (1 << 20) as f64;

impl PointCloud {
    /// Returns the first point of each voxel, in the order of the cloud. Voxels are cubes of this side (m) along the axes of the
    /// frame, one with a corner at the origin.
    ///
    /// # Errors
    /// [`SenseError::Filter`] for a side that is not positive, or so small that a point is more than 2²⁰ voxels from the origin.
    pub fn thinned(&self, side_m: f64) -> Result<Self, SenseError> {
        let fault =
            |range| SenseError::Filter { property: "side of a voxel, in metres,", value: side_m, range };
        if !(side_m > 0.0 && side_m.is_finite()) {
            return Err(fault("positive"));
        }
        let per_m = 1.0 / side_m;
        let farthest = self.points.iter().flatten().fold(0.0_f32, |most, x| most.max(x.abs()));
        if f64::from(farthest) * per_m >= MOST_VOXELS - 1.0 {
            return Err(fault("at least a millionth of the farthest coordinate"));
        }
        // A table, at most half full, of the numbers of kept points from 1, whose keys are in a list.
        let bits = (2 * self.points.len()).next_power_of_two().trailing_zeros().max(4);
        let mut numbers = vec![0_u32; 1 << bits];
        let mask = numbers.len() - 1;
        let mut keys: Vec<u64> = Vec::with_capacity(self.points.len());
        let mut points = Vec::with_capacity(self.points.len());
        for point in &self.points {
            let key = key(point, per_m);
            let mut place = place(key, bits);
            loop {
                match numbers[place] as usize {
                    0 => {
                        keys.push(key);
                        points.push(*point);
                        numbers[place] =
                            u32::try_from(keys.len()).map_err(|_| fault("larger for that many points"))?;
                        break;
                    }
                    number if keys[number - 1] == key => break,
                    _ => place = (place + 1) & mask,
                }
            }
        }
        Ok(Self { points, viewpoint: self.viewpoint })
    }
}

/// Returns the number of the voxel of a point, below 2⁶³.
fn key(point: &[f32; 3], per_m: f64) -> u64 {
    let mut key = 0;
    for coordinate in point {
        let place = f64::from(*coordinate) * per_m;
        #[allow(clippy::cast_possible_truncation, reason = "within ±2²⁰")]
        let whole = place as i64;
        let floor = whole - i64::from(whole as f64 > place);
        key = (key << 21) | (floor + (1 << 20)).cast_unsigned();
    }
    key
}

/// Returns the first place of a key in a table of 2^`bits` places. Mixes all bits by `mix64variant13` (Steele, Lea & Flood
/// 2014, whole, of which only this function is used): one product would put the keys of a plane into few runs.
fn place(key: u64, bits: u32) -> usize {
    let mixed = (key ^ (key >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    usize::try_from(mixed >> (64 - bits)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use cranny_spatial::Stream;

    use super::*;

    fn random_cloud(count: usize, reach_m: f64) -> PointCloud {
        let mut random = Stream::new(4, 0);
        #[allow(clippy::cast_possible_truncation, reason = "points are f32")]
        let mut number = || random.uniform_between(-reach_m, reach_m) as f32;
        PointCloud::of((0..count).map(|_| [number(), number(), number()]).collect())
    }

    /// Oracle: a map from the three floors to the first point.
    #[test]
    fn the_first_point_of_each_voxel_stays() {
        for (reach_m, side_m) in [(1.0, 0.1), (0.2, 0.01), (100.0, 7.0), (1.0, 10.0)] {
            let cloud = random_cloud(5000, reach_m);
            let mut known = HashSet::new();
            let mut expected = Vec::new();
            for point in &cloud.points {
                let voxel = point.map(|x| (f64::from(x) * (1.0 / side_m)).floor().to_bits());
                if known.insert(voxel) {
                    expected.push(*point);
                }
            }
            // −0 and 0 are the same voxel.
            assert_eq!(cloud.thinned(side_m).unwrap().points, expected, "{side_m}");
        }
        let fault = |side_m| random_cloud(5, 900.0).thinned(side_m).unwrap_err().to_string();
        assert!(fault(0.0).contains("must be positive, but is 0"));
        assert!(fault(f64::NAN).contains("but is NaN"));
        assert!(fault(1e-4).contains("a millionth"));
        assert!(PointCloud::default().thinned(0.1).unwrap().points.is_empty());
    }
}
