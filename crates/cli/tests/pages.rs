//! Tests of the commands in the README and the pages of `docs/`. The commands of a page run in order in a folder of its own,
//! which is initialised as `examples/tutorial` (or as a comment in the page names it: `<!-- in: FOLDER -->`); a block under
//! `<!-- not run: REASON -->` is left out. A command exits with 0 unless its comment states otherwise (`# exits with 1`). Every
//! line of a block under `<!-- printed -->` must have been printed, except for times in ms.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// Root of the checkout.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Initial folder of a page unless it names another.
const TUTORIAL: &str = "examples/tutorial";

#[derive(Debug, Default, PartialEq)]
struct Block {
    /// Folder of examples to start in.
    folder: Option<String>,
    commands: Vec<Typed>,
    /// Lines that the commands before must have printed.
    printed: Vec<String>,
}

#[derive(Debug, PartialEq)]
struct Typed {
    line: usize,
    command: String,
    exit: i32,
}

impl Typed {
    fn of(line: usize, text: &str) -> Self {
        let (command, comment) = text.split_once("  # ").unwrap_or((text, ""));
        let exit =
            comment.trim().strip_prefix("exits with ").and_then(|rest| rest.split(':').next()?.parse().ok());
        let command = command.trim().replacen("cargo run --release -- ", "cranny ", 1);
        Self { line, command, exit: exit.unwrap_or(0) }
    }
}

/// Returns the blocks of commands to run.
fn blocks(page: &str) -> Vec<Block> {
    let (mut blocks, mut open) = (Vec::new(), None::<Block>);
    let (mut folder, mut is_left_out, mut is_printed) = (None, false, false);
    let mut has_examples = false;
    let mut lines = page.lines().zip(1..);
    while let Some((text, line)) = lines.next() {
        let comment = |key: &str| text.trim().strip_prefix(key)?.strip_suffix(" -->");
        if let Some(found) = comment("<!-- in: ") {
            folder = Some(found.to_owned());
        } else if comment("<!-- not run: ").is_some() {
            is_left_out = true;
        } else if text == "<!-- printed -->" {
            is_printed = true;
        } else if text == "```console" || (text == "```text" && is_printed) {
            open = Some(Block { folder: folder.take(), ..Block::default() });
        } else if text.starts_with("```") {
            blocks.extend(open.take().filter(|_| !std::mem::take(&mut is_left_out)));
            is_printed = false;
        } else if let (Some(block), true) = (&mut open, is_printed) {
            block.printed.extend((text.trim() != "…").then(|| text.to_owned()));
        } else if let (Some(block), Some(typed)) = (&mut open, text.strip_prefix("$ ")) {
            let mut typed = typed.to_owned();
            while let Some(begun) = typed.strip_suffix('\\') {
                let (more, _) = lines.next().expect("a line follows");
                typed = format!("{begun}{}", more.trim_start_matches("> "));
            }
            block.commands.push(Typed::of(line, &typed));
        } else if text.is_empty() || text.ends_with("| example |") {
            has_examples = !text.is_empty();
        } else if has_examples {
            let examples = text.trim_end_matches([' ', '|']).rsplit('|').next().unwrap_or_default();
            let examples = examples.split('`').skip(1).step_by(2).filter(|code| code.starts_with("cranny "));
            let commands: Vec<_> = examples.map(|example| Typed::of(line, example)).collect();
            blocks.extend((!commands.is_empty()).then(|| Block { commands, ..Block::default() }));
        }
    }
    blocks
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("examples").map(|entry| entry.expect("an entry")) {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(from, to).expect("copied");
        }
    }
}

/// Runs all commands of a page.
fn run(page: &str) {
    let text = std::fs::read_to_string(Path::new(ROOT).join(page)).expect("a page");
    let mut folder = example(TUTORIAL);
    let (mut count, mut printed) = (0, String::new());
    for block in blocks(&text) {
        if let Some(other) = &block.folder {
            folder = example(other);
        }
        for typed in &block.commands {
            if ["cranny view ", "cranny serve "].iter().any(|server| typed.command.starts_with(server)) {
                look(folder.path(), page, typed);
            } else {
                printed += &type_in(folder.path(), page, typed);
            }
            count += 1;
        }
        let found = without_times(&printed);
        for line in &block.printed {
            assert!(found.contains(&without_times(line)), "{page} has: {line}\nprinted: {printed}");
        }
    }
    assert!(count > 0, "{page}: no command");
}

/// Returns a text without its numbers of milliseconds.
fn without_times(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let is_time = |index: usize| words.get(index + 1).is_some_and(|unit| unit.starts_with("ms"));
    let kept = words.iter().enumerate().filter(|(index, _)| !is_time(*index)).map(|(_, word)| *word);
    kept.collect::<Vec<_>>().join(" ")
}

