use std::time::Instant;

/// The one place of this room that looks at the time.
#[expect(clippy::disallowed_methods, reason = "the clock of the searches")]
pub(crate) fn now() -> Instant {
    Instant::now()
}
