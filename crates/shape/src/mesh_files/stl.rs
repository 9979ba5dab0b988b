use cranny_spatial::Point;

use crate::mesh_files::mesh_size::check_corners;
use crate::mesh_files::polygon::triangulate;

/// Corners of the triangles of an STL file, three at a time.
///
/// Some programs leave the count of a binary file at zero; the file is then read to its end. Zeros and blanks that pad a file
/// are ignored. A text may have several solids, and letters of either case; only the name of a solid ends with its line.
///
/// # Errors
/// A message: a binary file with fewer triangles than its count, or with other bytes after them; a text without an end, or with
/// words that are unknown or in the wrong order.
pub(crate) fn corners(bytes: &[u8]) -> Result<Vec<Point>, String> {
    if let Some((triangles, rest)) = counted_triangles(bytes) {
        if !rest.iter().all(|byte| *byte == 0 || byte.is_ascii_whitespace()) {
            let count = triangles.len() / TRIANGLE_BYTES;
            return Err(format!(
                "{} bytes that are no zeros follow the binary STL file of {count} triangles (is its count wrong, or \
                 are two files joined?)",
                rest.len()
            ));
        }
        check_corners(3 * (triangles.len() / TRIANGLE_BYTES))?;
        return Ok(triangles.chunks_exact(TRIANGLE_BYTES).flat_map(binary_corners).collect());
    }
    if bytes.contains(&0) {
        let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES).map_or(0, little_endian);
        let needed = HEADER_BYTES as u64 + u64::from(count) * TRIANGLE_BYTES as u64;
        return Err(format!(
            "a binary STL file of {count} triangles has {needed} bytes, but this one has {} (is it cut off, or its \
             count wrong?)",
            bytes.len()
        ));
    }
    let has_end = bytes.windows(END.len()).any(|word| word.eq_ignore_ascii_case(END));
    if !has_end {
        return Err("the text has no 'endsolid' (is the file cut off, or no STL file?)".into());
    }
    text_corners(&String::from_utf8_lossy(bytes))
}

/// Size of the header: a comment of 80 bytes, and the count of the triangles.
const HEADER_BYTES: usize = 84;

/// Size of a triangle: a normal and three corners in single precision, and two unused bytes.
const TRIANGLE_BYTES: usize = 50;

const END: &[u8] = b"endsolid";

/// Triangles of a binary file, and the bytes after them. No text is mistaken for one: its count would mean half a gigabyte.
fn counted_triangles(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (header, triangles) = bytes.split_at_checked(HEADER_BYTES)?;
    let count = match usize::try_from(little_endian(&header[HEADER_BYTES - 4..])).ok()? {
        0 => triangles.len() / TRIANGLE_BYTES,
        count => count,
    };
    triangles.split_at_checked(count.checked_mul(TRIANGLE_BYTES)?)
}

fn binary_corners(triangle: &[u8]) -> [Point; 3] {
    let number = |index: usize| f64::from(f32::from_bits(little_endian(&triangle[4 * index..4 * index + 4])));
    [3, 6, 9].map(|first| Point::new(number(first), number(first + 1), number(first + 2)))
}

fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u32::from(*byte))
}

fn text_corners(text: &str) -> Result<Vec<Point>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut solids = Solids::default();
    for (index, line) in text.split('\n').enumerate() {
        for line in line.split('\r') {
            solids.read_line(line).map_err(|message| format!("line {}: {message}", index + 1))?;
        }
    }
    if solids.is_open || solids.facet.is_some() {
        return Err("the last solid has no 'endsolid' (is the file cut off?)".into());
    }
    Ok(solids.corners)
}

/// Solids of a text, as parsed up to the current line.
#[derive(Default)]
struct Solids {
    corners: Vec<Point>,
    is_open: bool,
    /// Corners of a facet that has no end yet.
    facet: Option<Vec<Point>>,
}

impl Solids {
    fn read_line(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_whitespace().peekable();
        let unknown = || format!("'{}' is no line of an STL file", cranny_file::excerpt(line.trim()));
        while let Some(word) = words.next() {
            match word.to_ascii_lowercase().as_str() {
                word @ ("solid" | "endsolid") => {
                    if self.facet.is_some() {
                        return Err(format!("'{word}' before the 'endfacet' of a facet"));
                    }
                    self.is_open = word == "solid";
                    return check_name(word, &words.collect::<Vec<_>>());
                }
                "facet" => {
                    if self.facet.replace(Vec::new()).is_some() {
                        return Err("a facet begins, but the one before has no 'endfacet'".into());
                    }
                    self.is_open = true;
                    // The normal follows from the corners, and some programs do not even write a number for it.
                    while words.next_if(|word| !is_one_of(word, &FACET_KEYWORDS)).is_some() {}
                }
                "outer" => {
                    words.next_if(|word| is_one_of(word, &["loop"])).ok_or_else(unknown)?;
                    self.is_open = true;
                    if !self.facet.get_or_insert_default().is_empty() {
                        return Err("a facet has a second loop (cut it into facets of one loop)".into());
                    }
                }
                "vertex" => {
                    let number = |word: &str| word.parse::<f32>().ok().map(f64::from);
                    let numbers: Vec<f64> = words.by_ref().take(3).map_while(number).collect();
                    let [x, y, z] = numbers[..] else { return Err("a vertex has three numbers".into()) };
                    let facet = self.facet.as_mut().ok_or("a vertex outside of a facet")?;
                    facet.push(Point::new(x, y, z));
                }
                "endloop" => {}
                "endfacet" => {
                    let facet = self.facet.take().unwrap_or_default();
                    if facet.len() < 3 {
                        return Err("a facet has fewer than three corners".into());
                    }
                    let triangles = triangulate(&facet).ok_or("the facet crosses itself")?;
                    self.corners.extend(triangles.into_iter().flatten().map(|corner| facet[corner]));
                    check_corners(self.corners.len())?;
                }
                _ => return Err(unknown()),
            }
        }
        Ok(())
    }
}

const FACET_KEYWORDS: [&str; 6] = ["outer", "vertex", "endloop", "endfacet", "facet", "endsolid"];

fn is_one_of(word: &str, keywords: &[&str]) -> bool {
    keywords.iter().any(|keyword| word.eq_ignore_ascii_case(keyword))
}

/// Rejects a name that contains corners, because a name takes the rest of its line.
fn check_name(keyword: &str, name: &[&str]) -> Result<(), String> {
    let is_corner = |words: &[&str]| {
        is_one_of(words[0], &["vertex"]) && words[1..].iter().all(|word| word.parse::<f32>().is_ok())
    };
    if name.iter().any(|word| is_one_of(word, &["facet", "loop"])) && name.windows(4).any(is_corner) {
        return Err(format!(
            "facets follow '{keyword}' on its line, where its name stands (begin a new line)"
        ));
    }
    Ok(())
}
