/// Returns a text that is safe to print on a terminal: control characters, and those that change the writing direction, are
/// escaped. A name from a file may contain any of them. Line ends stay.
pub fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if turns || (c.is_control() && c != '\n') { shown.extend(c.escape_default()) } else { shown.push(c) }
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
        assert_eq!(visible_line("a\nb\r\n\u{2028}\u{85}c"), "a\\nb\\r\\n\\u{2028}\\u{85}c");
    }

    #[test]
    fn an_excerpt_is_short_and_cut_between_letters() {
        assert_eq!(excerpt("0.5"), "0.5");
        assert_eq!(excerpt(&"ä".repeat(1000)), "ä".repeat(60) + "…");
    }
}
