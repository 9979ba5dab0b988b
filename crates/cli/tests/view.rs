//! The viewer from the command line: a server that ends cleanly, and a page in one file.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

fn cranny(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cranny")).current_dir(folder).args(arguments).output().expect("it runs")
}

fn done(folder: &Path, arguments: &[&str]) -> Output {
    let output = cranny(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = cranny(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    for word in words {
        assert!(error.contains(word), "no '{word}' in: {error}");
    }
    assert_eq!(error.matches("error:").count(), 1, "{error}");
}

/// Returns true if this program includes the page; without it `view` asks to install Node, and the other tests are skipped.
fn has_page(folder: &Path) -> bool {
    let output = cranny(folder, &["view", "nothing", "--no-open"]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    let is_missing = error.contains("install Node");
    if is_missing {
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "{error}");
        eprintln!("SKIPPED: the viewer's page ({error})");
    }
    !is_missing
}

/// Running `cranny view` that has printed its address.
struct Viewer {
    child: Child,
    address: String,
    /// Prefix of every path.
    inside: String,
}

impl Viewer {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_cranny"))
            .current_dir(folder)
            .args(["view", "--no-open"])
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .expect("it runs");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut line).expect("a line");
        let address = line.split(' ').next().and_then(|url| url.strip_prefix("http://")).expect("an address");
        let (address, token) = address.trim_end_matches('/').split_once('/').expect("a token");
        let (address, inside) = (address.to_owned(), format!("/{token}"));
        assert!(address.starts_with("127.0.0.1:") && token.len() == 32, "{line}");
        Self { child, address, inside }
    }

    fn answer(&self, method: &str, path: &str, body: &str) -> Value {
        let mut stream = TcpStream::connect(&self.address).expect("it listens");
        let head = format!(
            "{method} {}{path} HTTP/1.1\r\nHost: {}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
            self.inside,
            self.address,
            body.len()
        );
        stream.write_all((head + body).as_bytes()).expect("it reads");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("it answers");
        let (_, body) = answer.split_once("\r\n\r\n").expect("a body");
        serde_json::from_str(body).expect("JSON")
    }

    /// Sends a signal and returns the exit code.
    #[cfg(unix)]
    fn ended_by(mut self, signal: &str) -> Option<i32> {
        let sent = Command::new("kill").args([signal, &self.child.id().to_string()]).status().expect("kill");
        assert!(sent.success());
        let begin = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                return status.code();
            }
            assert!(begin.elapsed() < Duration::from_secs(30), "it does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn several_plans_stand_side_by_side_and_verdicts_are_those_of_verify() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    if !has_page(folder) {
        return;
    }
    done(folder, &["plan", "021", "-o", "a.plan.json", "--quiet"]);
    done(folder, &["plan", "021", "-o", "b.plan.json", "--seed", "1", "--quiet"]);
    std::fs::write(folder.join("through.csv"), "0,0,-0.0178,-0.7601,0.0198,-2.3421,0.0298,1.5412,0.7534\n0,0.9,-0.0178,1.2,0.0198,-0.3,0.0298,1.5412,0.7534\n")
        .expect("written");
    let viewer = Viewer::start(folder, &["021", "a.plan.json", "b.plan.json", "through.csv"]);
    let page = viewer.answer("GET", "/page.json", "");
    let plans = page["plans"].as_array().expect("plans");
    let valid: Vec<bool> = plans.iter().map(|plan| plan["is_valid"] == true).collect();
    assert_eq!(valid, [true, true, false]);
    assert!(
        plans[0]["verdict"].as_str().is_some_and(|line| line.starts_with("valid")),
        "{}",
        plans[0]["verdict"]
    );
    assert_eq!(page["is_live"], true);

    // The end of the path through the table: a contact of `verify` is not free.
    let end = json!({"q": [0.0, 0.9, -0.0178, 1.2, 0.0198, -0.3, 0.0298, 1.5412, 0.7534]});
    let verdict = viewer.answer("POST", "/verdict", &end.to_string());
    assert_eq!(verdict["is_free"], false);
    let judged: Value =
        serde_json::from_slice(&cranny(folder, &["verify", "021", "through.csv", "--json"]).stdout)
            .expect("JSON");
    let named = |pair: &Value| (pair["first"].clone(), pair["second"].clone());
    let violations: Vec<_> = judged["violations"].as_array().expect("a list").iter().map(named).collect();
    for contact in verdict["contacts"].as_array().expect("a list") {
        assert!(violations.contains(&named(contact)), "{contact} is not in {violations:?}");
    }
    let start: Value = viewer.answer("POST", "/verdict", &json!({"q": page["robot"]["start"]}).to_string());
    assert_eq!((&start["is_free"], &start["contacts"]), (&true.into(), &json!([])));
}

