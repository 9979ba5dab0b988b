use std::io;
use std::path::Path;
use std::process::Stdio;

use crate::system::installed_command;

/// Programs that open a page in the user's browser, in order: on Windows the file manager, which needs no shell; on Linux the
/// desktop's (freedesktop.org, xdg-utils, whole) and that of Windows' subsystem for Linux.
const OPENERS: &[&str] = if cfg!(windows) {
    &["explorer"]
} else if cfg!(target_os = "macos") {
    &["open"]
} else {
    &["xdg-open", "wslview"]
};

/// Opens a page in the user's browser and waits for the opening program, which some systems end with the browser.
///
/// # Errors
/// [`io::ErrorKind::NotFound`] if no such program is installed, and those of starting it.
pub fn open_in_browser(page: &Path) -> io::Result<()> {
    let mut command =
        OPENERS.iter().find_map(|name| installed_command(name).ok()).ok_or(io::ErrorKind::NotFound)?;
    command.arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status()?;
    Ok(())
}
