use cranny_spatial::Point;

use crate::mesh_files::mesh_size::{check_corners, check_vertices};
use crate::mesh_files::polygon::triangulate;

/// Corners of the triangles of a PLY file (Turk 1994, "The PLY polygon file format", whole), three at a time. Reads text
/// and both binary forms; skips elements other than `vertex`, `face` and `tristrips`.
///
/// # Errors
/// A message, with the line of a header or a text: an unknown type or form, a repeated name, a count for which the file
/// is too short or too long, an index without a vertex, a face that crosses itself, no faces.
pub(crate) fn corners(bytes: &[u8]) -> Result<Vec<Point>, String> {
    let (header, body) = Header::read(bytes)?;
    let mut body = Body { form: header.form, rest: body, line: header.lines };
    let mut vertices = Vec::new();
    let mut polygons = Polygons::default();
    for element in &header.elements {
        element.check_count(&body)?;
        match element.name.as_str() {
            "vertex" => vertices = read_vertices(element, &mut body)?,
            "face" => polygons.read(element, &mut body, Polygons::add)?,
            "tristrips" => polygons.read(element, &mut body, Polygons::add_strips)?,
            _ => element.read(&mut body, |_, _, _| Ok(()))?,
        }
    }
    body.check_end()?;
    let has = |name: &str| header.elements.iter().any(|element| element.name == name);
    if !has("vertex") {
        return Err(format!("the file has no element 'vertex' ({})", header.names()));
    }
    if !has("face") && !has("tristrips") {
        let hint = if header.elements.len() == 1 { "; is it a cloud of points?" } else { "" };
        return Err(format!("the file has no element 'face' ({}{hint})", header.names()));
    }
    polygons.corners(&vertices)
}

#[derive(Clone, Copy, PartialEq)]
enum Form {
    Text,
    LittleEndian,
    BigEndian,
}

/// Type of a number, with its size in bytes in the binary forms.
#[derive(Clone, Copy, PartialEq)]
enum Number {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Number {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::Signed(1),
            "uchar" | "uint8" => Self::Unsigned(1),
            "short" | "int16" => Self::Signed(2),
            "ushort" | "uint16" => Self::Unsigned(2),
            "int" | "int32" => Self::Signed(4),
            "uint" | "uint32" => Self::Unsigned(4),
            "float" | "float32" => Self::Float(4),
            "double" | "float64" => Self::Float(8),
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        let (Self::Signed(bytes) | Self::Unsigned(bytes) | Self::Float(bytes)) = self;
        bytes
    }
}

struct Property {
    name: String,
    /// Type of the length of a list; `None` for a single number.
    length: Option<Number>,
    number: Number,
}

struct Element {
    name: String,
    count: u64,
    line: usize,
    properties: Vec<Property>,
}

impl Element {
    /// Rejects a count for which the rest of the file is too short, before any memory is allocated for it.
    fn check_count(&self, body: &Body) -> Result<(), String> {
        let least = |property: &Property| match body.form {
            // A digit and a separator.
            Form::Text => 2,
            _ => property.length.unwrap_or(property.number).bytes() as u64,
        };
        let each: u64 = self.properties.iter().map(least).sum();
        if each == 0 && self.count > 0 {
            return Err(format!("line {}: the elements '{}' have no properties", self.line, self.name));
        }
        // The last number of a text needs no separator.
        let rest = body.rest.len() as u64 + u64::from(body.form == Form::Text);
        if self.count.checked_mul(each).is_none_or(|needed| needed > rest) {
            return Err(format!(
                "line {}: {} elements '{}' are announced, but only {} bytes are left for them (is the file cut \
                 off?)",
                self.line,
                self.count,
                self.name,
                body.rest.len()
            ));
        }
        Ok(())
    }

