use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};

/// Number of boxes per page: one vector of the widest instruction set in use.
pub(crate) const PAGE: usize = 16;

/// Content of a box of a page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Entry {
    /// Further boxes, on the page with this index.
    Page(u32),
    /// Points, in the leaf with this index.
    Leaf(u32),
}

/// Address of a box: the index of the page times [`PAGE`], plus its position on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slot(u32);

impl Slot {
    fn page(self) -> usize {
        self.0 as usize / PAGE
    }

    fn lane(self) -> usize {
        self.0 as usize % PAGE
    }
}

/// Bounding boxes in pages of up to sixteen, laid out so that one pass of vectors measures a whole page. Page 0 is the root. A
/// box whose content is a page contains all boxes of that page.
///
/// A search reads far more boxes than fit into the caches. A side therefore keeps only the upper half of an `f32`, rounded
/// outwards: a box is at most 2⁻⁷ of its coordinates wider than necessary, and takes half the memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct BoxPages {
    dimensions: usize,
    /// Sides of the boxes, for each page, for each dimension, with the low side in the lower half of the word.
    sides: Vec<u32>,
    entries: Vec<[Entry; PAGE]>,
    lens: Vec<u8>,
    /// Box whose content is each page; `None` for the root.
    owners: Vec<Option<Slot>>,
}

impl BoxPages {
    /// Creates a root page without boxes.
    pub fn new(dimensions: usize) -> Self {
        let mut pages = Self { dimensions, ..Self::default() };
        pages.add_page(None);
        pages
    }

    /// Adds an empty box beside that of `slot`, on the same page. If the page is full, the box of `slot` first gets its own
    /// page, with a box for its content. Returns the new slot of the content of `slot`, and the new box.
    pub fn add_beside(&mut self, slot: Slot, entry: Entry) -> (Slot, Slot) {
        if usize::from(self.lens[slot.page()]) < PAGE {
            return (slot, self.add(slot.page(), entry));
        }
        let page = self.add_page(Some(slot));
        let held = std::mem::replace(
            &mut self.entries[slot.page()][slot.lane()],
            Entry::Page(u32::try_from(page).unwrap_or(u32::MAX)),
        );
        (self.add(page, held), self.add(page, entry))
    }

    /// Adds an empty box to the page.
    ///
    /// # Panics
    /// If the page is full.
    pub fn add(&mut self, page: usize, entry: Entry) -> Slot {
        let lane = usize::from(self.lens[page]);
        self.entries[page][lane] = entry;
        self.lens[page] += 1;
        let slot = Slot(u32::try_from(page * PAGE + lane).unwrap_or(u32::MAX));
        self.clear(slot);
        slot
    }

    /// Makes the box empty. The boxes that contain it stay as they are.
    pub fn clear(&mut self, slot: Slot) {
        for sides in self.page_sides(slot.page()).chunks_exact_mut(PAGE) {
            sides[slot.lane()] = packed(f32::INFINITY, f32::NEG_INFINITY);
        }
    }

    /// Grows the box, and those that contain it, to contain the point.
    pub fn grow(&mut self, slot: Slot, point: &[f32]) {
        let mut at = Some(slot);
        while let Some(slot) = at {
            let mut has_grown = false;
            for (sides, &x) in self.page_sides(slot.page()).chunks_exact_mut(PAGE).zip(point) {
                let side = &mut sides[slot.lane()];
                let (low, high) = unpacked(*side);
                if x < low || x > high {
                    *side = packed(low.min(x), high.max(x));
                    has_grown = true;
                }
            }
            // A box that contains another box contains its points, so the loop can stop early.
            at = self.owners[slot.page()].filter(|_| has_grown);
        }
    }

    /// Returns the content of the boxes of a page, each with its squared distance to the point, in the order of the page.
    #[inline(always)]
    pub fn measure<S: Simd>(&self, simd: S, page: u32, point: &[f32]) -> impl Iterator<Item = (f32, Entry)> {
        let page = page as usize;
        let stride = self.dimensions * PAGE;
        let zero = f32x16::splat(simd, 0.0);
        let upper_half = u32x16::splat(simd, UPPER_HALF);
        let mut sum = zero;
        for (sides, x) in self.sides[page * stride..][..stride].chunks_exact(PAGE).zip(point) {
            let x = f32x16::splat(simd, *x);
            let sides = u32x16::from_slice(simd, sides);
            let below = (sides << 16).bitcast::<f32x16<S>>() - x;
            let above = x - (sides & upper_half).bitcast::<f32x16<S>>();
            let outside = below.max(above).max(zero);
            sum += outside * outside;
        }
        let mut distances = [0.0; PAGE];
        sum.store_slice(&mut distances);
        distances.into_iter().zip(self.entries[page]).take(usize::from(self.lens[page]))
    }

    fn add_page(&mut self, owner: Option<Slot>) -> usize {
        let page = self.lens.len();
        self.sides.resize((page + 1) * self.dimensions * PAGE, 0);
        self.entries.push([Entry::Page(0); PAGE]);
        self.lens.push(0);
        self.owners.push(owner);
        page
    }

    /// Returns the sides of the boxes of a page, for each dimension.
    fn page_sides(&mut self, page: usize) -> &mut [u32] {
        let stride = self.dimensions * PAGE;
        &mut self.sides[page * stride..][..stride]
    }
}

const UPPER_HALF: u32 = 0xFFFF_0000;

/// Packs both sides of a box into one word, rounded outwards.
fn packed(low: f32, high: f32) -> u32 {
    // Rounding down equals rounding up the negated number.
    (rounded_up(-low) ^ SIGN) >> 16 | rounded_up(high)
}

fn unpacked(sides: u32) -> (f32, f32) {
    (f32::from_bits(sides << 16), f32::from_bits(sides & UPPER_HALF))
}

const SIGN: u32 = 1 << 31;

/// Returns the bits of the least number that has only the upper half of an `f32` and is at least `x`.
fn rounded_up(x: f32) -> u32 {
    let bits = x.to_bits();
    let is_cut = bits & !UPPER_HALF != 0;
    // The bits of a positive number grow with it; those of a negative number grow as it falls.
    (bits & UPPER_HALF) + u32::from(is_cut && bits & SIGN == 0) * (1 << 16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_packed_side_lies_outwards_and_no_farther_than_it_must(a in -1e6_f32..1e6, b in -1e6_f32..1e6) {
            let (low, high) = unpacked(packed(a, b));
            prop_assert!(low <= a && high >= b);
            let most = |x: f32| x.abs() / 128.0 + f32::MIN_POSITIVE;
            prop_assert!(a - low <= most(a) && high - b <= most(b));
            prop_assert_eq!(unpacked(packed(low, high)), (low, high));
        }
    }

    #[test]
    fn an_empty_box_stays_empty() {
        let empty = (f32::INFINITY, f32::NEG_INFINITY);
        assert_eq!(unpacked(packed(empty.0, empty.1)), empty);
    }
}
