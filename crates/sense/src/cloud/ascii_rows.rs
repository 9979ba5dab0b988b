use crate::cloud::collector::Collector;

/// Reads rows of `columns` numbers as text, a line for each point, with the coordinates in these columns; returns the text behind
/// them. `line` is the number of the lines before.
pub(crate) fn read_rows<'a>(
    text: &'a str,
    line: &mut usize,
    (count, columns): (usize, usize),
    axes: [usize; 3],
    points: &mut Collector,
) -> Result<&'a str, String> {
    let mut rest = text;
    let mut read = 0;
    while read < count {
        let Some((row, behind)) = split_line(rest) else {
            return Err(format!("the data ends after {read} of {count} points (was the file cut short?)"));
        };
        *line += 1;
        rest = behind;
        if row.trim().is_empty() {
            continue;
        }
        let mut point = [f64::NAN; 3];
        let mut found = 0;
        for (column, word) in row.split_ascii_whitespace().enumerate() {
            found = column + 1;
            if let Some(axis) = axes.iter().position(|place| *place == column) {
                point[axis] = word
                    .parse()
                    .map_err(|_| format!("line {line}: '{}' is not a number", cranny_file::excerpt(word)))?;
            }
        }
        if found != columns {
            return Err(format!("line {line}: {found} values instead of {columns}"));
        }
        points.add(point)?;
        read += 1;
    }
    Ok(rest)
}

fn split_line(text: &str) -> Option<(&str, &str)> {
    if text.is_empty() { None } else { Some(text.split_once('\n').unwrap_or((text, ""))) }
}

/// Refuses a count of text rows for which the data is too short: each value takes a digit and a separator, the last one only a
/// digit.
pub(crate) fn check_count(count: usize, columns: usize, bytes: usize) -> Result<(), String> {
    let needed = columns.checked_mul(2).and_then(|each| each.checked_mul(count));
    if needed.is_none_or(|needed| needed > bytes + 1) {
        return Err(format!(
            "{count} points are announced, but only {bytes} bytes follow (was the file cut short?)"
        ));
    }
    Ok(())
}
