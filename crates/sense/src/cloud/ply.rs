use cranny_file::excerpt;

use crate::cloud::ascii_rows::{check_count, read_rows};
use crate::cloud::collector::Collector;
use crate::cloud::number::Number;
use crate::cloud::read_cloud::ReadCloud;
use crate::cloud::row::{Row, axes};

/// Maximum number of elements and properties of a header: a splat of Gaussians, which has the most, has 63.
const MOST_NAMES: usize = 1000;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Text,
    LittleEndian,
    BigEndian,
}

struct Header {
    form: Form,
    elements: Vec<Element>,
    lines: usize,
}

struct Element {
    name: String,
    count: usize,
    line: usize,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    /// `None` for a list.
    number: Option<Number>,
}

/// Reads the elements `vertex` of a PLY file (Turk 1994, "The PLY polygon file format", whole) as points: their properties `x`,
/// `y` and `z`. Elements behind them, such as faces, are skipped.
///
/// # Errors
/// A sentence on an invalid header, a vertex with a list or behind elements with lists, or data that is cut short.
pub(crate) fn read(bytes: &[u8]) -> Result<ReadCloud, String> {
    let (Header { form, elements, lines: mut line }, mut data) = header(bytes)?;
    let place = elements.iter().position(|element| element.name == "vertex");
    let place = place.ok_or("the file has no element 'vertex'")?;
    for element in &elements[..place] {
        data = skipped(form, element, data, &mut line)?;
    }
    let vertex = &elements[place];
    let names = vertex.properties.iter().map(|property| property.name.as_str());
    let axes = axes(&names).map_err(|problem| format!("line {}: of 'vertex', {problem}", vertex.line))?;
    let numbers = numbers(vertex)?;
    let is_last = place + 1 == elements.len();
    if form == Form::Text {
        check_count(vertex.count, numbers.len(), data.len())?;
        let text = std::str::from_utf8(data)
            .map_err(|_| "the data is no text, as 'format ascii' states".to_owned())?;
        let mut points = Collector::new(vertex.count);
        let rest = read_rows(text, &mut line, (vertex.count, numbers.len()), axes, &mut points)?;
        if is_last && !rest.trim().is_empty() {
            return Err(format!("more lines follow after {} vertices", vertex.count));
        }
        return points.finish();
    }
    let row_bytes: usize = numbers.iter().map(|number| number.bytes()).sum();
    let all = vertex.count.checked_mul(row_bytes).filter(|all| *all <= data.len());
    let all = all.ok_or_else(|| short(vertex, data.len()))?;
    if is_last && data.len() != all {
        return Err(format!("{} bytes follow the last vertex", data.len() - all));
    }
    let offset = |axis: usize| numbers[..axes[axis]].iter().map(|number| number.bytes()).sum();
    let coordinates = [0, 1, 2].map(|axis| (offset(axis), numbers[axes[axis]]));
    let layout = Row { coordinates, is_big_endian: form == Form::BigEndian };
    let mut points = Collector::new(vertex.count);
    for row in data[..all].chunks_exact(row_bytes) {
        points.add(layout.point(row).ok_or("a vertex is cut short")?)?;
    }
    points.finish()
}

fn short(element: &Element, bytes: usize) -> String {
    let Element { name, count, line, .. } = element;
    format!(
        "line {line}: {count} elements '{name}' are announced, but only {bytes} bytes are left (was the file cut short?)"
    )
}

/// Returns the types of the properties of an element without lists.
fn numbers(element: &Element) -> Result<Vec<Number>, String> {
    let number = |property: &Property| {
        property.number.ok_or_else(|| {
            format!(
                "line {}: the list '{}' of '{}' is not read in a cloud",
                element.line, property.name, element.name
            )
        })
    };
    element.properties.iter().map(number).collect()
}

/// Returns the data behind an element.
fn skipped<'a>(form: Form, element: &Element, data: &'a [u8], line: &mut usize) -> Result<&'a [u8], String> {
    let mut rest = data;
    if form == Form::Text {
        for _ in 0..element.count {
            let end =
                rest.iter().position(|byte| *byte == b'\n').ok_or_else(|| short(element, data.len()))?;
            rest = &rest[end + 1..];
            *line += 1;
        }
        return Ok(rest);
    }
    let each: usize = numbers(element)?.iter().map(|number| number.bytes()).sum();
    let all = element.count.checked_mul(each);
    all.and_then(|all| data.get(all..)).ok_or_else(|| short(element, data.len()))
}

/// Reads the header and returns it with the data behind it.
fn header(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
    let (mut form, mut elements, mut rest, mut line) = (None, Vec::<Element>::new(), bytes, 0);
    let mut names = 0;
    loop {
        let end = rest.iter().position(|byte| *byte == b'\n');
        let end = end.ok_or("the header has no 'end_header' (was the file cut short?)")?;
        line += 1;
        let text = std::str::from_utf8(&rest[..end]).map_err(|_| format!("line {line} is no text"))?;
        rest = &rest[end + 1..];
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let unknown = || format!("line {line}: '{}' is no line of a PLY header", excerpt(text.trim()));
        match words[..] {
            ["ply"] if line == 1 => {}
            _ if line == 1 => return Err("line 1: a PLY file begins with 'ply'".to_owned()),
            ["end_header"] => break,
            [] | ["comment" | "obj_info", ..] => {}
            ["format", kind, "1.0"] => {
                form = Some(match kind {
                    "ascii" => Form::Text,
                    "binary_little_endian" => Form::LittleEndian,
                    "binary_big_endian" => Form::BigEndian,
                    _ => return Err(unknown()),
                });
            }
            ["element", name, count] => {
                let count =
                    count.parse().map_err(|_| format!("line {line}: '{}' is no count", excerpt(count)))?;
                if elements.iter().any(|element| element.name == name) {
                    return Err(format!("line {line}: the element '{}' is given twice", excerpt(name)));
                }
                elements.push(Element { name: name.to_owned(), count, line, properties: Vec::new() });
                names += 1;
            }
            ["property", ref kind @ .., name] => {
                let number = match kind {
                    [kind] => Some(named(kind).ok_or_else(unknown)?),
                    ["list", count, kind] if named(count).is_some() && named(kind).is_some() => None,
                    _ => return Err(unknown()),
                };
                let element = elements.last_mut().ok_or_else(unknown)?;
                element.properties.push(Property { name: name.to_owned(), number });
                names += 1;
            }
            _ => return Err(unknown()),
        }
        if names > MOST_NAMES {
            return Err(format!("line {line}: more than {MOST_NAMES} elements and properties"));
        }
    }
    let form = form.ok_or("the header has no line 'format'")?;
    Ok((Header { form, elements, lines: line }, rest))
}

fn named(name: &str) -> Option<Number> {
    Some(match name {
        "char" | "int8" => Number::Signed(1),
        "uchar" | "uint8" => Number::Unsigned(1),
        "short" | "int16" => Number::Signed(2),
        "ushort" | "uint16" => Number::Unsigned(2),
        "int" | "int32" => Number::Signed(4),
        "uint" | "uint32" => Number::Unsigned(4),
        "float" | "float32" => Number::Float(4),
        "double" | "float64" => Number::Float(8),
        _ => return None,
    })
}
