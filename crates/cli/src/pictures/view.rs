use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Args;
use cranny_file::system::open_in_browser;
use cranny_plan::Registry;
use cranny_view::{PageServer, ServerLimits};
use serde::Serialize;
use tempfile::NamedTempFile;

use crate::Answer;
use crate::arguments::Output;
use crate::choices::GeometryArgument;
use crate::failure::Failure;
use crate::pictures::page_task::{PageRequest, PageTask};
use crate::progress::{interrupted, stop_on_interrupt};
use crate::text;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny view 021                                  the scenario and its grasps
  cranny view 021 021.plan.json                    a plan: play it, or click into its clearance
  cranny view 021 reach.plan.json rrt.plan.json    several plans in one scene
  cranny view 021 021.plan.json --search-tree      and how the search grew
  cranny view 021 --port 8080 --no-open            for a browser that you open yourself
  cranny view run.json                             a recording of `cranny simulate … --record`

Plans that failed are shown too, with what blocked each grasp. The page answers on this machine alone
(127.0.0.1), and there only to who knows its address, which holds a random token; it loads nothing from
the network, and ends with Ctrl-C. For a page to send to others:
cranny render 021 021.plan.json -o 021.html")]
pub struct ViewArguments {
    /// Built-in scenario, or the folder of one; or a recording (.json)
    #[arg(value_name = "ID|RECORDING")]
    pub id: String,
    /// Plan files (.plan.json) or way points (.csv, .try), side by side in one scene
    #[arg(value_name = "PLAN")]
    pub plans: Vec<PathBuf>,
    /// Repeat each plan's search, as its file states it, and show the growth of its trees
    #[arg(long)]
    pub search_tree: bool,
    /// Port of the server [default: a free one]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Print the address without opening a browser
    #[arg(long)]
    pub no_open: bool,
    /// Built-in robot, robot folder or model file to use instead of the scenario's robot
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Obstacles of a released scenario: the true boxes, or the inflated mesh that its planners used
    #[arg(long, value_enum)]
    pub geometry: Option<GeometryArgument>,
}

/// Output of `view --json`, printed as soon as the page can be opened.
#[derive(Serialize)]
struct Viewed<'a> {
    scenario: &'a str,
    url: String,
}

pub fn run(arguments: &ViewArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    // Checked before any search.
    PageServer::check_page()?;
    let server = PageServer::bind(arguments.port, ServerLimits::default())?;
    let request = PageRequest {
        id: &arguments.id,
        plans: &arguments.plans,
        robot: arguments.robot.as_deref(),
        geometry: arguments.geometry,
        criterion: None,
        grasps: cranny_scenario::GivenGrasps::Own,
        search_trees: arguments.search_tree.then_some(registry),
    };
    let PageTask { page, cells } = PageTask::open(&request, output)?;
    let url = server.url();
    let door = if arguments.no_open { None } else { doorway(&url).ok() };
    let mut said = Ok(());
    let stop = stop_on_interrupt();
    server.serve(&page, cells, interrupted(stop), || {
        said = if output.json {
            text::print_json(&Viewed { scenario: &arguments.id, url: url.clone() })
        } else {
            text::print(&format!("{url}  (Ctrl-C ends)\n"))
        };
        // The printed address suffices if this machine has no browser.
        if let Some(door) = &door {
            let file = door.path().to_owned();
            // In a thread of its own, because the call may block until the browser exits.
            std::thread::spawn(move || open_in_browser(&file));
        }
    })?;
    said?;
    Ok(Answer::Done)
}

/// Creates a file that redirects the browser to the page and that only the user can read. Every user of the machine can read
/// the arguments of a running browser, so they must not contain the address.
fn doorway(url: &str) -> io::Result<NamedTempFile> {
    let mut file = tempfile::Builder::new().prefix("cranny-").suffix(".html").tempfile()?;
    writeln!(
        file,
        "<!doctype html><meta charset=\"utf-8\"><meta name=\"referrer\" content=\"no-referrer\">\
         <meta http-equiv=\"refresh\" content=\"0; url={url}\"><title>Cranny</title><a href=\"{url}\">Cranny</a>"
    )?;
    file.flush()?;
    Ok(file)
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    #[test]
    fn the_file_that_leads_to_the_page_is_for_its_user_alone() {
        let door = doorway("http://127.0.0.1:1/secret/").expect("a file");
        let mode = door.as_file().metadata().expect("a file").permissions().mode();
        assert_eq!(mode & 0o077, 0, "{mode:o}");
        let text = std::fs::read_to_string(door.path()).expect("a file");
        assert!(text.contains("url=http://127.0.0.1:1/secret/"), "{text}");
    }
}
