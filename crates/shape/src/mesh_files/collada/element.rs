use std::borrow::Cow;

use roxmltree::Node;

/// Comparison of tags without their namespace, which differs between versions.
pub(super) trait HasTag {
    fn has_tag_name_of(&self, tag: &str) -> bool;
}

impl HasTag for Node<'_, '_> {
    fn has_tag_name_of(&self, tag: &str) -> bool {
        self.is_element() && self.tag_name().name() == tag
    }
}

pub(super) fn children<'a>(node: Node<'a, 'a>, tag: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |child| child.has_tag_name_of(tag))
}

pub(super) fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name_of(tag))
}

/// Elements directly inside one.
pub(super) fn elements<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(Node::is_element)
}

/// Error message for an element at a position where it is not supported.
pub(super) fn unknown(node: Node) -> String {
    let parent = node.parent_element().map_or("the file", |parent| parent.tag_name().name());
    fault(node, &format!("<{}> in <{parent}> is not read", node.tag_name().name()))
}

/// Whole text of an element, which comments may interrupt.
///
/// # Errors
/// A message if there is an element inside.
pub(super) fn text<'a>(node: Node<'a, 'a>) -> Result<Cow<'a, str>, String> {
    let mut text = Cow::Borrowed("");
    for part in node.children() {
        if part.is_element() {
            return Err(unknown(part));
        }
        if part.is_text() {
            text += part.text().unwrap_or_default();
        }
    }
    Ok(text)
}

pub(super) fn numbers(node: Node) -> Result<Vec<f64>, String> {
    text(node)?.split_ascii_whitespace().map(|word| number(node, word)).collect()
}

pub(super) fn indices(node: Node) -> Result<Vec<usize>, String> {
    text(node)?.split_ascii_whitespace().map(|word| index(node, word)).collect()
}

pub(super) fn number(node: Node, word: &str) -> Result<f64, String> {
    word.parse().map_err(|_| fault(node, &format!("'{}' is no number", cranny_file::excerpt(word))))
}

pub(super) fn index(node: Node, word: &str) -> Result<usize, String> {
    word.parse().map_err(|_| fault(node, &format!("'{}' is no index", cranny_file::excerpt(word))))
}

pub(super) fn fault(node: Node, what: &str) -> String {
    format!("line {}: {what}", node.document().text_pos_at(node.range().start).row)
}
