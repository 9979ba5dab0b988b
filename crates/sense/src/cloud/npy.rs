use cranny_file::NpyArray;

use crate::cloud::collector::Collector;
use crate::cloud::read_cloud::ReadCloud;

/// Reads a `NumPy` array of shape (n, 3), or (rows, columns, 3) as of an image.
///
/// # Errors
/// A sentence on another shape or type, or data of another length.
pub(crate) fn read(bytes: &[u8]) -> Result<ReadCloud, String> {
    let mut array = NpyArray::of(bytes)?;
    let expected = "a cloud is an array of float32 or float64 of shape (n, 3) or (rows, columns, 3)";
    let count = match array.shape[..] {
        [count, 3] => Some(count),
        [rows, columns, 3] => rows.checked_mul(columns),
        _ => return Err(format!("the shape is {:?}, but {expected}", array.shape)),
    };
    // Each number takes a byte at least.
    let fits = |count: &usize| count.checked_mul(3).is_some_and(|numbers| numbers <= bytes.len());
    let count = count.and_then(|count| usize::try_from(count).ok()).filter(fits);
    let count = count.ok_or("more numbers are announced than the file holds (was it cut short?)")?;
    if !array.is_numeric() || !array.kind.contains('f') {
        return Err(format!("the type is {}, but {expected}", array.kind));
    }
    let is_column_major = array.is_column_major && count > 0;
    if is_column_major && array.shape.len() != 2 {
        return Err(
            "an array of three indices in Fortran order is not read (numpy.ascontiguousarray)".to_owned()
        );
    }
    let mut next = || match array.next() {
        Some(Ok(number)) => Ok(number),
        Some(Err(reason)) => Err(format!("{reason} (was the file cut short?)")),
        None => Err("the data ends too early".to_owned()),
    };
    let mut points = Collector::new(count);
    if is_column_major {
        let mut columns = vec![[0.0; 3]; count];
        for axis in 0..3 {
            for point in &mut columns {
                point[axis] = next()?;
            }
        }
        for point in columns {
            points.add(point)?;
        }
    } else {
        for _ in 0..count {
            points.add([next()?, next()?, next()?])?;
        }
    }
    if !array.is_at_end().map_err(|reason| reason.to_string())? {
        return Err("bytes follow the last number".to_owned());
    }
    points.finish()
}
