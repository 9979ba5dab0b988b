use std::path::{Path, PathBuf};

use cranny_file::{excerpt, nearest_files, suggested, visible_line};

/// Errors of campaigns, results and workers. A failure of a planner is no such error: it is an outcome of its trial.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A results file does not exist.
    #[error(
        "{}: results file not found (create it with `cranny bench run -o {}`)",
        path.display(),
        path.display()
    )]
    NoResults {
        /// The file.
        path: PathBuf,
    },
    /// The file is not a results file of Cranny.
    #[error("{}: not a results file: expected a file written by `cranny bench run`", path.display())]
    NotResults {
        /// The file.
        path: PathBuf,
    },
    /// The file is marked as results, but its tables have another schema.
    #[error(
        "{}: '{name}' differs from Cranny's database schema: the file is damaged, or from another program",
        path.display()
    )]
    OtherTable {
        /// The file.
        path: PathBuf,
        /// Name of the table or index.
        name: String,
    },
    /// The database pages of the file are inconsistent.
    #[error("{}: the file is damaged: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Message of `SQLite`.
        problem: String,
    },
    /// Results were written by another version of Cranny.
    #[error(
        "{}: the results have format version {actual}, but this program supports version {expected}",
        path.display()
    )]
    ResultsVersion {
        /// The file.
        path: PathBuf,
        /// The supported version.
        expected: i64,
        /// The version of the file.
        actual: i64,
    },
    /// A row of the results has an invalid value.
    #[error("{}: trial {id}: '{text}' is not a valid {what}", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// Number of the trial.
        id: u64,
        /// Kind of value that was expected.
        what: &'static str,
        /// The invalid text.
        text: String,
    },
    /// The results contain no trial with this number.
    #[error("{}: unknown trial {id} (known: 1 to {last})", path.display())]
    NoTrial {
        /// The file.
        path: PathBuf,
        /// The requested number.
        id: u64,
        /// The last number in the file.
        last: u64,
    },
    /// The database reports an error.
    #[error("{}: {reason}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// The error of the database.
        reason: rusqlite::Error,
    },
    /// Error of a scenario.
    #[error(transparent)]
    Scenario(#[from] cranny_scenario::ScenarioError),
    /// Error of a planner.
    #[error(transparent)]
    Plan(#[from] cranny_plan::PlanError),
    /// Error of a simulation.
    #[error(transparent)]
    Sim(Box<cranny_sim::SimError>),
    /// Error of a task.
    #[error(transparent)]
    Task(#[from] cranny_task::TaskError),
    /// Error of a path.
    #[error(transparent)]
    Path(#[from] cranny_path::PathError),
    /// Error of a plan file, or of the demands on a scenario.
    #[error(transparent)]
    Record(#[from] cranny_record::RecordError),
    /// Error of a request to a built-in planner.
    #[error(transparent)]
    Solve(#[from] cranny_solve::SolveError),
    /// No built-in scenario and no file matches the pattern.
    #[error(
        "no built-in scenario matches '{pattern}' ('x' stands for any digit: 01x, 0x5; 'all' for all of them), and \
         there is no folder or archive of that name{}",
        suggested(&nearest_files(Path::new(pattern)))
    )]
    Pattern {
        /// The pattern.
        pattern: String,
    },
    /// The program of a planner does not exist.
    #[error("program '{program}' not found (give a path such as ./planner, or a name that is in PATH)")]
    Program {
        /// The requested program.
        program: String,
    },
    /// A program cannot be started.
    #[error("cannot run '{program}': {reason}")]
    NotRunnable {
        /// The program.
        program: String,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// A trial was not started for lack of processes, memory, descriptors or disk space.
    #[error("the trial could not be started: {reason}")]
    NotStarted {
        /// Error of the operating system.
        reason: String,
    },
    /// Full isolation of external programs is required, but this machine lacks one of its mechanisms.
    #[error(
        "this machine has no {missing}; with --sandbox auto, programs run with the protection that is \
         available"
    )]
    NoSandbox {
        /// The missing isolation mechanism.
        missing: &'static str,
    },
    /// A shard of a campaign finds a campaign that differs from the manifest.
    #[error("the campaign differs from the submitted one in {what}")]
    OtherCampaign {
        /// The property that differs.
        what: String,
    },
    /// The results contain trials of another shard of the campaign.
    #[error(
        "{}: {trials} trials of the campaign are not in its shard {part}: the file is from another shard, \
         from another number of runs or shards, or from another version of Cranny; give each shard its own \
         file (`cranny bench merge` joins them)",
        results.display()
    )]
    OtherShard {
        /// The results file.
        results: PathBuf,
        /// The shard to run.
        part: String,
        /// Number of trials of other shards.
        trials: usize,
    },
    /// Two results files contain the same trial with different results.
    #[error(
        "{path}: {count} trials have another result in the files before it (to be merged into {into}), the first of them {first}; --keep-first keeps \
         the result of the file that is given first"
    )]
    Overlap {
        /// The file to merge.
        path: PathBuf,
        /// The file merged into.
        into: PathBuf,
        /// Number of such trials.
        count: u64,
        /// Scenario, planner and seed of one such trial.
        first: String,
    },
    /// Two results files contain the same run with different information.
    #[error(
        "{path}: {runs} runs have another machine, program or command in {into}: one of the files was changed \
         by hand; --keep-first keeps what the file that is given first states"
    )]
    OtherRun {
        /// The file to merge.
        path: PathBuf,
        /// The file merged into.
        into: PathBuf,
        /// Number of such runs.
        runs: u64,
    },
    /// The results file of a running campaign is no longer the one that the campaign writes.
    #[error(
        "{}: the results file was removed, replaced or truncated during the campaign, which stops here; {kept}",
        path.display()
    )]
    ResultsGone {
        /// The file.
        path: PathBuf,
        /// Result of saving the trials to another file.
        kept: String,
    },
    /// A trial aims at a goal configuration that the scenario does not have.
    #[error("scenario {scenario} has {known} goal configurations, so there is no goal {goal}")]
    Goal {
        /// The scenario.
        scenario: String,
        /// Index of the goal, from 0.
        goal: usize,
        /// Number of goal configurations of the scenario.
        known: usize,
    },
    /// A campaign without a grasp set requires something that only a grasp set provides.
    #[error("{what} needs a set of grasps, but the campaign has `grasps: none`")]
    NeedsGraspSet {
        /// The requirement.
        what: &'static str,
    },
    /// The campaign is empty.
    #[error("the campaign has no {what}")]
    Empty {
        /// The missing element.
        what: &'static str,
    },
    /// Two planners of a campaign have the same name.
    #[error("two planners of the campaign are called '{name}'; give one of them another `name`")]
    PlannerName {
        /// The name.
        name: String,
    },
    /// The name of a planner has characters that tables and lists cannot show.
    #[error(
        "the name of planner '{}' is empty, longer than 200 characters, begins or ends with a blank, or has a \
         character that cannot be seen; give it another `name`",
        excerpt(&visible_line(name))
    )]
    PlannerLetters {
        /// The name.
        name: String,
    },
    /// A number of a campaign is out of range.
    #[error("{what} is {value}, but must be {range}")]
    Range {
        /// Description of the number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The valid range.
        range: &'static str,
    },
    /// A results file cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// The campaign has more trials than allowed.
    #[error(
        "the campaign has {trials} trials, but at most {most} are allowed; reduce the runs, or split the \
         campaign"
    )]
    TooManyTrials {
        /// Number of trials.
        trials: u64,
        /// Maximum number of trials.
        most: u64,
    },
    /// A campaign file cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// A campaign file is malformed or has an invalid value.
    #[error("{}:{line}: {problem}", path.display())]
    CampaignFile {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// Description of the problem.
        problem: String,
    },
    /// A planner refuses a scenario.
    #[error("scenario {scenario}, planner {planner}: {reason}")]
    Refused {
        /// The scenario.
        scenario: String,
        /// The planner.
        planner: String,
        /// Reason given by the worker.
        reason: String,
    },
    /// The scenario of a trial has changed.
    #[error(
        "scenario {scenario} differs from that of the trial: its content has changed, or it was moved \
         ({source_name}); give the original with --scenario"
    )]
    OtherScenario {
        /// The scenario.
        scenario: String,
        /// Source of the scenario: a built-in id or a path.
        source_name: String,
    },
    /// The files of a scenario changed during a campaign.
    #[error(
        "scenario {scenario} ({source_name}) has changed since the campaign began; stored trials are kept. \
         Start the campaign again: trials on the new content are counted separately"
    )]
    ChangedScenario {
        /// The scenario.
        scenario: String,
        /// Source of the scenario: a built-in id or a path.
        source_name: String,
    },
    /// The program differs from the one that the trial was planned with.
    #[error(
        "the program of planner '{planner}' differs from that of the trial: a file of `{command}` has \
         changed, or is missing"
    )]
    OtherProgram {
        /// The planner.
        planner: String,
        /// The command.
        command: String,
    },
    /// Replaying the trial would run a command from the results, which may come from an untrusted source.
    #[error(
        "trial {id} runs a program that these results name: `{command}`; if you trust it, allow it with \
         --allow-exec"
    )]
    ForeignCommand {
        /// Number of the trial.
        id: u64,
        /// The command.
        command: String,
    },
    /// Another campaign is writing to these results.
    #[error(
        "{}: another campaign is writing these results; wait for its end, or write to another file and join both by \
         `cranny bench merge`",
        path.display()
    )]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// The results do not contain the call of the planner.
    #[error("the results do not record the command or settings of planner '{planner}' of the trial")]
    UnknownCall {
        /// The planner.
        planner: String,
    },
    /// Campaign and worker exchanged an invalid message.
    #[error("invalid message between campaign and worker: {problem}")]
    Message {
        /// Description of the problem.
        problem: String,
    },
    /// A trial has a figure that is out of range.
    #[error("trial {trial}: its {figure} is {value}, which is not a valid value")]
    Figure {
        /// Number of the trial.
        trial: u64,
        /// Name of the figure.
        figure: &'static str,
        /// The value of the figure.
        value: f64,
    },
    /// A trial is solved after its time limit, which no campaign records.
    #[error("trial {trial}: it is solved after {time_s} s, but its time limit is {limit_s} s")]
    Late {
        /// Number of the trial.
        trial: u64,
        /// Time of the search, in seconds.
        time_s: f64,
        /// Time limit, in seconds.
        limit_s: f64,
    },
    /// The results contain no trial to report.
    #[error("{results}: the results contain no trial; add trials with `cranny bench run -o {results}`")]
    NoTrials {
        /// Name of the results.
        results: String,
    },
    /// A plot could not be drawn.
    #[error("cannot draw '{plot}': {reason}")]
    Picture {
        /// Name of the plot.
        plot: String,
        /// Failure of the chart.
        reason: cranny_chart::ChartError,
    },
}

impl From<cranny_sim::SimError> for BenchError {
    fn from(fault: cranny_sim::SimError) -> Self {
        Self::Sim(Box::new(fault))
    }
}

impl BenchError {
    pub(crate) fn message(fault: &dyn std::fmt::Display) -> Self {
        Self::Message { problem: fault.to_string() }
    }

    /// Returns true if another program locks the database.
    pub(crate) fn is_locked(&self) -> bool {
        let code = if let Self::Database { reason, .. } = self { reason.sqlite_error_code() } else { None };
        code == Some(rusqlite::ErrorCode::DatabaseBusy)
    }

    /// Returns true if a trial could not be started for a reason that may pass by itself.
    pub(crate) fn is_shortage(&self) -> bool {
        match self {
            Self::NotStarted { .. } => true,
            Self::NotRunnable { reason, .. }
            | Self::Scenario(cranny_scenario::ScenarioError::Unwritable { reason, .. }) => {
                cranny_file::system::is_shortage(reason)
            }
            _ => false,
        }
    }
}
