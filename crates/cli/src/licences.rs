use crate::Answer;
use crate::failure::Failure;
use crate::text;

/// Prints the project's own licences, then those of others.
pub fn run() -> Result<Answer, Failure> {
    text::print_as_it_is(cranny_view::NOTICES.as_bytes())?;
    Ok(Answer::Done)
}
