/// Content of an XML text that exceeds a limit of [`xml_excess`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct XmlExcess {
    /// Line, counted from 1.
    pub line: usize,
    /// Kind of content, in the plural.
    pub what: &'static str,
    /// Maximum number.
    pub most: usize,
    /// Actual number; where the text goes on, the number up to the position.
    pub actual: usize,
}

/// Maximum number of `<` and of `=`: the parser keeps about 200 bytes for each. All pairs of 1000 links, disabled one by one,
/// have half a million of the first.
const MOST_MARKS: usize = 2_000_000;

/// Maximum number of attributes of an element: the parser compares each with each.
const MOST_ATTRIBUTES: usize = 64;

/// Maximum number of elements inside each other: reading of some values walks up to the outermost one.
const MOST_DEPTH: usize = 256;

/// Maximum number of namespaces that are declared for an element: the parser copies the list for each element that adds one,
/// and searches it for each prefix.
const MOST_NAMESPACES: usize = 64;

/// Maximum length of the declaration of a namespace, in bytes: prefix and name are compared for each element.
const MOST_NAMESPACE_BYTES: usize = 1000;

/// Returns the first content of an XML text that `roxmltree` would need more than linear time or very much memory for:
/// numerous attributes of one element, namespaces, deep nesting, millions of elements. Files of robots and meshes are far below
/// these limits.
///
/// One pass over the text, which need not be valid: every tag in front of the parser's first error is counted as the parser
/// would.
pub fn xml_excess(text: &str) -> Option<XmlExcess> {
    let bytes = text.as_bytes();
    let excess = |at: usize, what: &'static str, most: usize, actual: usize| {
        let line = 1 + text[..at].matches('\n').count();
        Some(XmlExcess { line, what, most, actual })
    };
    for (mark, what) in [(b'<', "`<` in one XML text"), (b'=', "`=` in one XML text")] {
        let mut marks = (0..bytes.len()).filter(|&at| bytes[at] == mark);
        if let Some(at) = marks.nth(MOST_MARKS) {
            return excess(at, what, MOST_MARKS, MOST_MARKS + 1 + marks.count());
        }
    }
    // Number of namespaces declared for each open element and those around it.
    let mut namespaces = vec![0];
    for tag in tags(text) {
        if tag.attributes > MOST_ATTRIBUTES {
            return excess(tag.begin, "attributes in one element", MOST_ATTRIBUTES, tag.attributes);
        }
        if tag.longest_namespace > MOST_NAMESPACE_BYTES {
            let what = "bytes in the declaration of one namespace";
            return excess(tag.begin, what, MOST_NAMESPACE_BYTES, tag.longest_namespace);
        }
        let around = namespaces.last().copied().unwrap_or(0);
        let declared = around + tag.namespaces;
        match tag.kind {
            TagKind::End => drop(namespaces.pop()),
            TagKind::Start | TagKind::Whole if declared > MOST_NAMESPACES => {
                return excess(tag.begin, "namespaces declared for one element", MOST_NAMESPACES, declared);
            }
            TagKind::Start if namespaces.len() > MOST_DEPTH => {
                return excess(tag.begin, "elements inside each other", MOST_DEPTH, namespaces.len());
            }
            TagKind::Start => namespaces.push(declared),
            TagKind::Whole => {}
        }
    }
    None
}

/// Tags outside of comments, character data and processing instructions, up to the first declaration (`<!DOCTYPE`), at which
/// the parser stops. The end of each is searched behind its whole start mark, as the parser does: `<!-->` only begins a comment.
fn tags(text: &str) -> impl Iterator<Item = Tag> {
    let mut at = 0;
    std::iter::from_fn(move || {
        loop {
            let begin = at + text[at..].find('<')?;
            let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
            if let Some((start, end)) = skipped.iter().find(|(start, _)| text[begin..].starts_with(start)) {
                let inside = begin + start.len();
                at = inside + text[inside..].find(end)? + end.len();
            } else if text[begin..].starts_with("<!") {
                return None;
            } else {
                let tag = Tag::read(text.as_bytes(), begin);
                at = tag.end;
                return Some(tag);
            }
        }
    })
}

enum TagKind {
    /// `<a>`
    Start,
    /// `</a>`
    End,
    /// `<a/>`
    Whole,
}

struct Tag {
    kind: TagKind,
    begin: usize,
    /// Offset behind the tag.
    end: usize,
    /// Number of attributes, those that declare a namespace included.
    attributes: usize,
    namespaces: usize,
    /// Length of the longest declaration of a namespace, in bytes.
    longest_namespace: usize,
}

