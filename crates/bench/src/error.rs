use std::path::{Path, PathBuf};

use cranny_file::{nearest_files, suggested};

/// What can be wrong with a campaign, its results or a worker. What a planner does wrong is none of these: it is
/// an outcome of its trial.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A file of results is not there.
    #[error("{}: there are no results (`cranny bench run -o {}` makes some)", path.display(), path.display())]
    NoResults {
        /// The file.
        path: PathBuf,
    },
    /// A file is no results of Cranny.
    #[error("{}: the file holds no results of campaigns; give one that `cranny bench run` wrote", path.display())]
    NotResults {
        /// The file.
        path: PathBuf,
    },
    /// A file says that it is results, but its tables are not those of results.
    #[error(
        "{}: '{name}' is not as Cranny makes it; the file is damaged, or not Cranny's",
        path.display()
    )]
    OtherTable {
        /// The file.
        path: PathBuf,
        /// Which table, or index.
        name: String,
    },
    /// The pages of a file do not fit together.
    #[error("{}: the file is damaged: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What `SQLite` says.
        problem: String,
    },
    /// Results were written by another version of Cranny.
    #[error("{}: the results are of version {actual}, and this program knows version {expected}", path.display())]
    ResultsVersion {
        /// The file.
        path: PathBuf,
        /// The version that can be read.
        expected: i64,
        /// The version that the file has.
        actual: i64,
    },
    /// A row of the results says what it cannot.
    #[error("{}: trial {id}: '{text}' is no {what}", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// Which trial.
        id: u64,
        /// What the text should have been.
        what: &'static str,
        /// What stands there.
        text: String,
    },
    /// There is no such trial.
    #[error("{}: there is no trial {id} (the trials are 1 to {last})", path.display())]
    NoTrial {
        /// The file.
        path: PathBuf,
        /// The one asked for.
        id: u64,
        /// The last there is.
        last: u64,
    },
    /// The database refuses.
    #[error("{}: {reason}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// What it says.
        reason: rusqlite::Error,
    },
    /// A scenario.
    #[error(transparent)]
    Scenario(#[from] cranny_scenario::ScenarioError),
    /// A planner.
    #[error(transparent)]
    Plan(#[from] cranny_plan::PlanError),
    /// A task.
    #[error(transparent)]
    Task(#[from] cranny_task::TaskError),
    /// A path.
    #[error(transparent)]
    Path(#[from] cranny_path::PathError),
    /// A plan file, or what is asked of a scenario.
    #[error(transparent)]
    Record(#[from] cranny_record::RecordError),
    /// A question to a built-in planner.
    #[error(transparent)]
    Solve(#[from] cranny_solve::SolveError),
    /// Nothing has an id of this pattern.
    #[error(
        "no built-in scenario matches '{pattern}' ('x' stands for any digit: 01x, 0x5; 'all' for all of them), and \
         there is no folder or archive of that name{}",
        suggested(&nearest_files(Path::new(pattern)))
    )]
    Pattern {
        /// The pattern.
        pattern: String,
    },
    /// A planner's program is not there.
    #[error("there is no program '{program}' (give a path such as ./planner, or a name that is in PATH)")]
    Program {
        /// What was asked for.
        program: String,
    },
    /// A program cannot be run.
    #[error("cannot run '{program}': {reason}")]
    NotRunnable {
        /// The program.
        program: String,
        /// What the operating system says.
        reason: String,
    },
    /// Walls around the programs of others are required, and this machine has not all of them.
    #[error("this machine has no {missing}; --sandbox auto runs programs within the walls that there are")]
    NoSandbox {
        /// What is missing.
        missing: &'static str,
    },
    /// A part of a campaign finds another campaign than the one that was handed out.
    #[error("this is not the campaign that was handed out: {what} is another")]
    OtherCampaign {
        /// What is another.
        what: String,
    },
    /// Results hold trials that another part of the campaign runs.
    #[error(
        "{}: {trials} trials of the campaign are not of its part {part}: the file is of another part, of another number of runs \
         or parts, or of another version of Cranny; give this part a file of its own (`cranny bench merge` joins them)",
        results.display()
    )]
    OtherPart {
        /// The results.
        results: PathBuf,
        /// The part that is to be run.
        part: String,
        /// Number of trials of other parts.
        trials: usize,
    },
    /// Two files of results have the same trial, and it went differently.
    #[error(
        "{path}: {count} trials that are in {into} too went differently there, the first of them {first}; --keep-first takes those of the file that comes first"
    )]
    Overlap {
        /// The file that was to be taken up.
        path: PathBuf,
        /// The file that takes up.
        into: PathBuf,
        /// How many trials.
        count: u64,
        /// Scenario, planner and seed of one.
        first: String,
    },
    /// A scenario has fewer goal configurations than a trial aims at.
    #[error("scenario {scenario} has {known} goal configurations, so there is no goal {goal}")]
    Goal {
        /// The scenario.
        scenario: String,
        /// Which goal, from 0.
        goal: usize,
        /// How many there are.
        known: usize,
    },
    /// A campaign without a set of grasps asks for what only a set can give.
    #[error("with `grasps: none` there is no {what}, which takes a set of grasps")]
    NeedsGraspSet {
        /// What is asked.
        what: &'static str,
    },
    /// A campaign would ask nothing.
    #[error("the campaign has no {what}")]
    Empty {
        /// What is missing.
        what: &'static str,
    },
    /// Two planners of a campaign cannot be told apart.
    #[error("two planners of the campaign are called '{name}'; give one of them another `name`")]
    PlannerName {
        /// The name.
        name: String,
    },
    /// A number of a campaign is none.
    #[error("{what} is {value}, but must be {range}")]
    Range {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What would fit.
        range: &'static str,
    },
    /// A file of results cannot be made.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// A campaign is larger than anybody could wait for.
    #[error("the campaign has {trials} trials, but at most {most}; ask fewer seeds, or several campaigns")]
    TooManyTrials {
        /// How many it has.
        trials: u64,
        /// How many it may have.
        most: u64,
    },
    /// A campaign's file cannot be read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// A campaign's file is malformed, or says what it should not.
    #[error("{}:{line}: {problem}", path.display())]
    CampaignFile {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong.
        problem: String,
    },
    /// A planner does not take a scenario at all.
    #[error("scenario {scenario}, planner {planner}: {reason}")]
    Refused {
        /// The scenario.
        scenario: String,
        /// The planner.
        planner: String,
        /// What the worker says.
        reason: String,
    },
    /// The scenario of a trial is not what it was.
    #[error(
        "scenario {scenario} is not the one of the trial: its content has changed, or it is not where it was \
         ({source_name}); give the right one with --scenario"
    )]
    OtherScenario {
        /// The scenario.
        scenario: String,
        /// What it was opened by.
        source_name: String,
    },
    /// The files of a scenario changed while a campaign ran.
    #[error(
        "scenario {scenario} ({source_name}) has changed since the campaign began; what is stored stays. Begin the campaign \
         again: trials on the new content are counted apart"
    )]
    ChangedScenario {
        /// The scenario.
        scenario: String,
        /// What it was opened by.
        source_name: String,
    },
    /// A program is not the one that a trial was planned with.
    #[error(
        "the program of planner '{planner}' is not the one of the trial: a file of `{command}` has changed, or is gone"
    )]
    OtherProgram {
        /// The planner.
        planner: String,
        /// The command.
        command: String,
    },
    /// A trial runs a command that somebody may have written into the results.
    #[error(
        "trial {id} runs a program, as these results name it: `{command}`; if you trust them, --allow-exec runs it"
    )]
    ForeignCommand {
        /// The trial.
        id: u64,
        /// The command.
        command: String,
    },
    /// Another campaign writes the results.
    #[error(
        "{}: another campaign is writing these results; wait for its end, or write to another file and join both by \
         `cranny bench merge`",
        path.display()
    )]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// How a planner was called is not known.
    #[error("how planner '{planner}' of the trial was called is not in the results")]
    UnknownCall {
        /// The planner.
        planner: String,
    },
    /// Campaign and worker do not understand each other.
    #[error("a message between campaign and worker: {problem}")]
    Message {
        /// What is wrong.
        problem: String,
    },
    /// A trial with a figure that no trial can have.
    #[error("trial {trial}: its {figure} is {value}, which no trial can have")]
    Figure {
        /// Number of the trial.
        trial: u64,
        /// Which figure.
        figure: &'static str,
        /// What stands there.
        value: f64,
    },
    /// There is nothing to report.
    #[error("{results}: the results hold no trial; `cranny bench run -o {results}` adds some")]
    NoTrials {
        /// Name of the results.
        results: String,
    },
    /// A plot could not be made into pixels.
    #[error("cannot draw '{plot}': {problem}")]
    Picture {
        /// Name of the plot.
        plot: String,
        /// What the library says.
        problem: String,
    },
}

impl BenchError {
    pub(crate) fn message(fault: &dyn std::fmt::Display) -> Self {
        Self::Message { problem: fault.to_string() }
    }
}
