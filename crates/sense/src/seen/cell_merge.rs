/// Boxes of cells of a block of 2 × 2 × 2: first cell and size along each axis.
pub(crate) type BlockBox = [[u8; 3]; 2];

/// Returns boxes that cover exactly the cells of a block whose bits are set; bit x + 2 y + 4 z is the cell (x, y, z). Takes the largest
/// box first, of equal ones the first in order.
pub(crate) fn boxes_of(cells: u8) -> Vec<BlockBox> {
    let mut rest = cells;
    let mut boxes = Vec::new();
    while rest != 0 {
        let mut best: Option<(u32, BlockBox, u8)> = None;
        for size in SIZES {
            for first in 0..8_u8 {
                let first = [first & 1, first >> 1 & 1, first >> 2 & 1];
                let Some(bits) = bits_of(first, size).filter(|bits| bits & rest == *bits) else { continue };
                let count = bits.count_ones();
                if best.is_none_or(|(most, ..)| count > most) {
                    best = Some((count, [first, size], bits));
                }
            }
        }
        let Some((_, found, bits)) = best else { break };
        boxes.push(found);
        rest &= !bits;
    }
    boxes
}

/// Sizes of boxes in a block.
const SIZES: [[u8; 3]; 8] =
    [[2, 2, 2], [2, 2, 1], [2, 1, 2], [1, 2, 2], [2, 1, 1], [1, 2, 1], [1, 1, 2], [1, 1, 1]];

fn bits_of(first: [u8; 3], size: [u8; 3]) -> Option<u8> {
    (0..3).all(|axis| first[axis] + size[axis] <= 2).then(|| {
        let mut bits = 0;
        for cell in 0..8_u8 {
            let at = [cell & 1, cell >> 1 & 1, cell >> 2 & 1];
            let is_inside = (0..3).all(|axis| (first[axis]..first[axis] + size[axis]).contains(&at[axis]));
            bits |= u8::from(is_inside) << cell;
        }
        bits
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_cover_each_cell_once_and_no_other() {
        for cells in 0..=255_u8 {
            let mut covered = 0;
            for [first, size] in boxes_of(cells) {
                let bits = bits_of(first, size).expect("a box within the block");
                assert_eq!(covered & bits, 0);
                covered |= bits;
            }
            assert_eq!(covered, cells);
        }
        assert_eq!(boxes_of(255), [[[0; 3], [2; 3]]]);
        assert_eq!(boxes_of(0b1111).len(), 1);
    }
}