    /// Calls `visit` with the index of each element, the index of each of its properties and its numbers.
    fn read(
        &self,
        body: &mut Body,
        mut visit: impl FnMut(u64, usize, &[f64]) -> Result<(), String>,
    ) -> Result<(), String> {
        /// Maximum number of numbers in one list, as for the corners of a whole mesh.
        const MOST_IN_A_LIST: u32 = 24_000_000;
        let mut numbers = Vec::new();
        for index in 0..self.count {
            for (at, property) in self.properties.iter().enumerate() {
                let length = match property.length {
                    Some(kind) => body.index(kind)?,
                    None => 1,
                };
                if length > MOST_IN_A_LIST {
                    return Err(format!(
                        "element {index} of '{}' has a list of {length} numbers, but at most {MOST_IN_A_LIST} are \
                         read",
                        self.name
                    ));
                }
                numbers.clear();
                for _ in 0..length {
                    numbers.push(body.number(property.number)?);
                }
                visit(index, at, &numbers)?;
            }
        }
        Ok(())
    }
}

struct Header {
    form: Form,
    elements: Vec<Element>,
    lines: usize,
}

/// Maximum number of elements and properties in a header: each name is compared with all others. A splat of Gaussians, which
/// has the most, has 63.
const MOST_NAMES: usize = 1000;

impl Header {
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let mut header = Self { form: Form::Text, elements: Vec::new(), lines: 0 };
        let (mut rest, mut has_form, mut named) = (bytes, false, 0);
        loop {
            let end = rest.iter().position(|byte| *byte == b'\n');
            let end = end.ok_or("the header has no 'end_header' (is the file cut off, or no PLY file?)")?;
            header.lines += 1;
            let at = header.lines;
            let line = std::str::from_utf8(&rest[..end]).map_err(|_| format!("line {at} is no text"))?;
            rest = &rest[end + 1..];
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let excerpt = cranny_file::excerpt(line.trim());
            let unknown = || format!("line {at}: '{excerpt}' is no line of a PLY header");
            if ["element", "property"].contains(words.first().unwrap_or(&"")) {
                named += 1;
            }
            if named > MOST_NAMES {
                return Err(format!("line {at}: more than {MOST_NAMES} elements and properties"));
            }
            if at == 1 {
                if words != ["ply"] {
                    return Err("line 1: a PLY file begins with 'ply'".into());
                }
                continue;
            }
            match words[..] {
                ["end_header"] => break,
                [] | ["comment" | "obj_info", ..] => {}
                ["format", form, "1.0"] => {
                    has_form = true;
                    header.form = match form {
                        "ascii" => Form::Text,
                        "binary_little_endian" => Form::LittleEndian,
                        "binary_big_endian" => Form::BigEndian,
                        _ => return Err(unknown()),
                    };
                }
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| format!("line {at}: '{count}' is no count"))?;
                    let (name, properties) = (name.to_owned(), Vec::new());
                    if let Some(first) = header.elements.iter().find(|element| element.name == name) {
                        return Err(format!("line {at}: line {} has an element '{name}' too", first.line));
                    }
                    header.elements.push(Element { name, count, line: at, properties });
                }
                ["property", ref property @ ..] => {
                    let element = header.elements.last_mut().ok_or_else(unknown)?;
                    let property = read_property(property).ok_or_else(unknown)?;
                    if element.properties.iter().any(|other| other.name == property.name) {
                        let (element, name) = (&element.name, property.name);
                        return Err(format!(
                            "line {at}: a second property '{name}' of the element '{element}'"
                        ));
                    }
                    element.properties.push(property);
                }
                _ => return Err(unknown()),
            }
        }
        if has_form { Ok((header, rest)) } else { Err("the header has no line 'format'".into()) }
    }

    /// Names of the elements, as a phrase for a message.
    fn names(&self) -> String {
        match &self.elements.iter().map(|element| format!("'{}'", element.name)).collect::<Vec<_>>()[..] {
            [] => "it has none".into(),
            names => format!("its elements are {}", cranny_file::excerpt(&names.join(", "))),
        }
    }
}

