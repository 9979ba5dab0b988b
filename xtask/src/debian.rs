//! Packages of Debian, for machines that only run tests.

use crate::step::{self, Surroundings};

/// Installs packages as root; others are asked to do it themselves.
///
/// # Errors
/// If the user is not root, or apt-get fails.
pub fn install(here: &Surroundings, packages: &[&str]) -> Result<(), String> {
    let user = here.command("id", &["-u"]).output();
    if !user.is_ok_and(|user| user.stdout.trim_ascii() == b"0") {
        return Err("only root can install it here".to_owned());
    }
    println!("==> {} by apt-get", packages.join(", "));
    step::succeed(here.command("apt-get", &["-qq", "update"]))?;
    let words = [&["-qq", "install", "--yes", "--no-install-recommends"], packages].concat();
    let mut command = here.command("apt-get", &words);
    command.env("DEBIAN_FRONTEND", "noninteractive");
    step::succeed(command)
}
