use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use cranny_bench::{Campaign, MOST_SHARDS, Manifest, Sandbox};
use cranny_file::counted;
use cranny_plan::Registry;
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::campaigns::bench_worker;
use crate::campaigns::cluster_folder::{ClusterCampaign, ClusterFolder};
use crate::campaigns::slurm;
use crate::failure::Failure;
use crate::number_argument::whole;
use crate::progress::spinner;
use crate::text;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench slurm campaign.yaml --array 8
  cranny bench slurm campaign.yaml --array 100 -o runs/first -- \\
      --partition=short --time=8:00:00 --exclusive
  cranny bench slurm campaign.yaml --array 8 --local '$TMPDIR'   results on the node's own disk while a task runs
  cranny bench slurm campaign.yaml --array 8 --write-only        write the scripts, and say how to submit them
  cranny bench status campaign                                   how far it is
  cranny bench slurm --resume campaign                           submit what was lost

The folder must be seen by all nodes, and so must this program, the campaign file and what it names; each task compares
all of them with what was submitted. A task has one core and one worker (`-- --cpus-per-task=4`: four of each). When
all have ended, a last job joins their results in results.db and writes report.html. What comes after `--` goes to
sbatch as it is.")]
pub struct SlurmArguments {
    /// Campaign file (YAML)
    #[arg(value_name = "CAMPAIGN", required_unless_present = "resume")]
    campaign: Option<PathBuf>,
    /// Number of array tasks that the campaign is divided into
    #[arg(long, value_name = "N", required_unless_present = "resume", value_parser = whole(1..=MOST_SHARDS))]
    array: Option<u64>,
    /// Folder for scripts, results and the report, visible to all nodes [default: named as CAMPAIGN, in this folder]
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Keep the results of a running task in this folder of its node, and copy them to FOLDER when it ends; variables are
    /// expanded on the node
    #[arg(long, value_name = "FOLDER")]
    local: Option<String>,
    /// Sandbox of external programs, as in `bench run`
    #[arg(long, value_name = "WALLS", default_value = "auto", value_parser = bench_worker::sandbox)]
    sandbox: Sandbox,
    /// Write the scripts without submitting them
    #[arg(long)]
    write_only: bool,
    /// Submit the lost array tasks of this folder: those neither done nor known to Slurm
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["campaign", "array", "output", "local", "sandbox"])]
    resume: Option<PathBuf>,
    /// Options of sbatch
    #[arg(last = true, value_name = "OPTION")]
    sbatch: Vec<String>,
}

impl SlurmArguments {
    /// Returns the folder of the campaign, as given.
    fn folder(&self) -> PathBuf {
        let named = || self.campaign.as_ref().and_then(|file| file.file_stem()).map(PathBuf::from);
        self.resume.clone().or_else(|| self.output.clone()).or_else(named).unwrap_or_default()
    }
}

/// Output of `bench slurm --json`.
#[derive(Serialize)]
struct Answered {
    folder: PathBuf,
    trials: usize,
    tasks: Vec<u64>,
    /// Job numbers: the array, and the job that merges and reports.
    jobs: Vec<String>,
    /// Commands that submit them, if the user submits.
    commands: Vec<String>,
}

pub fn run(arguments: &SlurmArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    let given = arguments.folder();
    let (folder, mut campaign, tasks) = match &arguments.resume {
        Some(folder) => {
            let folder = ClusterFolder { path: absolute(folder)? };
            let campaign = folder.campaign()?;
            let active = slurm::active_tasks(&campaign.jobs)?;
            let tasks = folder.tasks(&campaign);
            let lost =
                tasks.iter().filter(|task| !task.standing.is_done() && !active.contains_key(&task.number));
            let lost: Vec<u64> = lost.map(|task| task.number).collect();
            (folder, campaign, lost)
        }
        None => begin(arguments, registry, output)?,
    };
    if !arguments.sbatch.is_empty() {
        campaign.sbatch.clone_from(&arguments.sbatch);
    }
    let mut answered = Answered {
        folder: given,
        trials: campaign.manifest.trials,
        tasks,
        jobs: Vec::new(),
        commands: Vec::new(),
    };
    if !answered.tasks.is_empty() {
        let array = format!("--array={}", list(&answered.tasks));
        // The report does not need an exclusive node.
        let of_report = campaign.sbatch.iter().filter(|option| !option.starts_with("--exclusive"));
        let of_report: Vec<String> = of_report.cloned().collect();
        if arguments.write_only {
            let said = |options: &[String], script: PathBuf| {
                let words = options.iter().map(|word| quoted(word));
                let words: Vec<String> = words.chain([quoted(&script.display().to_string())]).collect();
                format!("sbatch --parsable {}", words.join(" "))
            };
            let own = [&[array][..], &campaign.sbatch].concat();
            answered.commands.push(said(&own, folder.task_script()));
            let own = [&["--dependency=afterany:JOB".to_owned()][..], &of_report].concat();
            answered.commands.push(said(&own, folder.last_script()));
        } else {
            let job = slurm::submit(&[&[array][..], &campaign.sbatch].concat(), &folder.task_script())?;
            campaign.jobs.push(job.clone());
            folder.write_campaign(&campaign)?;
            let after = format!("--dependency=afterany:{job}");
            let last = slurm::submit(&[&[after][..], &of_report].concat(), &folder.last_script())?;
            answered.jobs = vec![job, last];
        }
    }
    text::answer(&answered, || answered.page(), output)?;
    Ok(Answer::Done)
}

