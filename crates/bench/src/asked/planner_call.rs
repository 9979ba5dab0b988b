use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use cranny_file::system::{FileStamp, installed_program};
use cranny_grasp::ScoreKind;
use cranny_plan::Registry;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use sha2::{Digest as _, Sha256};

use crate::{BenchError, PathDemand, Trial};

/// Call of a planner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlannerCall {
    /// A built-in planner.
    BuiltIn {
        /// Its name in the registry.
        planner: String,
        /// Settings that differ from the defaults; all settings after [`Self::checked`].
        settings: Map<String, Value>,
        /// Score used for the grasps.
        #[serde(default, skip_serializing_if = "is_geometric")]
        score: ScoreKind,
        /// Minimum score of the goal grasps; `None` accepts all grasps.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        min_score: Option<f64>,
    },
    /// An external program with the protocol of `docs/exec_protocol.md`.
    Exec {
        /// The program and its arguments; `{seed}` and the other placeholders of the protocol are replaced.
        command: Vec<String>,
    },
    /// The program released by the paper's authors, or one with the same command line and output.
    Released {
        /// The program.
        program: String,
        /// Arguments after the standard ones, such as `-planner 0`; the last value of a repeated option counts.
        arguments: Vec<String>,
    },
}

impl PlannerCall {
    /// Parses a flag: a built-in planner, `exec:PROGRAM ARGUMENT…` or `released:PROGRAM ARGUMENT…`, with spaces between words.
    ///
    /// # Errors
    /// As [`Self::checked`].
    pub fn parse(text: &str, registry: &Registry) -> Result<Self, BenchError> {
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        let call = match text.split_once(':') {
            Some(("exec", command)) => Self::Exec { command: words(command) },
            Some(("released", command)) => {
                let mut words = words(command).into_iter();
                Self::Released { program: words.next().unwrap_or_default(), arguments: words.collect() }
            }
            _ => {
                let (settings, score) = (Map::new(), ScoreKind::default());
                Self::BuiltIn { planner: text.to_owned(), settings, score, min_score: None }
            }
        };
        call.checked(registry)
    }

    /// Validates the call, makes relative paths absolute and lists all settings: it can then be repeated from another folder.
    ///
    /// # Errors
    /// [`BenchError::Plan`] for an unknown planner or setting, [`BenchError::Program`] for a missing program.
    pub fn checked(self, registry: &Registry) -> Result<Self, BenchError> {
        let program = |word: &str| -> Result<String, BenchError> {
            let missing = || BenchError::Program { program: word.to_owned() };
            if word.is_empty() {
                return Err(missing());
            }
            if !word.contains(std::path::is_separator) {
                return if installed_program(word).is_some() { Ok(word.to_owned()) } else { Err(missing()) };
            }
            if Path::new(word).is_file() { absolute(word).ok_or_else(missing) } else { Err(missing()) }
        };
        let argument = |word: String| {
            if Path::new(&word).is_file() { absolute(&word).unwrap_or(word) } else { word }
        };
        Ok(match self {
            Self::BuiltIn { planner, settings, score, min_score } => {
                let all = registry.planner_with(&planner, &settings)?.settings();
                let settings = all.as_object().cloned().unwrap_or(settings);
                Self::BuiltIn { planner, settings, score, min_score }
            }
            Self::Exec { command } => {
                let mut words = command.into_iter();
                let first = program(&words.next().unwrap_or_default())?;
                Self::Exec { command: std::iter::once(first).chain(words.map(argument)).collect() }
            }
            Self::Released { program: word, arguments } => Self::Released {
                program: program(&word)?,
                arguments: arguments.into_iter().map(argument).collect(),
            },
        })
    }

