//! C and C++ API: built, installed, and tested as a user of it would.

pub mod header;

use std::fs;
use std::path::{Path, PathBuf};

use crate::step::{self, Readiness, Surroundings};

/// Crate of the C API.
const CRATE: &str = "crates/capi";

/// Programs that the tests need.
const TOOLS: [&str; 5] = ["cc", "c++", "cmake", "pkg-config", "valgrind"];

/// Debian's packages of the tools, and of OMPL, which brings Eigen, but not all parts of Boost that it is linked with.
const PACKAGES: [&str; 9] = [
    "cmake",
    "g++",
    "libboost-filesystem-dev",
    "libboost-serialization-dev",
    "libboost-system-dev",
    "libompl-dev",
    "make",
    "pkg-config",
    "valgrind",
];

/// Libraries of the system that the static library needs, as `rustc --print native-static-libs` names them on Linux.
const NATIVE_LIBRARIES: [&str; 6] = ["gcc_s", "util", "rt", "pthread", "m", "dl"];

/// Checks for compilers, CMake, pkg-config, Valgrind and OMPL; installs what is missing if this needs no confirmation.
pub fn readiness(here: &Surroundings) -> Readiness {
    let missing = |here: &Surroundings| {
        let runs = |program: &str, words: &[&str]| {
            here.command(program, words).output().is_ok_and(|output| output.status.success())
        };
        let tool = TOOLS.into_iter().find(|tool| !runs(tool, &["--version"]));
        let has_ompl = || {
            let header =
                ["-include", "boost/archive/text_oarchive.hpp", "-fsyntax-only", "-x", "c++", "/dev/null"];
            runs("pkg-config", &["--exists", "ompl"]) && runs("c++", &header)
        };
        tool.or_else(|| (!has_ompl()).then_some("OMPL with Boost"))
    };
    let Some(first) = missing(here) else { return Readiness::Ready };
    let installed = here.install(&PACKAGES);
    match (missing(here), installed) {
        (None, _) => Readiness::Ready,
        (Some(missing), Ok(())) => {
            Readiness::Missing(format!("no {missing}, though apt-get has installed it"))
        }
        (Some(_), Err(reason)) => {
            Readiness::Missing(format!("no {first}: `apt-get install {}` ({reason})", PACKAGES.join(" ")))
        }
    }
}

/// Builds the library and installs it below `prefix`, with headers, licences, and files for CMake and pkg-config.
///
/// # Errors
/// If it cannot be built, or a file cannot be written.
pub fn install(here: &Surroundings, prefix: &Path) -> Result<(), String> {
    let prefix = &std::path::absolute(prefix).map_err(|fault| format!("{}: {fault}", prefix.display()))?;
    // With the command, whose crates have the same features as in the other steps: nothing is built twice.
    step::succeed(here.cargo(&["build", "--release", "--quiet", "-p", "cranny-capi", "-p", "cranny-cli"]))?;
    let shared = here.program().with_file_name("libcranny_capi.so");
    if !shared.is_file() {
        return Err(format!("{}: there is none; the C API is installed on Linux alone", shared.display()));
    }
    let version = env!("CARGO_PKG_VERSION");
    let minor = version.rsplit_once('.').map_or(version, |(minor, _)| minor);
    let libraries = prefix.join("lib");
    copy(&shared, &libraries.join(format!("libcranny.so.{version}")))?;
    copy(&shared.with_extension("a"), &libraries.join("libcranny.a"))?;
    // The loader looks for the minor version, the linker for the bare name.
    for (name, target) in [(format!("libcranny.so.{minor}"), version), ("libcranny.so".to_owned(), minor)] {
        let link = libraries.join(name).display().to_string();
        step::succeed(here.command("ln", &["-sf", &format!("libcranny.so.{target}"), &link]))?;
    }
    let headers = here.root.join(CRATE).join("include");
    for header in files_below(&headers)? {
        let inside = header.strip_prefix(&headers).map_err(|fault| fault.to_string())?;
        copy(&header, &prefix.join("include").join(inside))?;
    }
    let pointer_bytes = size_of::<usize>().to_string();
    let values = [
        ("@VERSION@", version),
        ("@MINOR_VERSION@", minor),
        ("@POINTER_BYTES@", &pointer_bytes),
        ("@NATIVE_LIBRARIES@", &NATIVE_LIBRARIES.join(";")),
        ("@NATIVE_FLAGS@", &NATIVE_LIBRARIES.map(|library| format!("-l{library}")).join(" ")),
    ];
    for (name, folder) in [
        ("crannyConfig.cmake", "cmake/cranny"),
        ("crannyConfigVersion.cmake", "cmake/cranny"),
        ("cranny.pc", "pkgconfig"),
    ] {
        let template = read(&here.root.join(CRATE).join("package").join(name))?;
        let text = values.iter().fold(template, |text, (mark, value)| text.replace(mark, value));
        write(&libraries.join(folder).join(name), &text)?;
    }
    for name in ["LICENSE-APACHE", "LICENSE-MIT", "crates/view/NOTICES.txt"] {
        let file = here.root.join(name);
        let target = prefix.join("share/doc/cranny").join(file.file_name().unwrap_or_default());
        copy(&file, &target)?;
    }
    println!("installed cranny {version} below {}", prefix.display());
    Ok(())
}

