use crate::cloud::ascii_rows::{check_count, read_rows};
use crate::cloud::collector::Collector;
use crate::cloud::lzf::unpacked;
use crate::cloud::number::Number;
use crate::cloud::pcd_header::{Field, Form, Header};
use crate::cloud::read_cloud::ReadCloud;
use crate::cloud::row::Row;

/// Returns true if bytes begin as a PCD file: a comment or a line of its header.
pub(crate) fn is_pcd(bytes: &[u8]) -> bool {
    let first = bytes.iter().position(|byte| !byte.is_ascii_whitespace());
    first.is_some_and(|first| {
        [&b"#"[..], b"VERSION", b"FIELDS"].iter().any(|word| bytes[first..].starts_with(word))
    })
}

/// Reads a PCD file of version 0.7 ("The PCD file format", Point Cloud Library, whole).
///
/// # Errors
/// A sentence on a header that contradicts itself or the data.
pub(crate) fn read(bytes: &[u8]) -> Result<ReadCloud, String> {
    let (header, data) = Header::read(bytes)?;
    let mut points = match header.form {
        Form::Text => of_text(&header, data),
        Form::Binary => of_rows(&header, data),
        Form::Compressed => of_columns(&header, data),
    }?
    .finish()?;
    points.cloud.viewpoint = header.viewpoint;
    Ok(points)
}

fn of_text(header: &Header, data: &[u8]) -> Result<Collector, String> {
    let columns: usize = header.fields.iter().map(|field| field.count).sum();
    let column = |axis: usize| header.fields[..header.axes[axis]].iter().map(|field| field.count).sum();
    check_count(header.points, columns, data.len())?;
    let text =
        std::str::from_utf8(data).map_err(|_| "the data is no text, as DATA ascii states".to_owned())?;
    let mut points = Collector::new(header.points);
    let mut line = header.lines;
    let axes = [column(0), column(1), column(2)];
    let rest = read_rows(text, &mut line, (header.points, columns), axes, &mut points)?;
    if !rest.trim().is_empty() {
        return Err(format!("more lines follow after {} points, as POINTS states", header.points));
    }
    Ok(points)
}

/// Returns the size of a point and of all points, in bytes.
fn sizes(header: &Header) -> Result<(usize, usize), String> {
    let row: usize = header.fields.iter().map(Field::bytes).sum();
    let all = row.checked_mul(header.points);
    all.map(|all| (row, all)).ok_or_else(|| format!("{} points are too many", header.points))
}

/// Points one after another.
fn of_rows(header: &Header, data: &[u8]) -> Result<Collector, String> {
    let (row, all) = sizes(header)?;
    if data.len() != all {
        return Err(format!(
            "{} points of {row} bytes are announced, which are {all} bytes, but {} follow (was the file cut short, or is its \
             header false?)",
            header.points,
            data.len()
        ));
    }
    let offset = |axis: usize| header.fields[..header.axes[axis]].iter().map(Field::bytes).sum();
    let coordinates = [0, 1, 2].map(|axis| (offset(axis), header.fields[header.axes[axis]].number));
    let layout = Row { coordinates, is_big_endian: false };
    let mut points = Collector::new(header.points);
    for row in data.chunks_exact(row) {
        points.add(layout.point(row).ok_or("a point is cut short")?)?;
    }
    Ok(points)
}

/// Fields one after another, each for all points, compressed.
fn of_columns(header: &Header, data: &[u8]) -> Result<Collector, String> {
    let (_, all) = sizes(header)?;
    let size = |at: usize| data.get(at..at + 4).and_then(|bytes| Number::Unsigned(4).read(bytes, false));
    let (Some(packed), Some(size)) = (size(0), size(4)) else {
        return Err("the sizes of the compressed data are missing".to_owned());
    };
    let packed_bytes = &data[8..];
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "both were read as u32")]
    let (packed, size) = (packed as usize, size as usize);
    if packed_bytes.len() != packed {
        let found = packed_bytes.len();
        return Err(format!(
            "{packed} compressed bytes are announced, but {found} follow (was the file cut short?)"
        ));
    }
    if size != all {
        return Err(format!(
            "{} points take {all} bytes, but the compressed data states {size}",
            header.points
        ));
    }
    let columns = unpacked(packed_bytes, size)?;
    let column = |axis: usize| {
        let begin: usize = header.fields[..header.axes[axis]].iter().map(Field::bytes).sum();
        let number = header.fields[header.axes[axis]].number;
        (number, &columns[begin * header.points..])
    };
    let axes = [column(0), column(1), column(2)];
    let mut points = Collector::new(header.points);
    for index in 0..header.points {
        let mut point = [f64::NAN; 3];
        for (value, (number, column)) in point.iter_mut().zip(axes) {
            let bytes = column.get(index * number.bytes()..).ok_or("a field is cut short")?;
            *value = number.read(bytes, false).ok_or("a field is cut short")?;
        }
        points.add(point)?;
    }
    Ok(points)
}