fn read_property(words: &[&str]) -> Option<Property> {
    let (length, number, name) = match *words {
        ["list", length, number, name] => (Some(Number::named(length)?), number, name),
        [number, name] => (None, number, name),
        _ => return None,
    };
    let is_count = !matches!(length, Some(Number::Float(_)));
    is_count.then_some(Property { name: name.to_owned(), length, number: Number::named(number)? })
}

/// Unread rest of the file after the header.
struct Body<'a> {
    form: Form,
    rest: &'a [u8],
    line: usize,
}

impl Body<'_> {
    fn number(&mut self, kind: Number) -> Result<f64, String> {
        if self.form == Form::Text { self.word(kind) } else { self.binary(kind) }
    }

    /// Reads a number that must be an index or a count.
    fn index(&mut self, kind: Number) -> Result<u32, String> {
        as_index(self.number(kind)?).map_err(|fault| {
            if self.form == Form::Text { format!("line {}: {fault}", self.line + 1) } else { fault }
        })
    }

    /// Rejects bytes after the last element, unless they are zeros and blanks that pad the file.
    fn check_end(&self) -> Result<(), String> {
        let is_text = self.form == Form::Text;
        let is_filling = |byte: &u8| byte.is_ascii_whitespace() || (!is_text && *byte == 0);
        if self.rest.iter().all(is_filling) {
            return Ok(());
        }
        let rest = if is_text { self.rest.trim_ascii_start() } else { self.rest };
        let left = format!("{} bytes follow what the header announces (is a count wrong?)", rest.len());
        let blanks = &self.rest[..self.rest.len() - rest.len()];
        let line = self.line + blanks.split(|byte| *byte == b'\n').count();
        Err(if is_text { format!("line {line}: {left}") } else { left })
    }

    fn word(&mut self, kind: Number) -> Result<f64, String> {
        let begin = self.rest.iter().position(|byte| !byte.is_ascii_whitespace());
        let begin = begin.ok_or("the file ends before all that its header announces")?;
        self.line += self.rest[..begin].split(|byte| *byte == b'\n').count() - 1;
        let rest = &self.rest[begin..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let word = String::from_utf8_lossy(&rest[..end]);
        self.rest = &rest[end..];
        let number = match kind {
            // A single rounding, to the precision of the type.
            Number::Float(4) => word.parse::<f32>().ok().map(f64::from),
            _ => word.parse().ok(),
        };
        number
            .ok_or_else(|| format!("line {}: '{}' is no number", self.line + 1, cranny_file::excerpt(&word)))
    }

    fn binary(&mut self, kind: Number) -> Result<f64, String> {
        let (bytes, rest) = self
            .rest
            .split_at_checked(kind.bytes())
            .ok_or("the file ends before all that its header announces")?;
        self.rest = rest;
        let mut little = [0; 8];
        little[..bytes.len()].copy_from_slice(bytes);
        if self.form == Form::BigEndian {
            little[..bytes.len()].reverse();
        }
        let raw = u64::from_le_bytes(little);
        let [b0, b1, b2, b3, ..] = little;
        Ok(match kind {
            Number::Float(4) => f32::from_le_bytes([b0, b1, b2, b3]).into(),
            Number::Float(_) => f64::from_bits(raw),
            Number::Unsigned(_) => f64::from(u32::from_le_bytes([b0, b1, b2, b3])),
            Number::Signed(1) => f64::from(i8::from_le_bytes([b0])),
            Number::Signed(2) => f64::from(i16::from_le_bytes([b0, b1])),
            Number::Signed(_) => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
        })
    }
}

fn as_index(number: f64) -> Result<u32, String> {
    if number >= 0.0 && number <= f64::from(u32::MAX) && number.fract() == 0.0 {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "in the range of the type, as was just seen"
        )]
        Ok(number as u32)
    } else {
        Err(format!("{number} is no index"))
    }
}

