//! Shell scripts of a campaign on a cluster: that of an array task, and that of the job which merges and reports.

use std::path::Path;

use cranny_bench::Sandbox;
use cranny_file::shell_word;

use crate::campaigns::cluster_folder::{ClusterCampaign, ClusterFolder};
use crate::failure::Failure;

/// Values that both scripts need.
pub struct ClusterScripts<'a> {
    folder: &'a ClusterFolder,
    /// Quoted path of this program.
    program: String,
    /// Name of the jobs in Slurm.
    name: String,
}

/// Memory of a worker before a search begins, with some reserve, in MiB.
const OWN_MEMORY_MIB: u64 = 512;

impl<'a> ClusterScripts<'a> {
    /// Prepares the scripts in `folder`, with absolute paths and any campaign name.
    ///
    /// # Errors
    /// [`Failure::File`] for a path that a script cannot contain, as [`plain`].
    pub fn new(folder: &'a ClusterFolder, program: &Path, name: &str) -> Result<Self, Failure> {
        plain(&folder.path)?;
        Ok(Self { folder, program: quoted(program)?, name: job_name(name) })
    }

    /// Returns the options of sbatch that send the output of each array task, and that of the last job, to a file of the
    /// folder. They are no `#SBATCH` lines, because those have quoting rules of their own.
    pub fn output_options(folder: &ClusterFolder) -> Result<[String; 2], Failure> {
        let path = plain(&folder.path)?;
        // Slurm removes backslashes from a file name, and then replaces no `%a`.
        if path.contains('\\') {
            let problem = "Slurm cannot write to a folder with a backslash in its path; give another folder";
            return Err(Failure::File { path: folder.path.clone(), problem: problem.to_owned() });
        }
        let path = path.replace('%', "%%");
        Ok(["%a.txt", "report.txt"].map(|file| format!("--output={path}/log/{file}")))
    }

    /// Returns the script of an array task, which at a shutdown of its node ends the trial's program and closes the results.
    pub fn task(
        &self,
        campaign: &ClusterCampaign,
        memory_mib: u64,
        sandbox: Sandbox,
        local: Option<&str>,
    ) -> Result<String, Failure> {
        let number = |path: &Path| -> Result<String, Failure> {
            let text = path.to_str().and_then(|path| path.split_once(VARIABLE)).unwrap_or_default();
            Ok(format!("{}\"$task\"{}", shell_word(text.0), shell_word(text.1)))
        };
        let (results, standing) =
            (number(&self.folder.results(VARIABLE))?, number(&self.folder.standing(VARIABLE))?);
        let (to, from) = match local {
            None => (String::new(), String::new()),
            Some(local) => (
                format!(
                    "local={}/cranny-$SLURM_JOB_ID\nmkdir -p \"$local\" || exit 1\n\
                     if test -e \"$results\"; then\n    cp \"$results\"* \"$local\" || exit 1\nfi\nshared=$results\n\
                     results=$local/${{shared##*/}}\n",
                    on_node(local)?
                ),
                // Its log is written back first: a killed campaign leaves one. It is copied under another name, so that a file with
                // the final name is complete.
                format!(
                    "{program} bench status \"$results\" > /dev/null\n\
                     if test $? -le 1 && test ! -s \"$results-wal\" && cp \"$results\" \"$shared.partial\" && \
                     mv \"$shared.partial\" \"$shared\"; then\n    rm -r \"$local\"\nelse\n    \
                     echo \"the results stay in $local\" >&2\nfi\n",
                    program = self.program,
                ),
            ),
        };
        Ok(format!(
            "#!/bin/sh
# Task $SLURM_ARRAY_TASK_ID of a campaign of cranny; it continues an interrupted run.
#SBATCH --job-name={name}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem={memory}M
#SBATCH --requeue
#SBATCH --signal=B:TERM@60
#SBATCH --open-mode=append
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
            name = self.name,
            memory = memory_mib + OWN_MEMORY_MIB,
            program = self.program,
            file = quoted(&campaign.campaign)?,
            tasks = campaign.tasks,
            manifest = quoted(&self.folder.campaign_file())?,
            sandbox = sandbox.name(),
        ))
    }

