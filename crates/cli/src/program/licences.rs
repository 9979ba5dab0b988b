use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::text;

/// Entry of the list that `licences --json` prints; its keys are stable.
#[derive(Serialize)]
struct Licence<'a> {
    /// Packages under this text, each with the name of its licence.
    of: Vec<&'a str>,
    text: &'a str,
}

/// Line above and below the heading of each licence.
const RULE: &str = "\n================================================================================\n";

/// Prints the licences of the project, then those of its dependencies.
pub fn run(output: Output) -> Result<Answer, Failure> {
    if output.json {
        text::print_json(&licences(cranny_view::NOTICES))?;
    } else {
        text::print_as_it_is(cranny_view::NOTICES.as_bytes())?;
    }
    Ok(Answer::Done)
}

fn licences(notices: &str) -> Vec<Licence<'_>> {
    // The text before the first rule is an introduction.
    let pieces: Vec<&str> = notices.split(RULE).skip(1).collect();
    pieces
        .chunks_exact(2)
        .map(|pair| Licence { of: pair[0].trim().lines().collect(), text: pair[1].trim() })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_licence_says_of_what_it_is_and_has_a_text() {
        let all = licences(cranny_view::NOTICES);
        assert!(all.len() > 20 && all[0].of == ["Cranny (MIT)"], "{}", all.len());
        for Licence { of, text } in &all {
            assert!(!of.is_empty() && of.iter().all(|of| of.ends_with(')')) && !text.is_empty(), "{of:?}");
        }
        let kept: usize = all.iter().map(|licence| licence.text.len()).sum();
        assert!(kept * 100 > cranny_view::NOTICES.len() * 85, "{kept}");
    }
}