/// Installs the API and moves it (1), builds the examples against it with CMake and runs them (2), and one more with pkg-config
/// (3), then its tests under the sanitizers (4) and under Valgrind (5). A long run adds a campaign of the example with OMPL (6).
///
/// # Errors
/// If any of these fails.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let folder = here.root.join("target/capi");
    // 1. Left by an earlier run; it may not exist.
    let _ = fs::remove_dir_all(folder.join("first"));
    let prefix = folder.join("moved");
    let _ = fs::remove_dir_all(&prefix);
    install(here, &folder.join("first"))?;
    fs::rename(folder.join("first"), &prefix).map_err(|fault| format!("{}: {fault}", prefix.display()))?;
    // 2.
    let examples = folder.join("examples");
    build_and_test(here, "examples/cpp", &examples, &prefix, "-DCMAKE_BUILD_TYPE=Release")?;
    // 3.
    with_pkg_config(here, &folder, &prefix)?;
    // 4.
    let tests = format!("{CRATE}/tests/cpp");
    build_and_test(here, &tests, &folder.join("sanitized"), &prefix, "-DCRANNY_SANITIZE=ON")?;
    // 5.
    let plain = folder.join("plain");
    build_and_test(here, &tests, &plain, &prefix, "-DCRANNY_SANITIZE=OFF")?;
    for program in ["bad_input", "wrapper_17"] {
        let program = plain.join(program).display().to_string();
        let leaks = ["--leak-check=full", "--errors-for-leak-kinds=definite,indirect", "--error-exitcode=9"];
        // Random numbers that the kernel writes without a system call count as uninitialised in Valgrind.
        let quiet = ["--quiet", "--undef-value-errors=no"];
        step::succeed(here.command("valgrind", &[&quiet[..], &leaks, &[&program]].concat()))?;
    }
    // 6.
    if here.is_long { campaign(here, &folder, &examples) } else { Ok(()) }
}

/// Builds a CMake project against the API below `prefix`, and runs its tests.
fn build_and_test(
    here: &Surroundings,
    source: &str,
    build: &Path,
    prefix: &Path,
    option: &str,
) -> Result<(), String> {
    let folder = build.display().to_string();
    let prefix = format!("-DCMAKE_PREFIX_PATH={}", prefix.display());
    step::succeed(here.command("cmake", &["-S", source, "-B", &folder, &prefix, option, "-Wno-dev"]))?;
    step::succeed(here.command("cmake", &["--build", &folder, "--parallel", "2"]))?;
    step::succeed(here.command("ctest", &["--test-dir", &folder, "--output-on-failure", "--no-tests=error"]))
}

fn with_pkg_config(here: &Surroundings, folder: &Path, prefix: &Path) -> Result<(), String> {
    let mut asked = here.command("pkg-config", &["--cflags", "--libs", "cranny"]);
    let asked = asked.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")).output();
    let asked = asked.map_err(|fault| format!("pkg-config: {fault}"))?;
    let flags = String::from_utf8_lossy(&asked.stdout).into_owned();
    let program = folder.join("with_pkg_config").display().to_string();
    let words =
        [&["examples/cpp/verdicts.c", "-o", &program][..], &flags.split_whitespace().collect::<Vec<_>>()];
    step::succeed(here.command("cc", &words.concat()))?;
    let mut command = here.command(program, &[]);
    command.env("LD_LIBRARY_PATH", prefix.join("lib"));
    step::succeed(command)
}

/// Runs the example with OMPL as a planner of a campaign on the twenty scenarios, all of whose trials must be solved.
fn campaign(here: &Surroundings, folder: &Path, examples: &Path) -> Result<(), String> {
    let results = folder.join("ompl.db");
    // Left by an earlier run; it may not exist.
    let _ = fs::remove_file(&results);
    let planner = examples.join("ompl_planner");
    let planner = format!("ompl=exec:{} {{cranny}} {{seed}} {{time_limit_s}}", planner.display());
    let results = results.display().to_string();
    let request = ["--scenarios", "all", "--time-limit", "60", "--planner", &planner, "-o", &results];
    let program = here.built_program()?;
    step::succeed(here.command(&program, &[&["bench", "run"][..], &request].concat()))?;
    let status = here.command(&program, &["bench", "status", &results, "--json"]).output();
    let status = status.map_err(|fault| format!("cranny bench status: {fault}"))?;
    let status: serde_json::Value =
        serde_json::from_slice(&status.stdout).map_err(|fault| fault.to_string())?;
    let (ended, solved) = (&status["ended"], &status["solved"]);
    if ended == 20 && solved == 20 {
        Ok(())
    } else {
        Err(format!("OMPL solved {solved} of {ended} of 20 trials"))
    }
}

fn files_below(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(|fault| format!("{}: {fault}", folder.display()))? {
        let path = entry.map_err(|fault| format!("{}: {fault}", folder.display()))?.path();
        if path.is_dir() { files.extend(files_below(&path)?) } else { files.push(path) }
    }
    Ok(files)
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    make_folder_of(to)?;
    fs::copy(from, to).map(|_| ()).map_err(|fault| format!("{}: {fault}", to.display()))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    make_folder_of(path)?;
    fs::write(path, text).map_err(|fault| format!("{}: {fault}", path.display()))
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|fault| format!("{}: {fault}", path.display()))
}

fn make_folder_of(file: &Path) -> Result<(), String> {
    let folder = file.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(|fault| format!("{}: {fault}", folder.display()))
}