    /// Returns the script that runs after all array tasks have ended, successful or not.
    pub fn last(&self) -> Result<String, Failure> {
        Ok(format!(
            "#!/bin/sh
# Joins the results of all tasks and reports them.
#SBATCH --job-name={name}-report
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --open-mode=append
cd {folder} || exit 1
rm -f joined.db
{program} bench merge task-*.db -o joined.db &&
    mv joined.db results.db &&
    {program} bench report results.db -o report.html --force
",
            name = self.name,
            folder = quoted(&self.folder.path)?,
            program = self.program,
        ))
    }
}

/// Marks the position of the number of the array task in a path.
const VARIABLE: &str = "\u{1}";

/// Returns the text of a path.
///
/// # Errors
/// [`Failure::File`] for a path that is no UTF-8, or has a control character: a line break would begin another command.
fn plain(path: &Path) -> Result<&str, Failure> {
    let fault = |problem: &str| Failure::File { path: path.to_owned(), problem: problem.to_owned() };
    let text = path.to_str().ok_or_else(|| fault("a script of Slurm needs a path in UTF-8"))?;
    if text.chars().any(char::is_control) {
        return Err(fault(
            "a script of Slurm cannot contain a path with a line break or another control character",
        ));
    }
    Ok(text)
}

fn quoted(path: &Path) -> Result<String, Failure> {
    plain(path).map(shell_word)
}

/// Returns a folder of a node as a word of the shell, in which variables (`$NAME`, `${NAME}`) are expanded and nothing else.
fn on_node(folder: &str) -> Result<String, Failure> {
    let fault = |problem: &str| Failure::Flag { flag: "local", problem: problem.to_owned() };
    if folder.is_empty() || folder.starts_with('-') || folder.chars().any(char::is_control) {
        return Err(fault("expected a folder, without control characters"));
    }
    let mut pieces = folder.split('$');
    let first = pieces.next().unwrap_or_default();
    let mut word = if first.is_empty() { String::new() } else { shell_word(first) };
    for piece in pieces {
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let (name, rest) = match piece.strip_prefix('{') {
            Some(inside) => inside.split_once('}').unwrap_or_default(),
            None => piece.split_at(piece.find(|c| !is_name(c)).unwrap_or(piece.len())),
        };
        let is_variable =
            !name.is_empty() && name.chars().all(is_name) && !name.starts_with(|c: char| c.is_ascii_digit());
        if !is_variable {
            return Err(fault(
                "after '$' there must be the name of a variable, such as $TMPDIR or ${TMPDIR}",
            ));
        }
        word.extend(["\"${", name, "}\""]);
        if !rest.is_empty() {
            word += &shell_word(rest);
        }
    }
    Ok(word)
}

/// Returns a valid job name for `text`.
fn job_name(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_a_node_expands_variables_and_nothing_else() {
        for (folder, expected) in [
            ("$TMPDIR", "\"${TMPDIR}\""),
            ("/scratch/${USER}/it's here", "/scratch/\"${USER}\"'/it'\\''s here'"),
            ("/a`touch b`\"c", "'/a`touch b`\"c'"),
        ] {
            assert_eq!(on_node(folder).expect("a folder"), expected);
        }
        for folder in ["", "-x", "a\nb", "$(touch b)", "/a$", "${TMPDIR:-$(touch b)}", "$1"] {
            assert!(on_node(folder).is_err(), "{folder:?}");
        }
    }

    #[test]
    fn paths_that_a_script_cannot_contain_are_refused() {
        for path in ["a\nb", "a\rb", "a\u{1b}b", "a\u{85}b"] {
            let folder = ClusterFolder { path: path.into() };
            assert!(ClusterScripts::new(&folder, Path::new("/bin/cranny"), "name").is_err(), "{path:?}");
            assert!(quoted(Path::new(path)).is_err());
        }
        let options = |path: &str| ClusterScripts::output_options(&ClusterFolder { path: path.into() });
        assert_eq!(options("/a %b").expect("options")[0], "--output=/a %%b/log/%a.txt");
        assert!(options("/a\\b").is_err());
    }
}
