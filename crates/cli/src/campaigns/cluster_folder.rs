//! Folder of a campaign on a cluster: the submitted campaign, the scripts, and the results of each array task.

use std::path::{Path, PathBuf};

use cranny_bench::{CampaignProgress, Manifest};
use cranny_scenario::write_whole_file;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// Content of `campaign.json` in the folder.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClusterCampaign {
    /// `cranny-cluster/1`.
    format: String,
    /// Path of the campaign file.
    pub campaign: PathBuf,
    /// Number of array tasks.
    pub tasks: u64,
    /// Manifest that every node must match.
    pub manifest: Manifest,
    /// Options of sbatch.
    pub sbatch: Vec<String>,
    /// Numbers of the submitted array jobs.
    pub jobs: Vec<String>,
}

const FORMAT: &str = "cranny-cluster/1";

/// Folder visible to all nodes.
#[derive(Clone, Debug)]
pub struct ClusterFolder {
    pub path: PathBuf,
}

/// Progress of an array task, by its number from 1.
#[derive(Clone, Debug)]
pub struct Task {
    pub number: u64,
    pub standing: CampaignProgress,
}

impl ClusterCampaign {
    pub fn new(campaign: PathBuf, tasks: u64, manifest: Manifest, sbatch: Vec<String>) -> Self {
        Self { format: FORMAT.to_owned(), campaign, tasks, manifest, sbatch, jobs: Vec::new() }
    }

    pub fn read(file: &Path) -> Result<Self, Failure> {
        let fault = |problem: String| Failure::File { path: file.to_owned(), problem };
        let text = cranny_file::TEXT.text(file).map_err(|reason| fault(reason.to_string()))?;
        let campaign: Self = serde_json::from_str(&text).map_err(|reason| fault(reason.to_string()))?;
        if campaign.format == FORMAT {
            return Ok(campaign);
        }
        Err(fault(format!("its format is '{}', but '{FORMAT}' is expected", campaign.format)))
    }
}

impl ClusterFolder {
    pub fn campaign_file(&self) -> PathBuf {
        self.path.join("campaign.json")
    }

    pub fn task_script(&self) -> PathBuf {
        self.path.join("task.sh")
    }

    pub fn last_script(&self) -> PathBuf {
        self.path.join("report.sh")
    }

    /// Returns the results file of an array task; in scripts `number` is a variable.
    pub fn results(&self, number: &str) -> PathBuf {
        self.path.join(format!("task-{number}.db"))
    }

    pub fn standing(&self, number: &str) -> PathBuf {
        self.path.join(format!("task-{number}.json"))
    }

    pub fn campaign(&self) -> Result<ClusterCampaign, Failure> {
        ClusterCampaign::read(&self.campaign_file())
    }

    pub fn write_campaign(&self, campaign: &ClusterCampaign) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(campaign).map_err(std::io::Error::from)? + "\n";
        // Written atomically, because it records the submitted jobs.
        Ok(write_whole_file(&self.campaign_file(), text.as_bytes())?)
    }

    /// Returns the progress of each array task, from its files; the default if it has written none.
    pub fn tasks(&self, campaign: &ClusterCampaign) -> Vec<Task> {
        let task = |number: u64| {
            let name = number.to_string();
            let standing = CampaignProgress::read(&self.standing(&name));
            let standing = standing.or_else(|| CampaignProgress::of_results(&self.results(&name)).ok());
            Task { number, standing: standing.unwrap_or_default() }
        };
        (1..=campaign.tasks).map(task).collect()
    }
}
