use std::fmt::Write;
use std::time::Instant;

use cranny_bench::{Isolation, Sandbox};
use cranny_collision::Margins;
use cranny_file::counted;
use cranny_path::audit;
use cranny_plan::Unobserved;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, solve};
use cranny_spatial::{Stream, simd_level_name, simd_levels};
use cranny_task::Problem;
use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::arguments::Output;
use crate::campaigns::bench_worker;
use crate::failure::Failure;
use crate::program::version::{COMMIT, TARGET};
use crate::{Answer, campaigns::slurm, text};

/// Scenario of the self-test.
const SCENARIO: &str = "021";

/// Expected [`digest`] of its way points, the same on every machine.
const WAYPOINTS: &str = "785954f4e0974e53";

/// Number of configurations checked with each instruction set: a twentieth of a second.
const CONFIGURATIONS: usize = 20_000;

/// Output of `doctor --json`; its keys are stable.
#[derive(Serialize)]
struct Findings {
    version: &'static str,
    commit: Option<&'static str>,
    target: &'static str,
    vectors: &'static str,
    cores: usize,
    parts: Vec<Part>,
    checks: Vec<Check>,
    sound: bool,
}

/// Optional component, which only some commands need.
#[derive(Serialize)]
struct Part {
    name: &'static str,
    is_there: bool,
    /// Commands that need it, or the remedy if it is missing.
    remark: &'static str,
}

/// Check that must pass on every machine.
#[derive(Serialize)]
struct Check {
    name: &'static str,
    passed: bool,
    /// Observed result.
    seen: String,
    time_s: f64,
}

pub fn run(output: Output) -> Result<Answer, Failure> {
    let checks = checks()?;
    let findings = Findings {
        version: env!("CARGO_PKG_VERSION"),
        commit: COMMIT,
        target: TARGET,
        vectors: simd_level_name(),
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        parts: parts()?,
        sound: checks.iter().all(|check| check.passed),
        checks,
    };
    text::answer(&findings, || page(&findings), output.aloud())?;
    Ok(if findings.sound { Answer::Done } else { Answer::No })
}

fn parts() -> Result<Vec<Part>, Failure> {
    let isolation = Isolation::of(Sandbox::Auto, &bench_worker::worker()?)?;
    let part = |name, is_there, [there, missing]: [&'static str; 2]| {
        let remark = if is_there { there } else { missing };
        Part { name, is_there, remark }
    };
    Ok(vec![
        part(
            "viewer's page",
            cranny_view::PageServer::check_page().is_ok(),
            [
                "`view`, `render -o page.html`",
                "this program was built without Node 20; install it and build again",
            ],
        ),
        part(
            "Landlock",
            isolation.landlock,
            [
                "`bench run` with external planners",
                "external planners can write anywhere (needs Linux 5.13 or newer)",
            ],
        ),
        part(
            "namespaces",
            isolation.namespaces,
            [
                "`bench run` with external planners",
                "external planners see other processes (needs user namespaces and util-linux)",
            ],
        ),
        part(
            "call filter",
            isolation.call_filter,
            [
                "`bench run` with external planners",
                "external planners can leave keys and memory in the kernel (needs seccomp)",
            ],
        ),
        part(
            "xacro",
            cranny_setup::has_xacro(),
            ["`robot add` of .xacro files", "for `robot add` of .xacro files: pip install xacro"],
        ),
        part(
            "ffmpeg",
            cranny_view::Film::check_encoder().is_ok(),
            ["`render -o film.mp4`", "for `render -o film.mp4`: install ffmpeg with libx264"],
        ),
        part("Slurm", slurm::is_there(), ["`bench slurm`", "for `bench slurm` without --write-only"]),
    ])
}

