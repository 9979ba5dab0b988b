//! Lines that a certificate has more than once, written once.

use std::collections::HashMap;

/// Number of places of an equal line at which a repetition is tried, the latest first.
const MOST_PLACES: usize = 16;

/// Returns the text with lines `= FROM COUNT` in place of lines that repeat earlier ones, where that is shorter: COUNT lines from
/// the line FROM of the result, none of which is itself such a line.
pub(crate) fn folded(text: &str) -> String {
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    // Number of each line in the result, 0 for one that is left out.
    let mut numbers = vec![0; lines.len()];
    let mut places: HashMap<&str, Vec<usize>> = HashMap::new();
    let (mut result, mut number, mut at) = (String::with_capacity(text.len()), 0, 0);
    while at < lines.len() {
        number += 1;
        let run = |from: usize| {
            let is_repeated = |by: &usize| {
                from + by < at
                    && numbers[from + by] == numbers[from] + by
                    && lines[from + by] == lines[at + by]
            };
            (0..lines.len() - at).take_while(is_repeated).count()
        };
        let known = places.get(lines[at]).map_or(&[][..], Vec::as_slice);
        let longest = known.iter().rev().take(MOST_PLACES).map(|from| (run(*from), numbers[*from])).max();
        let repeat = longest.map(|(count, from)| (count, format!("= {from} {count}\n")));
        match repeat {
            Some((count, line)) if lines[at..at + count].concat().len() > line.len() => {
                result.push_str(&line);
                at += count;
            }
            _ => {
                result.push_str(lines[at]);
                numbers[at] = number;
                places.entry(lines[at]).or_default().push(at);
                at += 1;
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Puts the repeated lines in their place.
    fn unfolded(text: &str) -> String {
        let lines: Vec<&str> = text.split_inclusive('\n').collect();
        let line_of = |line: &&str| match line.strip_prefix("= ") {
            None => (*line).to_owned(),
            Some(words) => {
                let numbers: Vec<usize> =
                    words.split_whitespace().map(|word| word.parse().unwrap()).collect();
                lines[numbers[0] - 1..numbers[0] - 1 + numbers[1]].concat()
            }
        };
        lines.iter().map(line_of).collect()
    }

    #[test]
    fn a_solid_is_written_once() {
        let solid = "v 0 0 0.123456\nv 0 1 0\nv 1 0 0\n";
        let text = format!("mesh a\n{solid}mesh b\n{solid}end\n");
        assert_eq!(folded(&text), format!("mesh a\n{solid}mesh b\n= 2 3\nend\n"));
    }

    proptest! {
        /// unfolded(folded(text)) = text, and folded(text) is no longer.
        #[test]
        fn folding_loses_nothing(lines in proptest::collection::vec(0..6_usize, 0..80)) {
            let words = ["a\n", "bbbbbbbbbb\n", "cccccccccccccc\n", "dddddd\n", "e e e e e\n", "ffffffffffffffffffffff\n"];
            let text: String = lines.iter().map(|index| words[*index]).collect();
            let short = folded(&text);
            prop_assert_eq!(unfolded(&short), text.clone());
            prop_assert!(short.len() <= text.len());
        }
    }
}
