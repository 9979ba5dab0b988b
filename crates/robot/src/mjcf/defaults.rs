use std::collections::HashMap;

use cranny_file::nearest_names;
use cranny_spatial::Vector;

use crate::RobotError;
use crate::description::xml::Element;
use crate::mjcf::documents::Documents;
use crate::model_file::unread_list::{UnreadList, not_supported};

/// Name of the outermost class.
const MAIN: &str = "main";

/// Maximum number of classes inside each other; each is read by a call of its own.
const MOST_DEPTH: usize = 100;

/// Sections of a class that are read.
const READ: [&str; 5] = ["default", "joint", "geom", "mesh", "material"];

/// Classes of defaults (XML reference, Default settings).
pub(crate) struct Classes<'d> {
    classes: HashMap<String, Class<'d>>,
}

struct Class<'d> {
    /// Class around it, with the number of its settings at that time: later ones, of another section, do not apply.
    parent: Option<(String, usize)>,
    /// Settings in the order of the files; later ones override earlier ones.
    settings: Vec<Element<'d>>,
}

impl<'d> Classes<'d> {
    pub(crate) fn read(documents: &'d Documents<'_>, unread: &mut UnreadList) -> Result<Self, RobotError> {
        let mut classes = Self { classes: HashMap::new() };
        let outermost = Class { parent: None, settings: Vec::new() };
        classes.classes.insert(MAIN.to_owned(), outermost);
        for section in documents.sections("default") {
            classes.add(documents, section, (None, 0), unread)?;
        }
        Ok(classes)
    }

    fn add(
        &mut self,
        documents: &'d Documents<'_>,
        class: Element<'d>,
        (parent, depth): (Option<&str>, usize),
        unread: &mut UnreadList,
    ) -> Result<(), RobotError> {
        if depth > MOST_DEPTH {
            let (at, what) = (class.at(), "classes inside each other");
            return Err(RobotError::TooMany { at, what, most: MOST_DEPTH, actual: depth });
        }
        // The outermost class may have any name.
        let name = match parent {
            None => MAIN,
            Some(_) => class.text("class")?,
        };
        if let Some(own_name) = class.optional_text("class").filter(|_| parent.is_none()) {
            let alias = Class { parent: Some((MAIN.to_owned(), usize::MAX)), settings: Vec::new() };
            if own_name != MAIN {
                self.classes.entry(own_name.to_owned()).or_insert(alias);
            }
        }
        let settings_of = |parent: &str| self.classes.get(parent).map_or(0, |parent| parent.settings.len());
        let parent = parent.map(|parent| (parent.to_owned(), settings_of(parent)));
        self.classes.entry(name.to_owned()).or_insert(Class { parent, settings: Vec::new() });
        // The settings of a section apply to the classes inside it, wherever they stand.
        let (inner, settings): (Vec<_>, Vec<_>) =
            documents.children(class).into_iter().partition(|child| child.tag() == "default");
        for child in settings {
            match &*child.tag() {
                tag if READ.contains(&tag) => {
                    if let Some(class) = self.classes.get_mut(name) {
                        class.settings.push(child);
                    }
                }
                _ => unread.add(class, child),
            }
        }
        inner.into_iter().try_for_each(|child| self.add(documents, child, (Some(name), depth + 1), unread))
    }

    /// Returns the attributes of an element with the defaults of its own class, or else of the nearest `childclass` around it.
    pub(crate) fn of(
        &self,
        element: Element<'d>,
        childclass: Option<&str>,
    ) -> Result<Attributes<'d>, RobotError> {
        let mut levels = vec![element];
        let own = element.optional_text("class");
        let mut inherited = Some((own.or(childclass).unwrap_or(MAIN), usize::MAX));
        // A class is defined once, so the chain of its parents ends.
        for _ in 0..=self.classes.len() {
            let Some((class_name, count)) = inherited else { break };
            let class = self.classes.get(class_name).ok_or_else(|| RobotError::UnknownName {
                place: element.at().to_string(),
                kind: "default class",
                name: class_name.to_owned(),
                nearest: nearest_names(class_name, self.classes.keys().map(String::as_str)),
            })?;
            let settings = &class.settings[..count.min(class.settings.len())];
            levels.extend(settings.iter().rev().filter(|setting| setting.tag() == element.tag()));
            inherited = class.parent.as_ref().map(|(parent, count)| (parent.as_str(), *count));
        }
        Ok(Attributes { levels })
    }
}

/// Attributes of an element, and of the defaults that apply to it.
pub(crate) struct Attributes<'d> {
    /// The element, then its defaults, the nearest first.
    levels: Vec<Element<'d>>,
}

impl<'d> Attributes<'d> {
    pub(crate) fn element(&self) -> Element<'d> {
        self.levels[0]
    }

    /// Returns the first element with the attribute.
    fn holder(&self, attribute: &'static str) -> Option<Element<'d>> {
        self.levels.iter().copied().find(|level| level.optional_text(attribute).is_some())
    }

    pub(crate) fn text(&self, attribute: &'static str) -> Option<&'d str> {
        self.holder(attribute)?.optional_text(attribute)
    }

    pub(crate) fn numbers<const N: usize>(
        &self,
        attribute: &'static str,
    ) -> Result<Option<[f64; N]>, RobotError> {
        self.holder(attribute).map_or(Ok(None), |holder| holder.numbers(attribute))
    }

    pub(crate) fn vector(&self, attribute: &'static str) -> Result<Option<Vector>, RobotError> {
        Ok(self.numbers(attribute)?.map(Vector::from))
    }

    /// Returns up to three numbers; those that the element does not give are the defaults', else 0.
    pub(crate) fn overlaid(&self, attribute: &'static str) -> Result<[f64; 3], RobotError> {
        let mut whole = [0.0; 3];
        for level in self.levels.iter().rev() {
            let given = level.list(attribute, 3)?.unwrap_or_default();
            whole[..given.len()].copy_from_slice(&given);
        }
        Ok(whole)
    }

    /// Returns the bits of a contact mask.
    pub(crate) fn bits(&self, attribute: &'static str) -> Result<u32, RobotError> {
        let Some(text) = self.text(attribute) else { return Ok(1) };
        // Masks are integers of 32 bits; a negative one has the highest bit.
        let number = text.trim().parse::<u32>().or_else(|_| text.trim().parse().map(i32::cast_unsigned));
        number.map_err(|_| {
            let holder = self.holder(attribute).unwrap_or_else(|| self.element());
            not_supported(holder, format!("{attribute}=\"{text}\""), "give a whole number of 32 bits")
        })
    }

    /// Returns the nearest of several attributes that exclude each other, with the element that has it.
    pub(crate) fn nearest_of(&self, attributes: &[&'static str]) -> Option<(Element<'d>, &'static str)> {
        self.levels.iter().find_map(|level| {
            let given = attributes.iter().find(|attribute| level.optional_text(attribute).is_some())?;
            Some((*level, *given))
        })
    }
}