/// Plans, proves, and checks that a path through an obstacle is refused.
fn checks() -> Result<Vec<Check>, Failure> {
    let problem = Scenario::open(SCENARIO, &OpenOptions::default())?.problem(Margins::default())?;
    let mut checks = Vec::new();
    let begin = Instant::now();
    let answer = solve(&problem, &Request::default(), &mut Unobserved)?;
    let time_s = begin.elapsed().as_secs_f64();
    let clearance_m = answer.audit.as_ref().and_then(|audit| audit.clearance_m);
    let clearance = clearance_m.map_or_else(String::new, |m| format!(", clearance {}", text::at_least_mm(m)));
    checks.push(Check {
        name: "a plan is found and proven",
        passed: answer.is_solved(),
        seen: format!("scenario {SCENARIO}{clearance}"),
        time_s,
    });
    let waypoints = answer.waypoints();
    let digest = digest(&waypoints);
    checks.push(Check {
        name: "the plan is the reference plan, to the byte",
        passed: digest == WAYPOINTS,
        seen: format!("SHA-256 of its way points {digest}"),
        time_s: 0.0,
    });
    let begin = Instant::now();
    let straight: Vec<_> = [waypoints.first(), waypoints.last()].into_iter().flatten().cloned().collect();
    let verdict = audit(&problem, &straight)?;
    checks.push(Check {
        name: "a path through the table is rejected",
        passed: !verdict.valid,
        seen: verdict.violations.first().map(ToString::to_string).unwrap_or_default(),
        time_s: begin.elapsed().as_secs_f64(),
    });
    checks.push(same_verdicts(&problem));
    Ok(checks)
}

/// Checks that all instruction sets of this machine give the same verdicts on many configurations.
fn same_verdicts(problem: &Problem) -> Check {
    let begin = Instant::now();
    let Some(cell) = problem.cell() else { unreachable!("a problem under the exact criterion has a cell") };
    let mut random = Stream::new(0, 0);
    let configurations: Vec<f64> =
        (0..CONFIGURATIONS).flat_map(|_| problem.robot().random_configuration(&mut random)).collect();
    let mut scratch = cell.scratch();
    let mut all = Vec::new();
    let mut rates = Vec::new();
    for (name, level) in simd_levels() {
        let mut verdicts = Vec::new();
        let begin = Instant::now();
        cell.are_free_with(level, &configurations, &mut scratch, &mut verdicts);
        let rate = CONFIGURATIONS as f64 / begin.elapsed().as_secs_f64();
        rates.push(format!("{name} {:.2} M/s", rate / 1e6));
        all.push(verdicts);
    }
    let free = all.first().map_or(0, |verdicts| verdicts.iter().filter(|free| **free).count());
    Check {
        name: "all vector instruction sets agree",
        passed: free > 0 && all.windows(2).all(|two| two[0] == two[1]),
        seen: format!("{free} of {CONFIGURATIONS} configurations free: {}", rates.join(", ")),
        time_s: begin.elapsed().as_secs_f64(),
    }
}

/// Returns the first 16 hexadecimal digits of SHA-256 over all values, as little-endian `f64`.
fn digest(waypoints: &[Vec<f64>]) -> String {
    let mut hash = Sha256::new();
    for value in waypoints.iter().flatten() {
        hash.update(value.to_le_bytes());
    }
    hash.finalize().iter().take(8).fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}

fn page(findings: &Findings) -> String {
    let Findings { version, commit, target, vectors, cores, parts, checks, sound } = findings;
    let mut page = format!("cranny {version}, commit {}\n", commit.unwrap_or("unknown"));
    let _ = writeln!(page, "{target}, {vectors}, {}\n", counted(*cores, "core"));
    for Part { name, is_there, remark } in parts {
        let _ = writeln!(page, "  {}  {name:<15} {remark}", if *is_there { "there  " } else { "missing" });
    }
    page.push('\n');
    for Check { name, passed, seen, time_s } in checks {
        let time = if *time_s > 0.0 { format!(" ({})", text::seconds(*time_s)) } else { String::new() };
        let _ = writeln!(page, "  {}  {name}{time}", if *passed { "holds  " } else { "FAILS  " });
        let _ = writeln!(page, "           {seen}");
    }
    page.push_str(if *sound {
        "\nNo problems found.\n"
    } else {
        "\nSomething is wrong with this program or this machine: please report it, with the whole output \
         above.\n"
    });
    page
}
