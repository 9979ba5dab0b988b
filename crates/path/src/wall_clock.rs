use std::time::Instant;

/// Returns the current time; the only access of this crate to the clock.
#[expect(clippy::disallowed_methods, reason = "the clock of the searches")]
pub(crate) fn now() -> Instant {
    Instant::now()
}