#[cfg(unix)]
#[test]
fn ctrl_c_and_an_end_by_the_system_are_clean() {
    let folder = tempfile::tempdir().expect("a folder");
    if !has_page(folder.path()) {
        return;
    }
    for signal in ["-INT", "-TERM"] {
        let viewer = Viewer::start(folder.path(), &["021"]);
        assert_eq!(viewer.ended_by(signal), Some(0), "{signal}");
    }
}

#[test]
fn bad_input_is_refused_before_anything_is_served() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    if !has_page(folder) {
        return;
    }
    refused(folder, &["view", "021", "none.plan.json", "--no-open"], &["none.plan.json"]);
    refused(folder, &["view", "099", "--no-open"], &["099", "021"]);
    std::fs::write(folder.join("empty.plan.json"), "").expect("written");
    refused(
        folder,
        &["view", "021", "empty.plan.json", "--no-open"],
        &["empty.plan.json", "the file is empty"],
    );
    std::fs::write(folder.join("two.csv"), "0,0\n").expect("written");
    refused(folder, &["view", "021", "two.csv", "--no-open"], &["two.csv"]);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = taken.local_addr().expect("an address").port().to_string();
    refused(folder, &["view", "021", "--port", &port, "--no-open"], &[&port, "--port"]);
}

#[test]
fn a_search_is_run_again_and_its_trees_hold_every_node() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    if !has_page(folder) {
        return;
    }
    for (planner, more) in
        [("reach", &[][..]), ("ik-rrt", &["--no-shortcut"]), ("j-plus-rrt", &["--iterations", "300"])]
    {
        let plan = [&["plan", "021", "--planner", planner, "-o", "p.plan.json", "--json"], more].concat();
        let planned: Value = serde_json::from_slice(&cranny(folder, &plan).stdout).expect("JSON");
        let viewer = Viewer::start(folder, &["021", "p.plan.json", "--search-tree"]);
        let page = viewer.answer("GET", "/page.json", "");
        let tree = &page["plans"][0]["search_tree"];
        // Base64 of four bytes each.
        let nodes = planned["statistics"]["nodes"].as_u64().expect("a count");
        let characters = usize::try_from(nodes * 4).expect("few").div_ceil(3) * 4;
        assert_eq!(tree["trees"].as_str().map(str::len), Some(characters), "{planner}: {nodes} nodes");
    }
}

#[test]
fn a_failed_search_is_written_where_it_was_asked_for_and_shown_with_its_reasons() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let plan = ["plan", "045", "--iterations", "3", "--json"];
    let unnamed = cranny(folder, &plan);
    assert_eq!(unnamed.status.code(), Some(1));
    assert_eq!(std::fs::read_dir(folder).expect("a folder").count(), 0, "nobody named a file");
    let failed = cranny(folder, &[&plan[..], &["-o", "failed.plan.json"]].concat());
    assert_eq!(failed.status.code(), Some(1));
    let answer: Value = serde_json::from_slice(&failed.stdout).expect("JSON");
    assert_eq!(
        (&answer["outcome"], &answer["plan_file"]),
        (&"budget-exhausted".into(), &"failed.plan.json".into())
    );
    assert!(folder.join("failed.plan.json").is_file());
    if !has_page(folder) {
        return;
    }
    let viewer = Viewer::start(folder, &["045", "failed.plan.json"]);
    let page = viewer.answer("GET", "/page.json", "");
    let shown = &page["plans"][0];
    assert_eq!(shown["verdict"], "no path: time or iterations ran out");
    assert_eq!(shown["blocked"].as_array().map(Vec::len), answer["failures"].as_array().map(Vec::len));
    assert!(shown["blocked"].as_array().is_some_and(|blocked| !blocked.is_empty()));
}

/// Recording of a rising tile.
const RISING: &str = r#"{"format": "cranny-recording/1", "name": "a tile rises", "times_s": [0.0, 0.5],
 "bodies": [{"name": "tile", "is_grasped": true,
             "world_from_body": [[0, 0, 0, 0, 0, 0, 1], [0, 0, 0.1, 0, 0, 0, 1]],
             "vertices": [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], "triangles": [[0, 1, 2]]}]}"#;

#[test]
fn a_recording_is_a_page_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    if !has_page(folder) {
        return;
    }
    std::fs::write(folder.join("run.json"), RISING).expect("written");
    let viewer = Viewer::start(folder, &["run.json"]);
    let page = viewer.answer("GET", "/page.json", "");
    assert_eq!((&page["name"], &page["is_live"]), (&"a tile rises".into(), &false.into()));
    assert_eq!(page["recording"]["tracks"].as_array().map(Vec::len), Some(1));
    done(folder, &["render", "run.json", "-o", "run.html"]);
    let html = std::fs::read_to_string(folder.join("run.html")).expect("a file");
    assert!(html.contains("id=\"page-data\">H4sI"));
}