fn read_vertices(element: &Element, body: &mut Body) -> Result<Vec<Point>, String> {
    let at = |name: &str| {
        let is_it = |property: &Property| property.name == name && property.length.is_none();
        let found = element.properties.iter().position(is_it);
        found.ok_or_else(|| format!("line {}: a vertex has no property '{name}'", element.line))
    };
    let axes = [at("x")?, at("y")?, at("z")?];
    let mut vertices: Vec<Point> = Vec::new();
    element.read(body, |index, property, numbers| {
        if vertices.len() as u64 == index {
            vertices.push(Point::origin());
        }
        if let (Some(axis), Some(vertex)) = (axes.iter().position(|at| *at == property), vertices.last_mut())
        {
            vertex[axis] = numbers[0];
        }
        check_vertices(vertices.len())
    })?;
    Ok(vertices)
}

/// Polygons as in the file.
#[derive(Default)]
struct Polygons {
    /// Vertex indices of all polygons, one polygon after the other.
    indices: Vec<f64>,
    /// End of each polygon in `indices`.
    ends: Vec<usize>,
}

impl Polygons {
    /// Passes each list of indices of an element to `add`.
    fn read(
        &mut self,
        element: &Element,
        body: &mut Body,
        mut add: impl FnMut(&mut Self, &[f64]),
    ) -> Result<(), String> {
        let is_list = |property: &&Property| {
            ["vertex_indices", "vertex_index"].contains(&property.name.as_str()) && property.length.is_some()
        };
        let lists: Vec<&Property> = element.properties.iter().filter(is_list).collect();
        if lists.len() != 1 && element.count > 0 {
            let what = if lists.is_empty() { "no list" } else { "more than one list" };
            let (line, name) = (element.line, &element.name);
            return Err(format!(
                "line {line}: the element '{name}' has {what} 'vertex_indices' or 'vertex_index'"
            ));
        }
        element.read(body, |_, property, numbers| {
            if is_list(&&element.properties[property]) {
                add(self, numbers);
            }
            // A face without corners takes as much memory as one corner.
            check_corners(self.indices.len().max(self.ends.len()))
        })
    }

    fn add(&mut self, indices: &[f64]) {
        self.indices.extend_from_slice(indices);
        self.ends.push(self.indices.len());
    }

    /// Adds strips of triangles, each ended by −1. Every second triangle of a strip has the opposite winding. A triangle
    /// with a repeated corner only changes the winding.
    fn add_strips(&mut self, indices: &[f64]) {
        for strip in indices.split(|index| index.total_cmp(&-1.0).is_eq()) {
            for (at, triangle) in strip.windows(3).enumerate() {
                let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
                if [(a, b), (b, c), (c, a)].iter().all(|(one, other)| one.total_cmp(other).is_ne()) {
                    self.add(&if at % 2 == 0 { [a, b, c] } else { [b, a, c] });
                }
            }
        }
    }

    fn corners(&self, vertices: &[Point]) -> Result<Vec<Point>, String> {
        let mut corners = Vec::with_capacity(self.indices.len());
        let mut begin = 0;
        for (face, &end) in self.ends.iter().enumerate() {
            let place = |number: &f64| {
                let vertex = as_index(*number)? as usize;
                vertices.get(vertex).copied().ok_or_else(|| {
                    format!("face {face} names vertex {vertex}, but there are only {}", vertices.len())
                })
            };
            let polygon = self.indices[begin..end].iter().map(place).collect::<Result<Vec<_>, _>>()?;
            begin = end;
            let triangles = triangulate(&polygon)
                .ok_or_else(|| format!("face {face}, of {} corners, crosses itself", polygon.len()))?;
            corners.extend(triangles.into_iter().flatten().map(|corner| polygon[corner]));
            check_corners(corners.len())?;
        }
        Ok(corners)
    }
}
