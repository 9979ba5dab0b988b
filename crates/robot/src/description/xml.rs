use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

use cranny_file::{XmlExcess, xml_excess};
use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Point, Pose, Rotation, Vector, sin_cos};
use roxmltree::{Attribute, Document, Node};

use crate::{Location, RobotError};

/// XML document with its name in errors.
pub(crate) struct XmlText<'a> {
    document: Document<'a>,
    file: &'a str,
    /// Offset of each line start, precomputed so that elements need not count the lines before them.
    line_starts: Vec<usize>,
    asked: Asked,
}

/// Content of a document that its reader has requested.
#[derive(Default)]
struct Asked {
    /// Offsets of the elements and attributes that were found.
    read: RefCell<HashSet<usize>>,
    /// Requested attribute names, by the offset of the element.
    attributes: RefCell<HashMap<usize, Vec<&'static str>>>,
    children: RefCell<HashMap<usize, Vec<&'static str>>>,
}

/// Joins every undeclared namespace prefix to the name that follows it by a dot. Programs that read XML without namespaces
/// write such prefixes (`<drake:acceleration …>`). All offsets in the text stay the same. The prefix `xacro` is left
/// unchanged: a file with it is not yet a URDF. A text that [`XmlText::parse`] refuses for its size stays as it is.
pub(crate) fn known_prefixes(text: &str) -> Cow<'_, str> {
    /// Maximum number of different prefixes; no known file has more.
    const MOST: usize = 16;
    let mut known = Cow::Borrowed(text);
    let prefixes = if xml_excess(text).is_some() { 0 } else { MOST };
    for _ in 0..prefixes {
        let prefix = match Document::parse(&known) {
            Err(roxmltree::Error::UnknownNamespace(prefix, _)) if prefix != "xacro" => prefix,
            _ => break,
        };
        let mut named = known.into_owned();
        for before in ["<", "</", " ", "\t", "\n"] {
            named = named.replace(&format!("{before}{prefix}:"), &format!("{before}{prefix}."));
        }
        known = Cow::Owned(named);
    }
    known
}

impl<'a> XmlText<'a> {
    pub(crate) fn parse(text: &'a str, file: &'a str) -> Result<Self, RobotError> {
        if text.trim().is_empty() {
            return Err(RobotError::Empty { file: file.to_owned() });
        }
        // Files of Gazebo begin with empty lines, before which a declaration is not well-formed.
        let body = text.trim_start();
        let skipped = text[..text.len() - body.len()].matches('\n').count();
        let starts = std::iter::once(0).chain(body.match_indices('\n').map(|(end, _)| end + 1));
        let line_starts: Vec<usize> = std::iter::repeat_n(0, skipped).chain(starts).collect();
        let place = |line| Location { file: file.to_owned(), line: u32::try_from(line).unwrap_or(u32::MAX) };
        if let Some(XmlExcess { line, what, most, actual }) = xml_excess(text) {
            return Err(RobotError::TooMany { at: place(line), what, most, actual });
        }
        let document = Document::parse(body).map_err(|reason| {
            // The parser gives no position for a text that ends too early; the error is then at the last line.
            let line = match reason {
                roxmltree::Error::UnclosedRootNode | roxmltree::Error::UnexpectedEndOfStream => {
                    text.lines().count()
                }
                ref other => skipped + other.pos().row as usize,
            };
            let at = place(line);
            if matches!(&reason, roxmltree::Error::UnknownNamespace(prefix, _) if prefix == "xacro") {
                return RobotError::Xacro { at, file: file.to_owned() };
            }
            RobotError::Xml { at, reason: Box::new(reason) }
        })?;
        let xml = Self { document, file, line_starts, asked: Asked::default() };
        let is_xacro = |node: &Node<'_, '_>| node.tag_name().namespace().is_some_and(|n| n.contains("xacro"));
        match xml.document.descendants().find(is_xacro) {
            Some(node) => Err(RobotError::Xacro { at: xml.element(node).at(), file: file.to_owned() }),
            None => Ok(xml),
        }
    }

