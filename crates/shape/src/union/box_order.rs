use cranny_spatial::LANES;

use crate::union::box_chunk::NarrowBox;

/// A box by its centre, with its index.
#[derive(Clone, Copy)]
struct Center {
    at: [f32; 3],
    index: u32,
}

/// Returns the indices of the boxes in an order in which runs of 16, 256, … are compact: those of a run are halved along the axis of
/// their largest spread until sixteen remain, each half a power of two of such groups. Takes n log n time.
pub(crate) fn compact_order(boxes: &[NarrowBox]) -> Vec<u32> {
    let mut centers: Vec<Center> =
        boxes.iter().zip(0..).map(|([at, _], index)| Center { at: *at, index }).collect();
    halve(&mut centers);
    centers.iter().map(|center| center.index).collect()
}

fn halve(run: &mut [Center]) {
    let groups = run.len().div_ceil(LANES);
    if groups < 2 {
        return;
    }
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for center in &*run {
        for axis in 0..3 {
            (low[axis], high[axis]) = (low[axis].min(center.at[axis]), high[axis].max(center.at[axis]));
        }
    }
    let spread = |axis: &usize| high[*axis] - low[*axis];
    let axis = (0..3).max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
    let middle = LANES * (groups.next_power_of_two() / 2);
    run.select_nth_unstable_by(middle, |a, b| a.at[axis].total_cmp(&b.at[axis]).then(a.index.cmp(&b.index)));
    let (lower, upper) = run.split_at_mut(middle);
    halve(lower);
    halve(upper);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_box_comes_once_and_runs_are_compact() {
        let place = |n: u16| [f32::from(n * 7 % 1000), f32::from(n * 3 % 10), 0.0];
        let boxes: Vec<NarrowBox> = (0..1000).map(|n| [place(n), [0.0; 3]]).collect();
        let order = compact_order(&boxes);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..1000).collect::<Vec<_>>());
        for run in order.chunks(LANES) {
            let along = run.iter().map(|n| boxes[*n as usize][0][0]);
            let width = along.clone().fold(0.0, f32::max) - along.fold(f32::INFINITY, f32::min);
            assert!(width < 40.0, "{width}");
        }
        assert_eq!(compact_order(&boxes[..1]), [0]);
        // Boxes at one place are ordered too.
        assert_eq!(compact_order(&[[[1.0; 3], [0.0; 3]]; 40]).len(), 40);
    }
}
