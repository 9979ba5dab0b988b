use crate::{PointCloud, SenseError};

/// Number of voxels along each axis, on each side of the origin, that a key can hold: 21 bits an axis.
const MOST_VOXELS: f64 = (1 << 20) as f64;

/// Maximum number of voxels around a cloud for each of its points for which every voxel has a bit: up to here the bits take no more
/// memory than a table of keys, and a bit is found faster.
const MOST_BITS_PER_POINT: usize = 256;

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
        let (mut low, mut high) = ([0.0_f32; 3], [0.0_f32; 3]);
        if let Some(first) = self.points.first() {
            (low, high) = (*first, *first);
        }
        for point in &self.points {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let farthest = low.iter().chain(&high).fold(0.0_f32, |most, x| most.max(x.abs()));
        if f64::from(farthest) * per_m >= MOST_VOXELS - 1.0 {
            return Err(fault("at least a millionth of the farthest coordinate"));
        }
        let points = match Bits::around(low, high, per_m, MOST_BITS_PER_POINT * self.points.len()) {
            Some(bits) => bits.first_of_each(&self.points, per_m),
            None => first_of_each(&self.points, per_m),
        };
        Ok(Self { points, viewpoint: self.viewpoint })
    }
}

/// Returns the voxel of a coordinate, counted from the origin.
#[inline(always)]
fn voxel(coordinate: f32, per_m: f64) -> i32 {
    let place = f64::from(coordinate) * per_m;
    #[allow(clippy::cast_possible_truncation, reason = "within ±2²⁰")]
    let whole = place as i32;
    whole - i32::from(f64::from(whole) > place)
}

/// Voxels around a cloud, each with a bit.
struct Bits {
    first: [i32; 3],
    size: [usize; 3],
}

impl Bits {
    /// Returns the voxels of a box; `None` if there are more than `most`.
    fn around(low: [f32; 3], high: [f32; 3], per_m: f64, most: usize) -> Option<Self> {
        let first = low.map(|x| voxel(x, per_m));
        let count = |axis: usize| usize::try_from(voxel(high[axis], per_m) - first[axis] + 1).ok();
        let size = [count(0)?, count(1)?, count(2)?];
        // At most 2²¹ along each axis.
        (size.iter().product::<usize>() <= most).then_some(Self { first, size })
    }

    /// Returns the first of the points in each voxel; all lie in the box.
    fn first_of_each(&self, points: &[[f32; 3]], per_m: f64) -> Vec<[f32; 3]> {
        let mut is_taken = vec![0_u64; self.size.iter().product::<usize>().div_ceil(64)];
        let mut kept = vec![[0.0; 3]; points.len()];
        let mut count = 0;
        for point in points {
            let along = |axis: usize| {
                #[allow(clippy::cast_sign_loss, reason = "the first voxel is the least")]
                let place = (voxel(point[axis], per_m) - self.first[axis]) as usize;
                place
            };
            let place = (along(0) * self.size[1] + along(1)) * self.size[2] + along(2);
            let Some(word) = is_taken.get_mut(place / 64) else { continue };
            let is_new = *word >> (place % 64) & 1 == 0;
            *word |= 1 << (place % 64);
            // Written in any case: a branch would be mispredicted.
            kept[count] = *point;
            count += usize::from(is_new);
        }
        kept.truncate(count);
        kept
    }
}

/// Bit of every key in the table, so that none is 0.
const TAKEN: u64 = 1 << 63;

/// Returns the first of the points in each voxel, by a table of the voxels, at most half full.
fn first_of_each(points: &[[f32; 3]], per_m: f64) -> Vec<[f32; 3]> {
    let bits = (2 * points.len()).next_power_of_two().trailing_zeros().max(4);
    let mut table = vec![0_u64; 1 << bits];
    let mask = table.len() - 1;
    let mut kept = Vec::with_capacity(points.len());
    for point in points {
        let key = TAKEN | key(point, per_m);
        let mut place = place(key, bits);
        while table[place] != 0 && table[place] != key {
            place = (place + 1) & mask;
        }
        if table[place] == 0 {
            table[place] = key;
            kept.push(*point);
        }
    }
    kept
}

/// Returns the number of the voxel of a point, below 2⁶³.
fn key(point: &[f32; 3], per_m: f64) -> u64 {
    let number = |coordinate: f32| i64::from(voxel(coordinate, per_m) + (1 << 20)).cast_unsigned();
    (number(point[0]) << 42) | (number(point[1]) << 21) | number(point[2])
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
    use proptest::prelude::*;

    use super::*;

    fn random_cloud(seed: u64, count: usize, reach_m: [f64; 3]) -> PointCloud {
        let mut random = Stream::new(seed, 0);
        #[allow(clippy::cast_possible_truncation, reason = "points are f32")]
        let mut number = |reach_m: f64| random.uniform_between(-reach_m, reach_m) as f32;
        PointCloud::of((0..count).map(|_| reach_m.map(&mut number)).collect())
    }

    /// Oracle: a set of the three floors.
    fn plain(points: &[[f32; 3]], side_m: f64) -> Vec<[f32; 3]> {
        let mut known = HashSet::new();
        // −0 and 0 are the same voxel.
        let voxel =
            |point: &[f32; 3]| point.map(|x| ((f64::from(x) * (1.0 / side_m)).floor() + 0.0).to_bits());
        points.iter().filter(|point| known.insert(voxel(point))).copied().collect()
    }

    proptest! {
        #[test]
        fn the_first_point_of_each_voxel_stays(
            seed in any::<u64>(), count in 0_usize..3000, side_m in 0.002_f64..0.5,
            reach_m in prop::array::uniform3(0.001_f64..3.0),
        ) {
            let cloud = random_cloud(seed, count, reach_m);
            let expected = plain(&cloud.points, side_m);
            prop_assert_eq!(&cloud.thinned(side_m).unwrap().points, &expected);
            // Both methods agree, whichever the size of the cloud would choose.
            prop_assert_eq!(&first_of_each(&cloud.points, 1.0 / side_m), &expected);
            let [low, high] = [-1.0, 1.0].map(|side| reach_m.map(|x| narrow(side * x)));
            if let Some(bits) = Bits::around(low, high, 1.0 / side_m, 1 << 26) {
                prop_assert_eq!(&bits.first_of_each(&cloud.points, 1.0 / side_m), &expected);
            }
        }
    }

    #[allow(clippy::cast_possible_truncation, reason = "points are f32")]
    fn narrow(x: f64) -> f32 {
        (x as f32) * (1.0 + f32::EPSILON)
    }

    #[test]
    fn sides_that_are_no_voxels_are_refused() {
        let fault = |side_m| random_cloud(4, 5, [900.0; 3]).thinned(side_m).unwrap_err().to_string();
        assert!(fault(0.0).contains("must be positive, but is 0"));
        assert!(fault(f64::NAN).contains("but is NaN"));
        assert!(fault(1e-4).contains("a millionth"));
        assert!(PointCloud::default().thinned(0.1).unwrap().points.is_empty());
        // Voxels at and around the origin, on both sides of it.
        let points = [[-0.0_f32, 0.0, 0.0], [0.0, -0.0, 0.0], [-1e-9, 0.0, 0.0], [0.099, 0.0, 0.0]];
        assert_eq!(PointCloud::of(points.to_vec()).thinned(0.1).unwrap().points.len(), 2);
    }
}
