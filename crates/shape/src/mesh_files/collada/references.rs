use roxmltree::Node;

use super::element::{HasTag, fault};

/// Elements by id, tag and enclosing geometry.
pub(super) struct References<'a>(Vec<Reference<'a>>);

struct Reference<'a> {
    id: &'a str,
    tag: &'a str,
    /// Position in the document of the nearest geometry around it.
    geometry: Option<u32>,
    node: Node<'a, 'a>,
}

impl<'a> References<'a> {
    pub(super) fn of(root: Node<'a, 'a>) -> Self {
        let reference = |node: Node<'a, 'a>| {
            let (id, tag) = (node.attribute("id")?, node.tag_name().name());
            Some(Reference { id, tag, geometry: geometry_around(node), node })
        };
        let mut all: Vec<_> = root.descendants().filter_map(reference).collect();
        // Equal ones stay in the order of the file.
        all.sort_by_key(|reference| (reference.id, reference.tag, reference.geometry));
        Self(all)
    }

    /// Element with one of some tags that another one refers to by `url` or `source`. Some exporters repeat an id in several
    /// geometries; the reference then means the element in the same geometry.
    pub(super) fn target(&self, from: Node<'a, 'a>, tags: &[&str]) -> Result<Node<'a, 'a>, String> {
        let name = from.attribute("url").or(from.attribute("source")).unwrap_or_default();
        let id = name.strip_prefix('#').unwrap_or(name);
        let mut found: Vec<&[Reference<'a>]> = tags.iter().map(|tag| self.all(id, tag)).collect();
        if let Some(geometry) = geometry_around(from)
            && found.iter().map(|alike| alike.len()).sum::<usize>() > 1
        {
            for alike in &mut found {
                *alike = range(alike, |other| other.geometry.cmp(&Some(geometry)));
            }
        }
        let wrong = |what: &str| {
            let (tag, name) = (from.tag_name().name(), cranny_file::excerpt(name));
            Err(fault(from, &format!("<{tag}> refers to '{name}', {what}")))
        };
        let mut found = found.into_iter().flatten().map(|reference| reference.node);
        match (found.next(), found.next()) {
            (Some(target), None) => Ok(target),
            (_, Some(second)) => wrong(&format!("but there are two of it ({})", fault(second, "the second"))),
            _ if range(&self.0, |other| other.id.cmp(id)).is_empty() => wrong("which is not there"),
            _ => wrong(&format!("which is no <{}>", tags.join("> or <"))),
        }
    }

    /// First element of a tag with an id, which may begin with `#`.
    pub(super) fn first(&self, name: &str, tag: &str) -> Option<Node<'a, 'a>> {
        self.all(name.strip_prefix('#').unwrap_or(name), tag).first().map(|reference| reference.node)
    }

    fn all(&self, id: &str, tag: &str) -> &[Reference<'a>] {
        range(&self.0, |other| (other.id, other.tag).cmp(&(id, tag)))
    }
}

/// Elements that compare equal, of a list in the order of `compared`.
fn range<T>(sorted: &[T], compared: impl Fn(&T) -> std::cmp::Ordering) -> &[T] {
    let begin = sorted.partition_point(|element| compared(element).is_lt());
    let behind = sorted[begin..].partition_point(|element| compared(element).is_eq());
    &sorted[begin..begin + behind]
}

fn geometry_around(node: Node) -> Option<u32> {
    node.ancestors().find(|around| around.has_tag_name_of("geometry")).map(|geometry| geometry.id().get())
}
