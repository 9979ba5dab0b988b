use crate::union::box_chunk::NarrowBox;

/// Bits of a coordinate in a key; three coordinates make a key, and each takes one pass of the sort.
const BITS: u32 = 10;

/// Returns the indices of the boxes in an order in which neighbours are near each other: along the curve of Morton (1966, whole),
/// whose keys interleave the bits of the three coordinates. Boxes of one key keep their order. Takes linear time.
pub(crate) fn nearby_order(boxes: &[NarrowBox]) -> Vec<u32> {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for [center, _] in boxes {
        for axis in 0..3 {
            (low[axis], high[axis]) = (low[axis].min(center[axis]), high[axis].max(center[axis]));
        }
    }
    let widest = (0..3).map(|axis| high[axis] - low[axis]).fold(f32::MIN_POSITIVE, f32::max);
    let most = (1_u32 << BITS) - 1;
    #[allow(clippy::cast_precision_loss, reason = "a thousand")]
    let scale = most as f32 / widest;
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the conversion saturates, and any key gives a valid order"
    )]
    let cell = |value: f32, axis: usize| (((value - low[axis]) * scale) as u32).min(most);
    let key =
        |[center, _]: &NarrowBox| (0..3).fold(0, |key, axis| key | spread(cell(center[axis], axis)) << axis);
    let mut keyed: Vec<(u32, u32)> = boxes.iter().map(key).zip(0..).collect();
    let mut sorted = keyed.clone();
    for pass in 0..3 {
        let digit = |key: u32| ((key >> (pass * BITS)) & most) as usize;
        let mut places = vec![0_u32; 1 << BITS];
        for (key, _) in &keyed {
            places[digit(*key)] += 1;
        }
        let mut next = 0;
        for place in &mut places {
            next += std::mem::replace(place, next);
        }
        for entry in &keyed {
            let place = &mut places[digit(entry.0)];
            sorted[*place as usize] = *entry;
            *place += 1;
        }
        std::mem::swap(&mut keyed, &mut sorted);
    }
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// Returns the lowest ten bits of a number with two zeros between each and the next.
fn spread(bits: u32) -> u32 {
    let bits = (bits | bits << 16) & 0x0300_00ff;
    let bits = (bits | bits << 8) & 0x0300_f00f;
    let bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_one_by_one() {
        for number in 0..1024_u32 {
            let slow = (0..10).fold(0, |key, bit| key | (number >> bit & 1) << (3 * bit));
            assert_eq!(spread(number), slow);
        }
    }

    #[test]
    fn every_box_comes_once_and_equal_ones_keep_their_order() {
        let boxes: Vec<NarrowBox> =
            (0..100_u8).map(|n| [[f32::from(n % 7), 1.0, f32::from(n % 3)], [0.0; 3]]).collect();
        let order = nearby_order(&boxes);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..100).collect::<Vec<_>>());
        let same: Vec<u32> = order.into_iter().filter(|n| n % 21 == 0).collect();
        assert_eq!(same, [0, 21, 42, 63, 84]);
        assert_eq!(nearby_order(&boxes[..1]), [0]);
    }
}
