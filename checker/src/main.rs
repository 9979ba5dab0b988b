//! Checks a certificate: prints `certified`, or the first line that fails.

use std::io::{Read as _, Write as _};
use std::process::ExitCode;

/// Greatest size of a certificate, in bytes.
const MOST_BYTES: u64 = 64 << 20;

const USAGE: &str = "usage: cranny-check FILE [HASH…]   (HASH: that of a scene, if it is known)";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [file, hashes @ ..] = &words[..] else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    if file == "-h" || file == "--help" {
        let _ = writeln!(std::io::stdout(), "{USAGE}");
        return ExitCode::SUCCESS;
    }
    let mut text = String::new();
    let read = std::fs::File::open(file).and_then(|open| open.take(MOST_BYTES + 1).read_to_string(&mut text));
    if let Err(reason) = read {
        eprintln!("{file}: {reason}");
        return ExitCode::from(2);
    }
    let is_of =
        |line: &String, hash: &String| line.starts_with("scene ") && line.split(' ').nth(2) == Some(hash);
    let (code, answer) = match cranny_check::check(&text) {
        _ if text.len() as u64 > MOST_BYTES => (1, format!("not certified: {file}: more than 64 MiB")),
        Err((line, reason)) => (1, format!("not certified: {file}:{line}: {reason}")),
        Ok(found) if hashes.iter().all(|hash| found.iter().any(|line| is_of(line, hash))) => {
            (0, format!("certified\n  {}", found.join("\n  ")))
        }
        Ok(_) => (1, format!("not certified: {file}: no scene has this hash")),
    };
    let _ = writeln!(std::io::stdout(), "{answer}");
    ExitCode::from(code)
}
