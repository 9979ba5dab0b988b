use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use cranny_bench::{Campaign, MOST_SHARDS, Manifest, Sandbox};
use cranny_file::{counted, shell_file, shell_word};
use cranny_plan::Registry;
use cranny_scenario::write_whole_file;
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::campaigns::bench_worker;
use crate::campaigns::cluster_folder::{ClusterCampaign, ClusterFolder};
use crate::campaigns::cluster_scripts::ClusterScripts;
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
  cranny bench slurm campaign.yaml --array 8 --write-only        write the scripts, and print how to submit them
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
    #[arg(long, value_name = "SANDBOX", default_value = "auto", value_parser = bench_worker::sandbox)]
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
        let [of_tasks, of_last] = ClusterScripts::output_options(&folder)?;
        let array = [format!("--array={}", list(&answered.tasks)), of_tasks];
        // The report does not need an exclusive node.
        let of_report = campaign.sbatch.iter().filter(|option| !option.starts_with("--exclusive"));
        let of_report: Vec<String> = of_report.cloned().collect();
        if arguments.write_only {
            let said = |options: &[String], script: PathBuf| {
                let words = options.iter().map(|word| shell_word(word));
                let words: Vec<String> = words.chain([shell_word(&script.display().to_string())]).collect();
                format!("sbatch --parsable {}", words.join(" "))
            };
            let own = [&array[..], &campaign.sbatch].concat();
            answered.commands.push(said(&own, folder.task_script()));
            let own = [&["--dependency=afterany:JOB".to_owned(), of_last][..], &of_report].concat();
            answered.commands.push(said(&own, folder.last_script()));
        } else {
            let job = slurm::submit(&[&array[..], &campaign.sbatch].concat(), &folder.task_script())?;
            campaign.jobs.push(job.clone());
            folder.write_campaign(&campaign)?;
            let after = format!("--dependency=afterany:{job}");
            let last = slurm::submit(&[&[after, of_last][..], &of_report].concat(), &folder.last_script())?;
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
    let folder = ClusterFolder { path: absolute(&arguments.folder())? };
    if folder.campaign_file().exists() {
        let problem = "the folder contains a campaign already; continue it with --resume, or give another \
                       folder";
        return Err(Failure::File { path: folder.path, problem: problem.to_owned() });
    }
    let program = std::env::current_exe()?;
    let manifest = Manifest::of(&schedule, &program);
    let of_folder = ClusterCampaign::new(absolute(file)?, tasks, manifest, arguments.sbatch.clone());
    // Every path is checked before the first file is written.
    ClusterScripts::output_options(&folder)?;
    let scripts = ClusterScripts::new(&folder, &program, &name)?;
    // Slurm counts in MiB.
    let memory_mib = campaign.memory_limit_bytes.div_ceil(1 << 20);
    let task = scripts.task(&of_folder, memory_mib, arguments.sandbox, arguments.local.as_deref())?;
    let last = scripts.last()?;
    fs::create_dir_all(folder.path.join("log"))?;
    write_whole_file(&folder.task_script(), task.as_bytes())?;
    write_whole_file(&folder.last_script(), last.as_bytes())?;
    folder.write_campaign(&of_folder)?;
    Ok((folder, of_folder, (1..=tasks).collect()))
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
        let shown = folder.display();
        if tasks.is_empty() {
            return format!("{shown}: no task is lost, nothing was submitted\n");
        }
        let mut page = format!("{shown}: {}, tasks {}\n", counted(*trials, "trial"), list(tasks));
        if let [array, last] = &jobs[..] {
            let _ = writeln!(
                page,
                "  job {array} runs them, job {last} joins and reports them when all have ended"
            );
            let _ = writeln!(page, "  cranny bench status {}", shell_file(folder));
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
}
