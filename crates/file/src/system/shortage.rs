use std::io::{self, ErrorKind};

/// Returns true for an error that may pass by itself: the machine, or this user, has no process, memory, descriptor or disk space
/// left, or an answer took too long.
pub fn is_shortage(reason: &io::Error) -> bool {
    #[cfg(unix)]
    if let Some(number) = reason.raw_os_error() {
        use rustix::io::Errno;
        if [Errno::MFILE, Errno::NFILE].iter().any(|errno| errno.raw_os_error() == number) {
            return true;
        }
    }
    matches!(
        reason.kind(),
        ErrorKind::WouldBlock
            | ErrorKind::OutOfMemory
            | ErrorKind::StorageFull
            | ErrorKind::QuotaExceeded
            | ErrorKind::TimedOut
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn shortages_are_distinguished_from_faults() {
        use rustix::io::Errno;
        for errno in [Errno::AGAIN, Errno::NOMEM, Errno::NOSPC, Errno::DQUOT, Errno::MFILE, Errno::NFILE] {
            assert!(is_shortage(&errno.into()), "{errno}");
        }
        for errno in [Errno::NOENT, Errno::ACCESS, Errno::NOEXEC, Errno::ROFS] {
            assert!(!is_shortage(&errno.into()), "{errno}");
        }
    }
}