fn example(name: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    copy(&Path::new(ROOT).join(name), folder.path());
    folder
}

/// Returns a shell that finds `cranny`.
fn shell(folder: &Path, command: &str) -> Command {
    let program = assert_cmd::cargo::cargo_bin("cranny");
    let mut path = vec![program.parent().expect("a folder").to_owned()];
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let mut shell = Command::new("sh");
    let path = std::env::join_paths(path).expect("a path");
    shell.args(["-c", command]).current_dir(folder).env("PATH", path).stdin(Stdio::null());
    shell
}

/// Runs a command and returns its output.
fn type_in(folder: &Path, page: &str, typed: &Typed) -> String {
    let Typed { line, command, exit } = typed;
    let first = command.split(' ').next();
    assert!(matches!(first, Some("cranny" | "python3")), "{page}:{line}: nothing here runs '{command}'");
    let output = shell(folder, command).output().expect("a shell");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(*exit), "{page}:{line}: {command}\n{said}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Starts a server, the viewer without a browser, until it prints its address.
fn look(folder: &Path, page: &str, typed: &Typed) {
    let Typed { line, command, .. } = typed;
    let no_browser = if command.starts_with("cranny view ") { " --no-open" } else { "" };
    let command_line = format!("exec {command}{no_browser}");
    let mut server = shell(folder, &command_line).stdout(Stdio::piped()).spawn().expect("a shell");
    let mut address = String::new();
    let said = BufReader::new(server.stdout.take().expect("its output")).read_line(&mut address);
    server.kill().expect("it ends");
    server.wait().expect("it has ended");
    assert!(said.is_ok() && address.contains("http://"), "{page}:{line}: {command}: {address}");
}

macro_rules! pages {
    ($($test:ident: $page:literal,)*) => {
        const PAGES: &[&str] = &[$($page),*];

        $(#[test]
        fn $test() {
            run($page);
        })*
    };
}

pages! {
    readme: "README.md",
    carrying_out: "docs/carrying_out.md",
    certificate: "docs/certificate.md",
    command_line: "docs/command_line.md",
    exec_protocol: "docs/exec_protocol.md",
    first_plan: "docs/first_plan.md",
    index: "docs/index.md",
    physics: "docs/physics.md",
    placing: "docs/placing.md",
    robots: "docs/robots.md",
    ros: "docs/ros.md",
    sensing: "docs/sensing.md",
    your_campaign: "docs/your_campaign.md",
    your_object: "docs/your_object.md",
    your_planner: "docs/your_planner.md",
    your_scene: "docs/your_scene.md",
}

#[test]
fn no_page_is_forgotten() {
    let docs = std::fs::read_dir(Path::new(ROOT).join("docs")).expect("pages");
    for page in
        docs.map(|page| page.expect("a page").path()).filter(|page| page.extension() == Some("md".as_ref()))
    {
        let text = std::fs::read_to_string(&page).expect("a page");
        let name = format!("docs/{}", page.file_name().expect("a name").to_string_lossy());
        let has_commands = blocks(&text).iter().any(|block| !block.commands.is_empty());
        assert_eq!(has_commands, PAGES.contains(&name.as_str()), "{name}");
    }
}

#[test]
fn commands_are_read_from_blocks_and_tables() {
    let page = "Text\n```console\n$ cargo run --release -- plan 021\nsolved\n$ cranny verify a \\\n> b   # exits with 1: no\n```\n\
                <!-- not run: installs -->\n```console\n$ rm -r x\n```\n<!-- in: examples/x -->\n```console\n$ cranny list\n```\n\
                | command | answers | example |\n|---|---|---|\n| `list` | what | `cranny list`, `cranny info` |\n";
    let typed = |line, command: &str, exit| Typed { line, command: command.to_owned(), exit };
    let block = |folder: Option<&str>, commands| Block {
        folder: folder.map(str::to_owned),
        commands,
        printed: Vec::new(),
    };
    let first = vec![typed(3, "cranny plan 021", 0), typed(5, "cranny verify a b", 1)];
    let table = vec![typed(18, "cranny list", 0), typed(18, "cranny info", 0)];
    assert_eq!(
        blocks(page),
        [
            block(None, first),
            block(Some("examples/x"), vec![typed(14, "cranny list", 0)]),
            block(None, table)
        ]
    );
}

#[test]
fn every_setting_of_every_planner_is_on_its_page() {
    let page = std::fs::read_to_string(Path::new(ROOT).join("docs/planners.md")).expect("the page");
    let registry = cranny_plan::Registry::default();
    for name in registry.names() {
        let settings = registry.planner(name).expect("a planner").settings();
        for setting in settings.as_object().expect("settings").keys() {
            assert!(page.contains(&format!("`{setting}`")), "{name}: {setting}");
        }
    }
}