    fn element<'x>(&'x self, node: Node<'x, 'x>) -> Element<'x> {
        let namespace = self.document.root_element().tag_name().namespace();
        Element { node, file: self.file, line_starts: &self.line_starts, asked: &self.asked, namespace }
    }

    /// Outermost element.
    pub(crate) fn root(&self) -> Element<'_> {
        self.element(self.document.root_element())
    }

    /// Returns the outermost element, which must be `<robot>`.
    pub(crate) fn robot(&self) -> Result<Element<'_>, RobotError> {
        let robot = self.root();
        if robot.tag() != "robot" {
            return Err(RobotError::NotARobot { at: robot.at(), found: robot.tag().into_owned() });
        }
        Ok(robot)
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Element<'a> {
    node: Node<'a, 'a>,
    file: &'a str,
    line_starts: &'a [usize],
    asked: &'a Asked,
    /// Namespace of the outermost element, stored because the search for that element passes all comments in front of it.
    namespace: Option<&'a str>,
}

impl<'a> Element<'a> {
    /// Returns the element name; with its prefix if its namespace differs from that of the outermost element.
    pub(crate) fn tag(&self) -> Cow<'a, str> {
        let name = self.node.tag_name();
        if name.namespace() == self.namespace {
            return with_colon(name.name());
        }
        let text = &self.node.document().input_text()[self.node.range().start + 1..];
        let end = text.find(|c: char| c.is_ascii_whitespace() || c == '/' || c == '>');
        Cow::Borrowed(&text[..end.unwrap_or(text.len())])
    }

    fn attribute_name(&self, attribute: Attribute<'a, 'a>) -> Cow<'a, str> {
        match attribute.namespace() {
            Some(namespace) if Some(namespace) != self.namespace => {
                Cow::Borrowed(&self.node.document().input_text()[attribute.range_qname()])
            }
            _ => with_colon(attribute.name()),
        }
    }

    pub(crate) fn at(&self) -> Location {
        Location { file: self.file.to_owned(), line: line_of(self.line_starts, self.node.range().start) }
    }

    /// Name of its file in errors.
    pub(crate) fn file(&self) -> &'a str {
        self.file
    }

    /// Byte range of the element in the document, tags included.
    pub(crate) fn place(&self) -> Range<usize> {
        self.node.range()
    }

    /// Start and end offset of its content in the document; for an element that is one tag, both are before its `>`.
    pub(crate) fn inside(&self) -> (usize, usize) {
        let text = self.node.document().input_text();
        let whole = self.node.range();
        match text[whole.clone()].rfind("</") {
            Some(end) if self.node.has_children() || text[whole.clone()].ends_with("</robot>") => {
                let first = self.node.first_child().map_or(whole.start + end, |child| child.range().start);
                (first, whole.start + end)
            }
            _ => (whole.end - 1, whole.end - 1),
        }
    }

    /// Names of its attributes, without those that have a namespace.
    pub(crate) fn attribute_names(&self) -> impl Iterator<Item = &'a str> {
        self.node
            .attributes()
            .filter(|attribute| attribute.namespace().is_none())
            .map(|attribute| attribute.name())
    }

    /// Direct child elements; does not mark them as read.
    pub(crate) fn inner(self) -> impl Iterator<Item = Element<'a>> {
        self.node.children().filter(Node::is_element).map(move |node| Element { node, ..self })
    }

    /// Direct child elements; marks them as read.
    pub(crate) fn children(self) -> impl Iterator<Item = Element<'a>> {
        self.inner().inspect(Self::mark_read)
    }

    /// This element and all its descendants.
    pub(crate) fn within(self) -> impl Iterator<Item = Element<'a>> {
        self.node.descendants().filter(Node::is_element).map(move |node| Element { node, ..self })
    }

    fn mark_read(&self) {
        self.asked.read.borrow_mut().insert(self.node.range().start);
    }

    /// Direct child elements named `tag`.
    pub(crate) fn all(self, tag: &'static str) -> impl Iterator<Item = Element<'a>> {
        request(&self.asked.children, self.node.range().start, tag);
        self.inner().filter(move |child| child.tag() == tag).inspect(Self::mark_read)
    }

    /// Direct child elements, each with a flag that is true if it was read.
    pub(crate) fn children_and_use(self) -> impl Iterator<Item = (Element<'a>, bool)> {
        let is_read = move |child: &Self| self.asked.read.borrow().contains(&child.node.range().start);
        self.inner().map(move |child| (child, is_read(&child)))
    }

    /// Names of the attributes that were not read.
    pub(crate) fn unread_attributes(self) -> Vec<Cow<'a, str>> {
        let read = self.asked.read.borrow();
        let unread = self.node.attributes().filter(|attribute| !read.contains(&attribute.range().start));
        unread.map(|attribute| self.attribute_name(attribute)).collect()
    }

    /// Attributes that the reader requested in this element, sorted.
    pub(crate) fn asked_attributes(&self) -> Vec<&'static str> {
        names_of(&self.asked.attributes, self.node.range().start)
    }

    /// Elements that the reader requested in this one, sorted.
    pub(crate) fn asked_children(&self) -> Vec<&'static str> {
        names_of(&self.asked.children, self.node.range().start)
    }

    /// First non-blank text directly inside.
    pub(crate) fn own_text(&self) -> Option<&'a str> {
        let texts = self.node.children().filter(Node::is_text).filter_map(|node| node.text());
        texts.map(str::trim).find(|text| !text.is_empty())
    }

    /// Returns the element name with its `name` or that of its nearest ancestor with one: ``<origin> of link `bar` ``.
    pub(crate) fn title(&self) -> String {
        let named = |node: &Node<'a, 'a>| Some((node.tag_name().name(), node.attribute("name")?));
        match self.node.ancestors().skip(1).find_map(|node| named(&node)) {
            _ if named(&self.node).is_some_and(|(tag, _)| tag == "link" || tag == "joint") => {
                format!("{} `{}`", self.tag(), self.node.attribute("name").unwrap_or_default())
            }
            Some((tag, name)) if tag != "robot" => format!("<{}> of {tag} `{name}`", self.tag()),
            _ => format!("<{}>", self.tag()),
        }
    }

    pub(crate) fn first(self, tag: &'static str) -> Option<Element<'a>> {
        self.all(tag).next()
    }

    /// Returns the first child element named `tag`; `owner` names this element in the error if there is none.
    pub(crate) fn needed(self, tag: &'static str, owner: &str) -> Result<Element<'a>, RobotError> {
        self.first(tag).ok_or_else(|| RobotError::MissingElement {
            at: self.at(),
            owner: owner.to_owned(),
            element: tag,
        })
    }

    pub(crate) fn optional_text(&self, attribute: &'static str) -> Option<&'a str> {
        self.text_and_place(attribute).map(|(text, _)| text)
    }

    /// Returns the text of an attribute, and its byte range in the document.
    pub(crate) fn text_and_place(&self, attribute: &'static str) -> Option<(&'a str, Range<usize>)> {
        request(&self.asked.attributes, self.node.range().start, attribute);
        let found = self.node.attributes().find(|found| self.attribute_name(*found) == attribute)?;
        self.asked.read.borrow_mut().insert(found.range().start);
        Some((found.value(), found.range_value()))
    }

    pub(crate) fn text(&self, attribute: &'static str) -> Result<&'a str, RobotError> {
        self.optional_text(attribute).ok_or_else(|| RobotError::MissingAttribute {
            at: self.at(),
            element: self.tag().into_owned(),
            attribute,
        })
    }

    pub(crate) fn number(&self, attribute: &'static str) -> Result<f64, RobotError> {
        self.text(attribute)?;
        self.number_or(attribute, f64::NAN)
    }

    pub(crate) fn number_or(&self, attribute: &'static str, default: f64) -> Result<f64, RobotError> {
        Ok(self.numbers(attribute)?.map_or(default, |[number]| number))
    }

    pub(crate) fn positive(&self, attribute: &'static str) -> Result<f64, RobotError> {
        let value = self.number(attribute)?;
        self.check_positive(attribute, value)?;
        Ok(value)
    }

    pub(crate) fn check_positive(&self, attribute: &'static str, value: f64) -> Result<(), RobotError> {
        if value > 0.0 {
            return Ok(());
        }
        Err(RobotError::NotPositive { at: self.at(), element: format!("<{}>", self.tag()), attribute, value })
    }

    pub(crate) fn vector(&self, attribute: &'static str) -> Result<Option<Vector>, RobotError> {
        Ok(self.numbers(attribute)?.map(|[x, y, z]| Vector::new(x, y, z)))
    }

    /// Returns the pose of the `<origin>` child, or the identity if there is none.
    pub(crate) fn origin(self) -> Result<Pose, RobotError> {
        let Some(origin) = self.first("origin") else { return Ok(Pose::identity()) };
        let translation = origin.vector("xyz")?.unwrap_or_default();
        let angles = origin.numbers("rpy")?;
        let rotation = match origin.numbers("quat_xyzw")? {
            None => rotation_of(angles.unwrap_or_default()),
            Some(_) if angles.is_some() => {
                let (what, owner) = ("`quat_xyzw` beside `rpy`".to_owned(), origin.title());
                return Err(RobotError::NotUnderstood { at: origin.at(), what, owner, known: Vec::new() });
            }
            Some([x, y, z, w]) => {
                let given = Quaternion::new(w, x, y, z);
                // A larger deviation is not a rounding error.
                if (given.norm() - 1.0).abs() > LONGEST_ROUNDING {
                    let (at, element) = (origin.at(), "<origin>".to_owned());
                    return Err(RobotError::NoRotation { at, element, norm: given.norm() });
                }
                Rotation::new_normalize(given)
            }
        };
        Ok(Pose::from_parts(Point::from(translation).into(), rotation))
    }

    pub(crate) fn numbers<const N: usize>(
        &self,
        attribute: &'static str,
    ) -> Result<Option<[f64; N]>, RobotError> {
        let Some(numbers) = self.list(attribute, N)? else { return Ok(None) };
        let numbers = numbers.try_into().map_err(|_| self.not_numbers(attribute, N))?;
        Ok(Some(numbers))
    }

    /// Returns the finite numbers of an attribute, as many as it has, at most `most`.
    pub(crate) fn list(&self, attribute: &'static str, most: usize) -> Result<Option<Vec<f64>>, RobotError> {
        let Some(text) = self.optional_text(attribute) else { return Ok(None) };
        let mut numbers = Vec::new();
        for word in text.split_whitespace() {
            let number = word.parse().ok().filter(|number: &f64| number.is_finite());
            numbers.push(number.ok_or_else(|| self.not_numbers(attribute, most))?);
            if numbers.len() > most {
                return Err(self.not_numbers(attribute, most));
            }
        }
        Ok(Some(numbers))
    }

    pub(crate) fn not_numbers(&self, attribute: &'static str, expected: usize) -> RobotError {
        let (at, element) = (self.at(), self.tag().into_owned());
        let text = cranny_file::excerpt(self.optional_text(attribute).unwrap_or_default());
        RobotError::NotNumbers { at, element, attribute, expected, text }
    }
}

/// Maximum deviation of the norm of a quaternion in a file from 1, for at least two decimals.
const LONGEST_ROUNDING: f64 = 0.02;

/// Returns the rotation by roll about x, then pitch about y, then yaw about z, all of the parent (URDF specification).
pub(crate) fn rotation_of([roll, pitch, yaw]: [f64; 3]) -> Rotation {
    let turn = |axis, angle: f64| {
        let (sine, cosine) = sin_cos(0.5 * angle);
        Rotation::new_unchecked(Quaternion::from_parts(cosine, axis * sine))
    };
    turn(Vector::z(), yaw) * turn(Vector::y(), pitch) * turn(Vector::x(), roll)
}

/// Restores the colon of a prefix that [`known_prefixes`] joined to the name.
fn with_colon(name: &str) -> Cow<'_, str> {
    if name.contains('.') { Cow::Owned(name.replacen('.', ":", 1)) } else { Cow::Borrowed(name) }
}

fn request(asked: &RefCell<HashMap<usize, Vec<&'static str>>>, element: usize, name: &'static str) {
    let mut asked = asked.borrow_mut();
    let names = asked.entry(element).or_default();
    if !names.contains(&name) {
        names.push(name);
    }
}

fn names_of(asked: &RefCell<HashMap<usize, Vec<&'static str>>>, element: usize) -> Vec<&'static str> {
    let mut names = asked.borrow().get(&element).cloned().unwrap_or_default();
    names.sort_unstable();
    names
}

/// Returns the line number of an offset in the text, from 1.
fn line_of(line_starts: &[usize], offset: usize) -> u32 {
    u32::try_from(line_starts.partition_point(|start| *start <= offset)).unwrap_or(u32::MAX)
}
