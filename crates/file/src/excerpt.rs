/// Ranges of characters without width and of those that change the writing direction: Unicode's property
/// `Default_Ignorable_Code_Point`, and separators of annotations.
const UNSEEN: [(char, char); 17] = [
    ('\u{ad}', '\u{ad}'),
    ('\u{34f}', '\u{34f}'),
    ('\u{61c}', '\u{61c}'),
    ('\u{115f}', '\u{1160}'),
    ('\u{17b4}', '\u{17b5}'),
    ('\u{180b}', '\u{180f}'),
    ('\u{200b}', '\u{200f}'),
    ('\u{202a}', '\u{202e}'),
    ('\u{2060}', '\u{206f}'),
    ('\u{3164}', '\u{3164}'),
    ('\u{fe00}', '\u{fe0f}'),
    ('\u{feff}', '\u{feff}'),
    ('\u{ffa0}', '\u{ffa0}'),
    ('\u{fff0}', '\u{fffb}'),
    ('\u{1bca0}', '\u{1bca3}'),
    ('\u{1d173}', '\u{1d17a}'),
    ('\u{e0000}', '\u{e0fff}'),
];

/// Returns a text that is safe to print on a terminal: control characters, those that change the writing direction, and those
/// without width are escaped. A name from a file may contain any of them. Line ends stay.
pub fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        let is_unseen = UNSEEN.iter().any(|(first, last)| (*first..=*last).contains(&c));
        if is_unseen || (c.is_control() && c != '\n') {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// Returns a text as [`visible`] does, on one line: line ends are escaped too. Tables and lists need it for names.
pub fn visible_line(text: &str) -> String {
    visible(text).replace('\n', "\\n").replace('\u{2028}', "\\u{2028}").replace('\u{2029}', "\\u{2029}")
}

/// Returns the first characters of a text from a file, short enough for a message.
pub fn excerpt(text: &str) -> String {
    const MOST: usize = 60;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_terminal_obeys_is_left() {
        assert_eq!(visible("a\x1b[31mb\u{9b}c\r\u{202e}\ttd\n"), "a\\u{1b}[31mb\\u{9b}c\\r\\u{202e}\\ttd\n");
        assert_eq!(visible("Ärger — 50 µm"), "Ärger — 50 µm");
        assert_eq!(visible("reach\u{200b}\u{feff}"), "reach\\u{200b}\\u{feff}");
        assert_eq!(visible_line("a\nb\r\n\u{2028}\u{85}c"), "a\\nb\\r\\n\\u{2028}\\u{85}c");
    }

    #[test]
    fn an_excerpt_is_short_and_cut_between_letters() {
        assert_eq!(excerpt("0.5"), "0.5");
        assert_eq!(excerpt(&"ä".repeat(1000)), "ä".repeat(60) + "…");
    }
}
