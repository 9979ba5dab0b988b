use std::collections::{BTreeMap, BTreeSet};

use crate::RobotError;
use crate::description::unread::Notes;
use crate::description::xml::Element;

/// Content of a model that its reader knows, but does not read, to be named in the notes of the robot.
#[derive(Default)]
pub(crate) struct UnreadList {
    attributes: BTreeMap<String, BTreeSet<String>>,
    elements: Notes,
    others: Vec<String>,
}

impl UnreadList {
    /// Adds the attributes of `element` in `ignored`; those in `read` are read.
    ///
    /// # Errors
    /// [`RobotError::NotUnderstood`] for an attribute in neither.
    pub(crate) fn check_attributes(
        &mut self,
        element: Element<'_>,
        read: &[&str],
        ignored: &[&str],
    ) -> Result<(), RobotError> {
        for name in element.attribute_names().filter(|name| !read.contains(name)) {
            if !ignored.contains(&name) {
                let known = read.iter().map(ToString::to_string).collect();
                let (what, owner) = (format!("attribute `{name}`"), element.title());
                return Err(RobotError::NotUnderstood { at: element.at(), what, owner, known });
            }
            self.attributes.entry(element.tag().into_owned()).or_default().insert(name.to_owned());
        }
        Ok(())
    }

    /// Adds an element.
    pub(crate) fn add(&mut self, owner: Element<'_>, element: Element<'_>) {
        self.elements.add(&format!("element <{}>", element.tag()), owner, element);
    }

    /// Adds a note.
    pub(crate) fn note(&mut self, line: String) {
        self.others.push(line);
    }

    /// Returns one line for each kind of content; `file` is the name of the model.
    pub(crate) fn lines(self, file: &str) -> Vec<String> {
        let attributes = self.attributes.into_iter().map(|(tag, names)| {
            let names: Vec<String> = names.into_iter().collect();
            format!("{file}: not read of <{tag}>: {}", names.join(", "))
        });
        self.others.into_iter().chain(self.elements.lines()).chain(attributes).collect()
    }
}

/// Maximum length of a name in bytes: a name is written for each pair of bodies.
const LONGEST_NAME: usize = 200;

/// Checks the length of a name.
///
/// # Errors
/// [`RobotError::NotSupported`].
pub(crate) fn check_name(element: Element<'_>, name: &str) -> Result<(), RobotError> {
    if name.len() <= LONGEST_NAME {
        return Ok(());
    }
    let what = format!("a name of {} bytes", name.len());
    Err(not_supported(element, what, "shorten the names"))
}

/// Returns the error for content that is known, but not supported.
pub(crate) fn not_supported(element: Element<'_>, what: impl Into<String>, hint: &'static str) -> RobotError {
    RobotError::NotSupported { at: element.at(), what: what.into(), hint }
}