#[test]
fn a_bad_recording_is_refused_in_clear_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    if !has_page(folder) {
        return;
    }
    let written = |name: &str, from: &str, to: &str| {
        assert!(RISING.contains(from), "{from}");
        std::fs::write(folder.join(name), RISING.replacen(from, to, 1)).expect("written");
    };
    written("run.json", "rises", "rises");
    written("back.json", "[0.0, 0.5]", "[0.5, 0.0]");
    written("few.json", "[0.0, 0.5]", "[0.0, 0.5, 1.0]");
    written("bent.json", "[0, 0, 0, 0, 0, 0, 1]", "[0, 0, 0, 0, 0, 0, 3]");
    written("plan.json", "cranny-recording/1", "cranny-plan/1");
    written("cut.json", "\"triangles\": [[0, 1, 2]]}]}", "");
    for (file, words) in [
        ("back.json", &["back.json", "times_s", "ascending"][..]),
        ("few.json", &["body 'tile' has 2 poses", "3 times_s"]),
        ("bent.json", &["pose 0 of body 'tile'", "length 1"]),
        ("plan.json", &["'cranny-plan/1'", "the ID of its scenario"]),
        ("cut.json", &["cut.json:4"]),
        ("none.json", &["none.json"]),
    ] {
        refused(folder, &["view", file, "--no-open"], words);
        refused(folder, &["render", file, "-o", "x.html"], words);
    }
    for (more, words) in [
        (&["run.json"][..], "leave out the plan"),
        (&["--robot", "r.urdf"], "leave out --robot"),
        (&["--search-tree"], "leave out --search-tree"),
    ] {
        refused(folder, &[&["view", "run.json", "--no-open"], more].concat(), &["run.json", words]);
    }
}

/// Maximum size of a page for a typical plan, in bytes.
const MOST_BYTES: u64 = 3_000_000;

#[test]
fn one_html_file_holds_everything_and_loads_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    if !has_page(folder) {
        return;
    }
    done(folder, &["plan", "011", "-o", "p.plan.json", "--quiet"]);
    let rendered = done(folder, &["render", "011", "p.plan.json", "-o", "p.html", "--json"]);
    let answer: Value = serde_json::from_slice(&rendered.stdout).expect("JSON");
    assert_eq!(answer["files"], json!(["p.html"]));
    let html = std::fs::read_to_string(folder.join("p.html")).expect("a file");
    assert!((html.len() as u64) < MOST_BYTES, "{} bytes", html.len());
    for load in
        ["src=\"http", "href=\"http", "src='http", "@import", "url(http", "url(//", "src=\"/", "src=\"./"]
    {
        assert!(!html.contains(load), "it loads {load}…");
    }
    assert!(html.contains("default-src 'none'"));
    let data = html.split_once("id=\"page-data\">").and_then(|(_, rest)| rest.split_once("</script>"));
    let data = data.map(|(data, _)| data).expect("the data of the page");
    // The first bytes of gzip, in base64.
    assert!(data.starts_with("H4sI") && data.len() > 10_000, "{} characters", data.len());
    done(folder, &["render", "011", "p.plan.json", "-o", "q.html", "--json"]);
    assert_eq!(
        std::fs::read_to_string(folder.join("q.html")).expect("a file"),
        html,
        "same input, same bytes"
    );
    refused(folder, &["render", "011", "p.plan.json", "p.plan.json", "-o", "p.png"], &["--output", ".html"]);
    refused(
        folder,
        &["render", "011", "p.plan.json", "--search-tree", "-o", "p.png"],
        &["--search-tree", ".html"],
    );
    refused(folder, &["render", "011", "-o", "no/such/p.html"], &["folder does not exist"]);
}

/// The released robot comes with meshes, which make up most of its page.
#[test]
fn a_page_with_the_released_robot_is_light_too() {
    let Some(data) = std::env::var_os("CRANNY_DATA") else {
        eprintln!("SKIPPED: the page of the released robot (set CRANNY_DATA)");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    if !has_page(folder) {
        return;
    }
    let scenario = Path::new(&data).join("jogramop/scenarios/011").display().to_string();
    done(folder, &["plan", &scenario, "-o", "p.plan.json", "--quiet"]);
    done(folder, &["render", &scenario, "p.plan.json", "-o", "p.html", "--quiet"]);
    let bytes = std::fs::metadata(folder.join("p.html")).expect("a file").len();
    assert!(bytes < MOST_BYTES, "{bytes} bytes");
}
