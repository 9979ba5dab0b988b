use crate::Picture;

/// Gap between the pictures of a sheet and around them, in pixels.
const GAP: usize = 10;

/// Background colour of a sheet.
const PAPER: [u8; 3] = [255, 255, 255];

/// Colour of the numbers.
const INK: [u8; 3] = [64, 72, 82];

impl Picture {
    /// Arranges pictures of one size in rows of `columns`, each with its number in the lower left corner, on the floor. Only
    /// the digits of the text are drawn. Returns a small blank picture if there are none.
    pub fn sheet(pictures: &[(String, Self)], columns: usize) -> Self {
        let columns = columns.clamp(1, pictures.len().max(1));
        let rows = pictures.len().div_ceil(columns);
        let (width, height) = pictures.first().map_or((0, 0), |(_, first)| (first.width(), first.height()));
        let whole = |count: usize, side: usize| GAP + count * (side + GAP);
        let mut sheet = Self::blank(whole(columns, width), whole(rows, height), PAPER);
        for (index, (number, picture)) in pictures.iter().enumerate() {
            let (left, top) = (whole(index % columns, width), whole(index / columns, height));
            for (row, points) in picture.pixels().chunks_exact(width).enumerate() {
                sheet.row_mut(top + row)[left..left + width].copy_from_slice(points);
            }
            sheet.write_digits(number, left + height / 20, top + height * 17 / 20, height as f32 / 14.0);
        }
        sheet
    }

    /// Draws seven-segment digits of a height in pixels.
    fn write_digits(&mut self, text: &str, left: usize, top: usize, height: f32) {
        let thickness = 0.075 * height;
        let mut begin = left as f32;
        for digit in text.chars().filter_map(|c| c.to_digit(10)) {
            // The segments of a 1 are on the right; the empty space on their left is skipped.
            begin -= if digit == 1 { 0.34 * height } else { 0.0 };
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "whole points around the digit; small positive numbers"
            )]
            let (side, tall) = ((0.7 * height) as usize, (1.2 * height) as usize);
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a count that is not negative and small"
            )]
            let first = begin.max(0.0) as usize;
            for row in top..(top + tall).min(self.height()) {
                for column in first..(first + side).min(self.width()) {
                    let x = (column as f32 + 0.5 - begin) / height - 0.08;
                    let y = (row as f32 + 0.5 - top as f32) / height - 0.08;
                    let beyond = distance_to_digit(digit, x, y) * height - thickness;
                    let cover = (0.5 - beyond).clamp(0.0, 1.0);
                    let point = &mut self.row_mut(row)[column];
                    #[allow(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "between two screen values"
                    )]
                    let mix = |from: u8, to: u8| {
                        (f32::from(from) + (f32::from(to) - f32::from(from)) * cover + 0.5) as u8
                    };
                    *point = [0, 1, 2].map(|i| mix(point[i], INK[i]));
                }
            }
            begin += 0.72 * height;
        }
    }
}

/// Segments of each digit, one bit each: top, upper right, lower right, bottom, lower left, upper left, middle.
const STROKES: [u8; 10] = [
    0b011_1111, 0b000_0110, 0b101_1011, 0b100_1111, 0b110_0110, 0b110_1101, 0b111_1101, 0b000_0111, 0x7f,
    0b110_1111,
];

/// End points of the segments from the upper left corner, in heights of a digit.
const ENDS: [[f32; 4]; 7] = [
    [0.0, 0.0, 0.46, 0.0],
    [0.46, 0.0, 0.46, 0.5],
    [0.46, 0.5, 0.46, 1.0],
    [0.0, 1.0, 0.46, 1.0],
    [0.0, 0.5, 0.0, 1.0],
    [0.0, 0.0, 0.0, 0.5],
    [0.0, 0.5, 0.46, 0.5],
];

fn distance_to_digit(digit: u32, x: f32, y: f32) -> f32 {
    let strokes = STROKES[digit as usize % 10];
    let distance = |stroke: usize| {
        let [x0, y0, x1, y1] = ENDS[stroke];
        let length_squared = (x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0);
        let along = (((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / length_squared).clamp(0.0, 1.0);
        let (dx, dy) = (x - x0 - (x1 - x0) * along, y - y0 - (y1 - y0) * along);
        (dx * dx + dy * dy).sqrt()
    };
    (0..7).filter(|stroke| strokes >> stroke & 1 == 1).map(distance).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_holds_its_pictures_side_by_side() {
        let red = Picture::blank(240, 160, [200, 0, 0]);
        let blue = Picture::blank(240, 160, [0, 0, 200]);
        let pictures = [(String::new(), red.clone()), ("8".into(), blue), (String::new(), red)];
        let sheet = Picture::sheet(&pictures, 2);
        assert_eq!((sheet.width(), sheet.height()), (3 * GAP + 480, 3 * GAP + 320));
        let at = |x: usize, y: usize| sheet.pixels()[y * sheet.width() + x];
        assert_eq!(at(GAP + 120, GAP + 80), [200, 0, 0]);
        assert_eq!(at(2 * GAP + 360, GAP + 80), [0, 0, 200]);
        assert_eq!(at(GAP + 120, 2 * GAP + 240), [200, 0, 0]);
        assert_eq!(at(2 * GAP + 360, 2 * GAP + 240), PAPER);
        assert!(sheet.pixels().contains(&INK), "no number");
        assert_eq!(Picture::sheet(&[], 5).pixels().len(), 2 * GAP * GAP);
    }
}
