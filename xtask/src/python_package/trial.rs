//! Trial of a wheel: installed into a bare virtual environment, in which neither Rust nor Node is found, and used there.

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::step::{self, Surroundings};

use super::python_tools;

/// Folder of the environment and of all that is written, relative to the root.
const FOLDER: &str = "target/wheel-trial";

/// First lines of Python of a new user.
const PYTHON: &str = "import cranny
scenario = cranny.Scenario('021')
assert cranny.plan(scenario, seed=0).clearance_m > 0";

/// Time in which all steps after the download should end on an idle machine, in seconds.
const TARGET_S: f64 = 15.0;

/// Maximum time that the viewer takes to answer a request.
const PATIENCE: Duration = Duration::from_secs(30);

/// Creates the environment and downloads what the wheel depends on (1). Then installs the wheel (2), and plans, draws, views
/// and runs Python there (3), printing the seconds of each.
///
/// # Errors
/// If any of these fails.
pub fn run(here: &Surroundings, python: &Path, wheel: &Path) -> Result<(), String> {
    let folder = here.root.join(FOLDER);
    let trial = Trial { here, folder: &folder };
    let fault = |fault: std::io::Error| format!("{}: {fault}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(fault)?;
    }
    fs::create_dir_all(&folder).map_err(fault)?;
    // 1.
    let environment = trial.environment().display().to_string();
    timed("environment", || step::succeed(here.command(python, &["-m", "venv", &environment])))?;
    let wheel = wheel.display().to_string();
    let pip = ["-m", "pip", "--quiet", "--disable-pip-version-check"];
    let download = [&pip[..], &["download", "--only-binary", ":all:", "--dest", "packages", &wheel]].concat();
    timed("download", || step::succeed(trial.command("python", &download)))?;
    // 2.
    let install = [&pip[..], &["install", "--no-index", "--find-links", "packages", &wheel]].concat();
    let mut total_s = timed("pip install", || step::succeed(trial.command("python", &install)))?;
    // 3.
    for (program, line) in [
        ("cranny", "--version"),
        ("cranny", "plan 021 --quiet"),
        ("cranny", "render 021 021.plan.json --quiet -o 021.html"),
        ("python", "-m cranny --version"),
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        total_s += timed(&format!("{program} {line}"), || step::succeed(trial.command(program, &words)))?;
    }
    total_s += timed("cranny view 021", || trial.view())?;
    total_s += timed("three lines of Python", || step::succeed(trial.command("python", &["-c", PYTHON])))?;
    println!("{total_s:8.2} s  in total after the download (target: {TARGET_S} s)");
    Ok(())
}

struct Trial<'a> {
    here: &'a Surroundings,
    folder: &'a Path,
}

impl Trial<'_> {
    fn environment(&self) -> PathBuf {
        self.folder.join("environment")
    }

    /// Returns a program of the environment, the only folder in which it finds programs.
    fn command(&self, program: &str, words: &[&str]) -> Command {
        let programs = python_tools::programs_of(&self.environment());
        let mut command = self.here.command(programs.join(program), words);
        command.current_dir(self.folder).env("PATH", programs);
        for name in ["PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV"] {
            command.env_remove(name);
        }
        command
    }

    /// Starts the viewer, requests its page, and ends it.
    fn view(&self) -> Result<(), String> {
        let mut command = self.command("cranny", &["view", "021", "021.plan.json", "--no-open"]);
        let mut server = command
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|fault| format!("`cranny view` does not start: {fault}"))?;
        let mut line = String::new();
        let output = server.stdout.take().map(|output| BufReader::new(output).read_line(&mut line));
        let page = match output {
            Some(Ok(_)) => page_at(&line),
            _ => Err("`cranny view` prints no address".to_owned()),
        };
        // It runs until it is ended, and may have ended by itself.
        let _ = server.kill();
        let _ = server.wait();
        page
    }
}

/// Requests the page whose address a line begins with.
fn page_at(line: &str) -> Result<(), String> {
    let address = line.split_whitespace().next().unwrap_or_default();
    let fault = |fault: &dyn std::fmt::Display| format!("`cranny view` at '{address}': {fault}");
    let (host, path) = address
        .strip_prefix("http://")
        .and_then(|rest| rest.split_once('/'))
        .ok_or_else(|| fault(&"no address"))?;
    let exchange = || {
        let mut stream = TcpStream::connect(host)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        write!(stream, "GET /{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n")?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer)?;
        Ok(answer)
    };
    let answer = exchange().map_err(|error: std::io::Error| fault(&error))?;
    let answer = String::from_utf8_lossy(&answer);
    if answer.starts_with("HTTP/1.1 200") && answer.contains("<html") {
        return Ok(());
    }
    Err(fault(&answer.lines().next().unwrap_or("no answer")))
}

/// Runs a step, prints its time, and returns it in seconds.
fn timed(name: &str, step: impl FnOnce() -> Result<(), String>) -> Result<f64, String> {
    let begin = Instant::now();
    step()?;
    let seconds = begin.elapsed().as_secs_f64();
    println!("{seconds:8.2} s  {name}");
    Ok(seconds)
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    #[test]
    fn a_page_is_what_answers_with_html() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("its address");
        let line = format!("http://{address}/secret/  (Ctrl-C ends)\n");
        let server = std::thread::spawn(move || {
            for answer in
                ["HTTP/1.1 200 OK\r\n\r\n<!doctype html><html>", "HTTP/1.1 404 Not Found\r\n\r\n<html>"]
            {
                let (mut stream, _) = listener.accept().expect("a request");
                let mut first = String::new();
                let mut lines = BufReader::new(stream.try_clone().expect("a stream"));
                lines.read_line(&mut first).expect("a line");
                assert_eq!(first, "GET /secret/ HTTP/1.1\r\n");
                while first != "\r\n" {
                    first.clear();
                    lines.read_line(&mut first).expect("a line");
                }
                stream.write_all(answer.as_bytes()).expect("sent");
            }
        });
        assert_eq!(page_at(&line), Ok(()));
        assert!(page_at(&line).is_err_and(|message| message.ends_with("HTTP/1.1 404 Not Found")));
        server.join().expect("both requests");
        assert!(page_at("").is_err_and(|message| message.ends_with("no address")));
    }
}
