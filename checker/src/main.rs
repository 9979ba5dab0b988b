//! Checks a certificate: prints `certified`, or the first line that fails.

use std::io::Read as _;
use std::process::ExitCode;

/// Greatest size of a certificate, in bytes.
const MOST_BYTES: u64 = 64 << 20;

const USAGE: &str = "usage: cranny-check FILE [HASH]   (HASH: that of the scene, if it is known)";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (file, hash) = match &words[..] {
        [file] => (file, None),
        [file, hash] => (file, Some(hash)),
        _ => return bad(USAGE),
    };
    let mut bytes = Vec::new();
    let read = std::fs::File::open(file).and_then(|open| open.take(MOST_BYTES + 1).read_to_end(&mut bytes));
    if let Err(reason) = read {
        return bad(&format!("{file}: {reason}"));
    }
    if bytes.len() as u64 > MOST_BYTES {
        return bad(&format!("{file}: more than {MOST_BYTES} bytes"));
    }
    let Ok(text) = std::str::from_utf8(&bytes) else { return bad(&format!("{file}: no text")) };
    match cranny_check::check(text) {
        Err(fault) if fault.is_malformed => bad(&format!("{file}:{}: {}", fault.line, fault.reason)),
        Err(fault) => no(&format!("{file}:{}: {}", fault.line, fault.reason)),
        Ok(found) if hash.is_some_and(|hash| found.scenes.iter().all(|scene| scene.hash != *hash)) => {
            no(&format!("{file}: no scene has this hash"))
        }
        Ok(found) => {
            println!("certified");
            for scene in found.scenes {
                println!("  scene       {} {}", scene.name, scene.hash);
                println!("  paths       {} of {} pieces", scene.paths, scene.pieces);
                println!("  pairs       {}, each at least {} m apart", scene.pairs, scene.margin_m);
                scene.exceptions.iter().for_each(|line| println!("  {line}"));
            }
            ExitCode::SUCCESS
        }
    }
}

fn no(reason: &str) -> ExitCode {
    println!("not certified: {reason}");
    ExitCode::from(1)
}

fn bad(reason: &str) -> ExitCode {
    eprintln!("{reason}");
    ExitCode::from(2)
}
