/// Type of a number in binary data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Number {
    /// Size in bytes: 1, 2, 4 or 8.
    pub fn bytes(self) -> usize {
        let (Self::Signed(bytes) | Self::Unsigned(bytes) | Self::Float(bytes)) = self;
        bytes
    }

    /// Returns the number at the start of `bytes`; `None` if they are too short.
    pub fn read(self, bytes: &[u8], is_big_endian: bool) -> Option<f64> {
        let mut own = [0_u8; 8];
        let count = self.bytes();
        own[..count].copy_from_slice(bytes.get(..count)?);
        if is_big_endian {
            own[..count].reverse();
        }
        let bits = u64::from_le_bytes(own);
        let [a, b, c, d, ..] = own;
        Some(match self {
            Self::Float(4) => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::Float(_) => f64::from_bits(bits),
            Self::Unsigned(_) => bits as f64,
            Self::Signed(_) => {
                // Moves the sign bit to the top and back.
                let unused = 64 - 8 * u32::try_from(count).unwrap_or(8);
                ((bits << unused).cast_signed() >> unused) as f64
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_each_type_and_byte_order_are_read() {
        for (number, bytes, value) in [
            (Number::Signed(1), &[255_u8][..], -1.0),
            (Number::Unsigned(1), &[255], 255.0),
            (Number::Signed(2), &(-300_i16).to_le_bytes(), -300.0),
            (Number::Unsigned(2), &60000_u16.to_le_bytes(), 60000.0),
            (Number::Signed(4), &(-70000_i32).to_le_bytes(), -70000.0),
            (Number::Signed(8), &(-7_i64).to_le_bytes(), -7.0),
            (Number::Float(4), &0.5_f32.to_le_bytes(), 0.5),
            (Number::Float(8), &0.1_f64.to_le_bytes(), 0.1),
        ] {
            assert!((number.read(bytes, false).unwrap() - value).abs() < 1e-15, "{number:?}");
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            assert!((number.read(&reversed, true).unwrap() - value).abs() < 1e-15, "{number:?}");
            assert_eq!(number.read(&bytes[1..], false), None);
        }
    }
}
