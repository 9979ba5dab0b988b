use cranny_file::{LIFTED_BY, are_limits_lifted};

/// Greatest expansion of LZF: three bytes give at most 264.
const MOST_EXPANSION: usize = 88;

/// Maximum size of the data, in bytes, as of a file that is not compressed.
const MOST_BYTES: usize = 1 << 30;

/// Returns the data that `packed` holds, of exactly `size` bytes (Lehmann, `LibLZF` 3.6, `lzf_d.c`, whole).
///
/// # Errors
/// A sentence on data that ends early, refers back beyond its start, or has another size.
pub(crate) fn unpacked(packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    // Before memory of that size is taken.
    if size > packed.len().saturating_mul(MOST_EXPANSION) {
        return Err(format!("{} compressed bytes cannot hold {size} bytes", packed.len()));
    }
    if size > MOST_BYTES && !are_limits_lifted() {
        return Err(format!(
            "{size} bytes are more than the {MOST_BYTES} that are unpacked ({LIFTED_BY} lifts this limit)"
        ));
    }
    let cut = || "the compressed data ends too early".to_owned();
    let mut data = Vec::with_capacity(size);
    let mut rest = packed.iter().copied();
    while let Some(control) = rest.next() {
        let control = usize::from(control);
        if control < 32 {
            for _ in 0..=control {
                data.push(rest.next().ok_or_else(cut)?);
            }
        } else {
            let mut length = control >> 5;
            if length == 7 {
                length += usize::from(rest.next().ok_or_else(cut)?);
            }
            let back = ((control & 31) << 8) + usize::from(rest.next().ok_or_else(cut)?) + 1;
            let from = data.len().checked_sub(back);
            let from = from.ok_or("the compressed data refers back beyond its start")?;
            // The copy may overlap its source.
            for index in from..from + length + 2 {
                data.push(data[index]);
            }
        }
        if data.len() > size {
            break;
        }
    }
    if data.len() == size {
        Ok(data)
    } else {
        Err(format!("the compressed data does not hold {size} bytes, as it states"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_and_references_are_unpacked() {
        // "abc", then 7 bytes from 3 back, then 10 + 9 bytes from 1 back by the long form.
        let packed = [2, b'a', b'b', b'c', 5 << 5, 2, 7 << 5, 10, 0];
        assert_eq!(unpacked(&packed, 29).unwrap(), b"abcabcabcaaaaaaaaaaaaaaaaaaaa");
        assert_eq!(unpacked(&[], 0).unwrap(), b"");
        for (packed, size, words) in [
            (&packed[..], 28, "does not hold 28 bytes"),
            (&packed, 30, "does not hold 30 bytes"),
            (&packed[..8], 29, "ends too early"),
            (&packed[..3], 3, "ends too early"),
            (&[5 << 5, 2], 7, "beyond its start"),
            (&packed, 1 << 40, "cannot hold"),
            (&vec![0xff; 1 << 24][..], (1 << 30) + 1, "more than the 1073741824 that are unpacked"),
        ] {
            let fault = unpacked(packed, size).unwrap_err();
            assert!(fault.contains(words), "no '{words}' in {fault}");
        }
    }
}