impl Tag {
    fn read(bytes: &[u8], begin: usize) -> Self {
        let (kind, end) = (TagKind::Start, begin + 1);
        let mut tag = Self { kind, begin, end, attributes: 0, namespaces: 0, longest_namespace: 0 };
        let mut quote = None;
        // Start of the declaration of a namespace that has not ended.
        let mut declaration = None;
        while let Some(&byte) = bytes.get(tag.end) {
            match quote {
                None if byte == b'>' => break,
                None if byte == b'"' || byte == b'\'' => {
                    quote = Some(byte);
                    tag.attributes += 1;
                }
                None if bytes[tag.end..].starts_with(b"xmlns") => {
                    declaration = declaration.or(Some(tag.end));
                }
                Some(open) if open == byte => {
                    quote = None;
                    if let Some(start) = declaration.take() {
                        tag.namespaces += 1;
                        tag.longest_namespace = tag.longest_namespace.max(tag.end - start);
                    }
                }
                _ => {}
            }
            tag.end += 1;
        }
        if bytes.get(begin + 1) == Some(&b'/') {
            tag.kind = TagKind::End;
        } else if bytes[..tag.end].ends_with(b"/") {
            tag.kind = TagKind::Whole;
        }
        tag.end = bytes.len().min(tag.end + 1);
        tag
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn excess_of(text: &str) -> Option<(usize, &'static str, usize)> {
        xml_excess(text).map(|excess| (excess.line, excess.what, excess.actual))
    }

    fn attributes(count: usize, prefix: &str) -> String {
        (0..count).map(|index| format!(" {prefix}{index}=\"<>\"")).collect::<Vec<_>>().concat()
    }

    #[test]
    fn each_limit_is_named_with_its_line() {
        let nested = |count: usize, tag: &str| format!("<{tag}>").repeat(count);
        let xmlns = (0..80).map(|index| format!("<a xmlns:n{index}='u'>\n")).collect::<Vec<_>>().concat();
        for (text, line, what, actual) in [
            (format!("<a>\n<b{}/></a>", attributes(70, "b")), 2, "attributes in one element", 70),
            (format!("\n\n{}", nested(300, "a")), 3, "elements inside each other", 257),
            (xmlns, 65, "namespaces declared for one element", 65),
            (
                format!("<a xmlns:{}='u'/>", "n".repeat(2000)),
                1,
                "bytes in the declaration of one namespace",
                2009,
            ),
            (
                format!("<a\nxmlns='{}'/>", "u".repeat(2000)),
                1,
                "bytes in the declaration of one namespace",
                2007,
            ),
            (format!("<a>{}", nested(3_000_000, "!")), 1, "`<` in one XML text", 3_000_001),
            (format!("<a>\n{}", "=".repeat(2_500_000)), 2, "`=` in one XML text", 2_500_000),
        ] {
            assert_eq!(excess_of(&text), Some((line, what, actual)), "{}", crate::excerpt(&text));
        }
    }

    #[test]
    fn content_below_the_limits_is_none() {
        let many = "<c xmlns='a' xmlns:b='c'/><d xmlns='a'></d>".repeat(1000);
        let most = attributes(MOST_ATTRIBUTES, "a");
        for text in [
            String::new(),
            "<".to_owned(),
            "<a b='".to_owned(),
            "<!-- <a b='> -->".repeat(1000),
            format!("<![CDATA[ {} ]]>", "<a>".repeat(1000)),
            format!("<a>{many}</a>"),
            format!("<a{most}>{}{}</a>", "<a>".repeat(200), "</a>".repeat(200)),
        ] {
            assert_eq!(excess_of(&text), None, "{}", crate::excerpt(&text));
        }
    }

    /// A comment that begins with `<!-->` once ended there for the scanner alone, which then took the quotes of all later tags
    /// for their opposites.
    #[test]
    fn content_that_looks_like_an_end_hides_no_attributes() {
        let many = (0..70).map(|index| format!(" a{index}=\">\"")).collect::<Vec<_>>().concat();
        for before in ["<!--><b c=\"-->", "<!---><b c=\"-->", "<![CDATA[]><b c=\"]]>", "<?x ><b c=\"?>"] {
            let text = format!("<a>{before}<b{many}/></a>");
            assert!(roxmltree::Document::parse(&text).is_ok(), "{before}");
            assert_eq!(excess_of(&text), Some((1, "attributes in one element", 70)), "{before}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// In every text that the parser accepts, each element has one tag here, with as many attributes.
        #[test]
        fn the_parser_finds_no_element_or_attribute_that_is_not_counted(
            pieces in prop::collection::vec(prop::sample::select(&PIECES), 0..9),
        ) {
            let text = format!("<a>{}</a>", pieces.concat());
            if let Ok(document) = roxmltree::Document::parse(&text) {
                let elements = document.descendants().filter(roxmltree::Node::is_element);
                let parsed: Vec<_> = elements.map(|e| (e.range().start, e.attributes().len())).collect();
                let begins = tags(&text).filter(|tag| !matches!(tag.kind, TagKind::End));
                let counted: Vec<_> = begins.map(|tag| (tag.begin, tag.attributes - tag.namespaces)).collect();
                prop_assert_eq!(parsed, counted, "{}", text);
            }
        }
    }

    const PIECES: [&str; 27] = [
        "<a>",
        "</a>",
        "<a/>",
        "<a b='\"'>",
        "<a b=\">'\" c='/'/>",
        "<a xmlns:b='c' d='e'/>",
        "<a",
        "/>",
        ">",
        " b='",
        "'",
        "\"",
        "/",
        "<!--",
        "<!-->",
        "<!--->",
        "-->",
        "->",
        "<![CDATA[",
        "]]>",
        "]>",
        "<?b ",
        "<?b?>",
        "?>",
        "<!b>",
        "é",
        " ",
    ];
}