    /// Returns the default name: that of the built-in planner, or `exec:` or `released:` and the first file of the command.
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn { planner, .. } => planner.clone(),
            Self::Exec { command } => {
                let file = command.iter().find(|word| is_file(word)).or_else(|| command.first());
                format!("exec:{}", file.map_or("", |word| file_name(word)))
            }
            Self::Released { program, .. } => format!("released:{}", file_name(program)),
        }
    }

    /// Returns the command line of the external program; empty for a built-in planner.
    pub fn command(&self) -> String {
        match self {
            Self::BuiltIn { .. } => String::new(),
            Self::Exec { command } => command.join(" "),
            Self::Released { program, arguments } => {
                [std::slice::from_ref(program), arguments].concat().join(" ")
            }
        }
    }

    /// Checks that the files of the command are those that the trial was planned with.
    ///
    /// # Errors
    /// [`BenchError::OtherProgram`].
    pub(crate) fn check_unchanged(&self, trial: &Trial) -> Result<(), BenchError> {
        let settings = PathDemand::of_settings(&trial.settings).among(self.settings());
        if settings == trial.settings {
            return Ok(());
        }
        Err(BenchError::OtherProgram { planner: trial.planner.clone(), command: self.command() })
    }

    /// Returns all settings of a [checked](Self::checked) call, as canonical JSON: identical on every machine. A file of
    /// the command counts by its name and content, not by its folder.
    pub fn settings(&self) -> String {
        let words = |words: &[String]| -> Value {
            words.iter().map(|word| if is_file(word) { file_name(word) } else { word }).collect()
        };
        let files = |words: &[String]| -> Value {
            let files = words.iter().filter(|word| is_file(word));
            Value::Object(files.map(|word| (file_name(word).to_owned(), checksum(word).into())).collect())
        };
        let settings = match self {
            Self::BuiltIn { planner, settings, score, min_score } => {
                let mut all = Value::Object(settings.clone());
                all["planner"] = planner.clone().into();
                // Trials with the default score keep their identity.
                if !is_geometric(score) {
                    all["score"] = score.name().into();
                }
                if let Some(min_score) = min_score {
                    all["min_score"] = (*min_score).into();
                }
                all
            }
            Self::Exec { command } => json!({"exec": words(command), "files": files(command)}),
            Self::Released { program, arguments } => {
                let command: Vec<String> = std::iter::once(program).chain(arguments).cloned().collect();
                json!({"released": words(&command), "files": files(&command)})
            }
        };
        sorted(&settings).to_string()
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde wants it")]
fn is_geometric(score: &ScoreKind) -> bool {
    *score == ScoreKind::Geometric
}

/// Sorts the keys of every object, independently of the features of the JSON library.
fn sorted(value: &Value) -> Value {
    match value {
        Value::Object(object) => {
            let mut keys: Vec<&String> = object.keys().collect();
            keys.sort();
            Value::Object(keys.into_iter().map(|key| (key.clone(), sorted(&object[key]))).collect())
        }
        Value::Array(values) => values.iter().map(sorted).collect(),
        other => other.clone(),
    }
}

fn is_file(word: &str) -> bool {
    word.contains(std::path::is_separator) && Path::new(word).is_file()
}

fn file_name(word: &str) -> &str {
    Path::new(word).file_name().and_then(|name| name.to_str()).unwrap_or(word)
}

/// Makes a path absolute, keeping links: the Python of a virtual environment finds its packages only through its link.
fn absolute(word: &str) -> Option<String> {
    Some(std::path::absolute(word).ok()?.to_str()?.to_owned())
}

/// Returns the SHA-256 of a file, cached until its stamp changes.
fn checksum(word: &str) -> String {
    static KNOWN: Mutex<BTreeMap<String, (FileStamp, String)>> = Mutex::new(BTreeMap::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let stamp = FileStamp::of(Path::new(word));
    match (known.get(word), &stamp) {
        (Some((before, sum)), Some(now)) if before == now => return sum.clone(),
        _ => {}
    }
    let sum = computed_checksum(Path::new(word));
    if let Some(stamp) = stamp {
        known.insert(word.to_owned(), (stamp, sum.clone()));
    }
    sum
}

/// Computes the SHA-256 of a program.
pub fn computed_checksum(program: &Path) -> String {
    hexadecimal(&Sha256::digest(cranny_file::PROGRAM.bytes(program).unwrap_or_default()))
}

/// Returns bytes as hexadecimal text.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn the_settings_of_a_program_tell_its_content_and_not_its_place() {
        let (here, there) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let call = |folder: &tempfile::TempDir, content: &str| {
            let script = folder.path().join("planner.py");
            fs::write(&script, content).unwrap();
            PlannerCall::parse(&format!("exec:sh {} --fast {{seed}}", script.display()), &Registry::default())
                .unwrap()
        };
        let (a, b) = (call(&here, "one"), call(&there, "one"));
        assert_eq!(a.settings(), b.settings());
        assert_eq!(a.name(), "exec:planner.py");
        assert!(!a.settings().contains(here.path().to_str().unwrap()));
        assert_ne!(a.settings(), call(&there, "two").settings());
    }

    /// The Python of a virtual environment finds its packages only through its link.
    #[cfg(unix)]
    #[test]
    fn a_program_is_called_by_the_name_that_it_was_given() {
        let folder = tempfile::tempdir().unwrap();
        let (program, link) = (folder.path().join("program"), folder.path().join("link"));
        fs::write(&program, "#!/bin/sh\n").unwrap();
        std::os::unix::fs::symlink(&program, &link).unwrap();
        let call = PlannerCall::parse(&format!("exec:{}", link.display()), &Registry::default()).unwrap();
        assert_eq!(call, PlannerCall::Exec { command: vec![link.display().to_string()] });
    }

    #[test]
    fn the_settings_of_a_built_in_planner_are_all_its_settings() {
        let call = PlannerCall::parse("ik-rrt", &Registry::default()).unwrap();
        assert!(
            call.settings().contains("\"p_goal\":0.01") && call.settings().contains("\"planner\":\"ik-rrt\"")
        );
        assert!(matches!(PlannerCall::parse("ik-rtt", &Registry::default()), Err(BenchError::Plan(_))));
        assert!(matches!(
            PlannerCall::parse("exec:./no/such/program", &Registry::default()),
            Err(BenchError::Program { .. })
        ));
        assert!(matches!(PlannerCall::parse("exec:", &Registry::default()), Err(BenchError::Program { .. })));
        // This error occurs before the campaign begins, not in its first trial.
        assert!(matches!(
            PlannerCall::parse("exec:no-such-program x", &Registry::default()),
            Err(BenchError::Program { .. })
        ));
    }
}
