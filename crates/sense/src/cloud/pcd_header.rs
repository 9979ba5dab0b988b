use cranny_file::excerpt;
use cranny_spatial::{Pose, rotation_from_xyzw};

use crate::cloud::number::Number;
use crate::cloud::row::axes;

/// Form of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    Text,
    Binary,
    Compressed,
}

/// Field of a point: `count` numbers of one type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Field {
    pub number: Number,
    pub count: usize,
}

impl Field {
    /// Size in bytes.
    pub fn bytes(&self) -> usize {
        self.number.bytes() * self.count
    }
}

/// Header of a PCD file.
#[derive(Debug)]
pub(crate) struct Header {
    pub fields: Vec<Field>,
    /// Places of x, y and z among the fields.
    pub axes: [usize; 3],
    pub points: usize,
    pub viewpoint: Option<Pose>,
    pub form: Form,
    /// Number of lines of the header.
    pub lines: usize,
}

/// Maximum number of fields.
const MOST_FIELDS: usize = 256;

/// Maximum number of numbers in a field.
const MOST_IN_A_FIELD: usize = 1 << 20;

/// Maximum number of lines of a header.
const MOST_LINES: usize = 10_000;

/// Lines of a header by their first word.
#[derive(Default)]
struct Lines<'a> {
    known: Vec<(&'static str, usize, Vec<&'a str>)>,
}

const KEYS: [&str; 10] =
    ["VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"];

impl<'a> Lines<'a> {
    /// Returns the words of a line, with its number; an error if it is missing.
    fn of(&self, key: &str) -> Result<(usize, &[&'a str]), String> {
        self.optional(key).ok_or_else(|| format!("the header has no line {key}"))
    }

    fn optional(&self, key: &str) -> Option<(usize, &[&'a str])> {
        let found = self.known.iter().find(|(known, ..)| *known == key);
        found.map(|(_, line, words)| (*line, &words[..]))
    }

    fn count(&self, key: &str) -> Result<usize, String> {
        let (line, words) = self.of(key)?;
        let [word] = words[..] else { return Err(format!("line {line}: {key} is one number")) };
        whole(line, word)
    }
}

fn whole(line: usize, word: &str) -> Result<usize, String> {
    word.parse().map_err(|_| format!("line {line}: '{}' is not a whole number, at least 0", excerpt(word)))
}

impl Header {
    /// Reads the header and returns it with the data behind it.
    pub fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let mut lines = Lines::default();
        let (mut rest, mut number) = (bytes, 0);
        while lines.optional("DATA").is_none() {
            let end = rest.iter().position(|byte| *byte == b'\n').ok_or("the header has no line DATA")?;
            number += 1;
            let text = std::str::from_utf8(&rest[..end]).map_err(|_| format!("line {number} is no text"))?;
            rest = &rest[end + 1..];
            let mut words = text.split_ascii_whitespace();
            let Some(first) = words.next().filter(|word| !word.starts_with('#')) else {
                if number > MOST_LINES {
                    return Err(format!("the header has more than {MOST_LINES} lines"));
                }
                continue;
            };
            let key = KEYS.iter().find(|key| **key == first);
            let key =
                key.ok_or_else(|| format!("line {number}: '{}' is no line of a PCD header", excerpt(first)))?;
            if lines.optional(key).is_some() {
                return Err(format!("line {number}: {key} is given twice"));
            }
            lines.known.push((key, number, words.take(MOST_FIELDS + 1).collect()));
        }
        Self::of_lines(&lines, number).map(|header| (header, rest))
    }

    fn of_lines(lines: &Lines, count: usize) -> Result<Self, String> {
        let (line, version) = lines.of("VERSION")?;
        if !matches!(version, ["0.7" | ".7"]) {
            return Err(format!(
                "line {line}: version {} of PCD is not read, only 0.7",
                excerpt(&version.join(" "))
            ));
        }
        let (line, names) = lines.of("FIELDS")?;
        if names.is_empty() || names.len() > MOST_FIELDS {
            return Err(format!("line {line}: a PCD has 1 to {MOST_FIELDS} fields"));
        }
        let axes = axes(&names.iter().copied()).map_err(|problem| format!("line {line}: {problem}"))?;
        let fields = fields(lines, names.len())?;
        for axis in axes {
            if fields[axis].count != 1 {
                return Err(format!(
                    "the field '{}' has {} numbers instead of one",
                    names[axis], fields[axis].count
                ));
            }
        }
        let (width, height) = (lines.count("WIDTH")?, lines.count("HEIGHT")?);
        let points = lines.count("POINTS")?;
        if width.checked_mul(height) != Some(points) {
            return Err(format!("POINTS is {points}, but WIDTH × HEIGHT is {width} × {height}"));
        }
        let (line, form) = lines.of("DATA")?;
        let form = match form {
            ["ascii"] => Form::Text,
            ["binary"] => Form::Binary,
            ["binary_compressed"] => Form::Compressed,
            _ => return Err(format!("line {line}: DATA is ascii, binary or binary_compressed")),
        };
        Ok(Self { fields, axes, points, viewpoint: viewpoint(lines)?, form, lines: count })
    }
}

fn fields(lines: &Lines, count: usize) -> Result<Vec<Field>, String> {
    let (size_line, sizes) = lines.of("SIZE")?;
    let (type_line, kinds) = lines.of("TYPE")?;
    // Without COUNT each field is one number.
    let counts = lines.optional("COUNT");
    let of_counts = counts.map(|(line, words)| ("COUNT", line, words.len()));
    for (key, line, found) in
        [Some(("SIZE", size_line, sizes.len())), Some(("TYPE", type_line, kinds.len())), of_counts]
            .into_iter()
            .flatten()
    {
        if found != count {
            return Err(format!("line {line}: {key} has {found} values for {count} fields"));
        }
    }
    let field = |index: usize| {
        let (kind, size) = (kinds[index], whole(size_line, sizes[index])?);
        let number = match (kind, size) {
            ("F", 4 | 8) => Number::Float(size),
            ("I", 1 | 2 | 4 | 8) => Number::Signed(size),
            ("U", 1 | 2 | 4 | 8) => Number::Unsigned(size),
            _ => return Err(format!("line {type_line}: type {} of {size} bytes is not read", excerpt(kind))),
        };
        let count = match counts {
            Some((line, words)) => whole(line, words[index])?,
            None => 1,
        };
        if !(1..=MOST_IN_A_FIELD).contains(&count) {
            return Err(format!("a field has 1 to {MOST_IN_A_FIELD} numbers, not {count}"));
        }
        Ok(Field { number, count })
    };
    (0..count).map(field).collect()
}

fn viewpoint(lines: &Lines) -> Result<Option<Pose>, String> {
    let Some((line, words)) = lines.optional("VIEWPOINT") else { return Ok(None) };
    let fault = || format!("line {line}: VIEWPOINT is seven numbers: tx ty tz qw qx qy qz");
    let numbers: Vec<f64> =
        words.iter().map(|word| word.parse().map_err(|_| fault())).collect::<Result<_, _>>()?;
    let [x, y, z, qw, qx, qy, qz] = numbers[..] else { return Err(fault()) };
    if !numbers.iter().all(|number| number.is_finite()) {
        return Err(fault());
    }
    let rotation = rotation_from_xyzw([qx, qy, qz, qw])
        .map_err(|norm| format!("line {line}: the quaternion of VIEWPOINT has length {norm} instead of 1"))?;
    Ok(Some(Pose::from_parts(cranny_spatial::Vector::new(x, y, z).into(), rotation)))
}