/// Creates a new folder with its scripts; all array tasks are submitted.
fn begin(
    arguments: &SlurmArguments,
    registry: &Registry,
    output: Output,
) -> Result<(ClusterFolder, ClusterCampaign, Vec<u64>), Failure> {
    let missing = |flag| Failure::Flag { flag, problem: "required".to_owned() };
    let file = arguments.campaign.as_deref().ok_or_else(|| missing("campaign"))?;
    let tasks = arguments.array.ok_or_else(|| missing("array"))?;
    let campaign = Campaign::read(file, registry)?;
    let spinner = spinner("opening the scenarios", output.quiet);
    let schedule = campaign.schedule(registry);
    spinner.finish_and_clear();
    let schedule = schedule?;
    if tasks > schedule.questions.len() as u64 {
        let problem = format!(
            "the campaign has {}; give at most as many tasks",
            counted(schedule.questions.len(), "trial")
        );
        return Err(Failure::Flag { flag: "array", problem });
    }
    let name = file.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let path = arguments.folder();
    fs::create_dir_all(&path)?;
    let folder = ClusterFolder { path: absolute(&path)? };
    if folder.campaign_file().exists() {
        let problem = "the folder contains a campaign already; continue it with --resume, or give another \
                       folder";
        return Err(Failure::File { path: folder.path, problem: problem.to_owned() });
    }
    let program = std::env::current_exe()?;
    let manifest = Manifest::of(&schedule, &program);
    let of_folder = ClusterCampaign::new(absolute(file)?, tasks, manifest, arguments.sbatch.clone());
    fs::create_dir_all(folder.path.join("log"))?;
    let memory_mb = campaign.memory_limit_bytes >> 20;
    fs::write(folder.task_script(), task_script(&folder, &of_folder, &program, &name, memory_mb, arguments))?;
    fs::write(folder.last_script(), last_script(&folder, &program, &name))?;
    folder.write_campaign(&of_folder)?;
    Ok((folder, of_folder, (1..=tasks).collect()))
}

/// Memory of a worker before a search begins, with some reserve, in MB.
const OWN_MEMORY_MB: u64 = 512;

/// Returns the script of an array task, which at a shutdown of its node ends the trial's program and closes the results.
fn task_script(
    folder: &ClusterFolder,
    campaign: &ClusterCampaign,
    program: &Path,
    name: &str,
    memory_mb: u64,
    arguments: &SlurmArguments,
) -> String {
    let quote = |path: &Path| quoted(&path.display().to_string());
    let number = |path: PathBuf| format!("{}\"$task\"{}", quoted(split(&path).0), quoted(split(&path).1));
    let (results, standing) = (number(folder.results(VARIABLE)), number(folder.standing(VARIABLE)));
    let (to, from) = match &arguments.local {
        None => (String::new(), String::new()),
        Some(local) => (
            format!(
                "local=\"{local}\"/cranny-$SLURM_JOB_ID\nmkdir -p \"$local\" || exit 1\n\
                 test -e \"$results\" && cp \"$results\"* \"$local\"\nshared=$results\nresults=$local/${{shared##*/}}\n"
            ),
            // Copied under another name first, so that a file with the final name is complete.
            "cp \"$results\" \"$shared.partial\" && mv \"$shared.partial\" \"$shared\" && rm -r \"$local\"\n"
                .to_owned(),
        ),
    };
    format!(
        "#!/bin/sh
# Task $SLURM_ARRAY_TASK_ID of a campaign of cranny; it goes on where it was stopped.
#SBATCH --job-name={name}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem={memory}M
#SBATCH --requeue
#SBATCH --signal=B:TERM@60
#SBATCH --open-mode=append
#SBATCH --output={log}
task=$SLURM_ARRAY_TASK_ID
results={results}
{to}{program} bench run {file} --shard \"$task/{tasks}\" --manifest {manifest} --standing {standing} \\
    --workers \"${{SLURM_CPUS_PER_TASK:-1}}\" --sandbox {sandbox} -o \"$results\" &
run=$!
trap 'kill -TERM $run' TERM
wait $run
status=$?
# A signal ends the first wait, not the campaign.
while kill -0 $run 2> /dev/null; do
    wait $run
    status=$?
done
{from}exit $status
",
        name = word(name),
        memory = memory_mb + OWN_MEMORY_MB,
        log = folder.path.join("log/%a.txt").display(),
        program = quote(program),
        file = quote(&campaign.campaign),
        tasks = campaign.tasks,
        manifest = quote(&folder.campaign_file()),
        sandbox = arguments.sandbox.name(),
    )
}

/// Returns the script that runs after all array tasks have ended, successful or not.
fn last_script(folder: &ClusterFolder, program: &Path, name: &str) -> String {
    let quote = |path: &Path| quoted(&path.display().to_string());
    format!(
        "#!/bin/sh
# Joins the results of all tasks and reports them.
#SBATCH --job-name={name}-report
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --open-mode=append
#SBATCH --output={log}
cd {folder} || exit 1
rm -f joined.db
{program} bench merge task-*.db -o joined.db &&
    mv joined.db results.db &&
    {program} bench report results.db -o report.html --force
",
        name = word(name),
        log = folder.path.join("log/report.txt").display(),
        folder = quote(&folder.path),
        program = quote(program),
    )
}

/// Marks the position of the number of the array task in a path.
const VARIABLE: &str = "\u{1}";

fn split(path: &Path) -> (&str, &str) {
    path.to_str().and_then(|path| path.split_once(VARIABLE)).unwrap_or_default()
}

fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-=:,+@%".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

/// Returns a valid job name for `text`.
fn word(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' }).collect()
}

/// Formats numbers as Slurm lists them: `1-3,7`.
fn list(numbers: &[u64]) -> String {
    let mut ranges: Vec<[u64; 2]> = Vec::new();
    for &number in numbers {
        match ranges.last_mut() {
            Some([_, last]) if *last + 1 == number => *last = number,
            _ => ranges.push([number; 2]),
        }
    }
    let range =
        |[first, last]: &[u64; 2]| if first == last { first.to_string() } else { format!("{first}-{last}") };
    ranges.iter().map(range).collect::<Vec<_>>().join(",")
}

fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    Ok(std::path::absolute(path)?)
}

impl Answered {
    fn page(&self) -> String {
        let Self { folder, trials, tasks, jobs, commands } = self;
        let folder = folder.display();
        if tasks.is_empty() {
            return format!("{folder}: no task is lost, nothing was submitted\n");
        }
        let mut page = format!("{folder}: {}, tasks {}\n", counted(*trials, "trial"), list(tasks));
        if let [array, last] = &jobs[..] {
            let _ = writeln!(
                page,
                "  job {array} runs them, job {last} joins and reports them when all have ended"
            );
            let _ = writeln!(page, "  cranny bench status {folder}");
        }
        for command in commands {
            let _ = writeln!(page, "  {command}");
        }
        page
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_listed_in_ranges() {
        assert_eq!(list(&[1, 2, 3, 7, 9, 10]), "1-3,7,9-10");
        assert_eq!(list(&[5]), "5");
    }

    #[test]
    fn words_reach_a_shell_as_they_are() {
        for word in ["plain/path.db", "with space", "it's", "$HOME", "", "a;b"] {
            let echoed = std::process::Command::new("sh")
                .args(["-c", &format!("printf %s {}", quoted(word))])
                .output();
            assert_eq!(String::from_utf8(echoed.unwrap().stdout).unwrap(), word);
        }
    }
}
