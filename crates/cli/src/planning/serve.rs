use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use cranny_local_server::{Call, LocalServer, Method, Reply, ServerLimits, StatusCode};
use cranny_plan::Observer;
use cranny_record::{MoveItPlanner, MoveItSettings, RecordError};
use cranny_scenario::moveit_document;
use serde_json::{Value, json};
use tokio::sync::{Mutex, Semaphore, oneshot};

use crate::Answer;
use crate::arguments::{Output, sample_rate};
use crate::failure::Failure;
use crate::number_argument::{millimetres, seconds};
use crate::progress::{interrupted, stop_on_interrupt};
use crate::text;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny serve --robot fr3
  cranny serve --robot arm.urdf --srdf arm.srdf --port 8642
  cranny serve --robot crane/crane.urdf --json > address.json

POST plan, below the printed address, takes {\"planning_scene\": …, \"motion_plan_request\": …}, messages of
moveit_msgs in JSON, and answers {\"motion_plan_response\": …, \"cranny\": …}. GET of the address itself
answers with name, version, robot and groups. Requests are planned one after the other. The server answers
on this machine alone (127.0.0.1), and there only to who knows its address, which holds a random token;
Ctrl-C ends it.")]
pub struct ServeArguments {
    /// Robot that plans: a built-in one (see `cranny robot list`), the folder of one, or a URDF with SRDF, `joint_limits.yaml`,
    /// limits.yaml and robot.yaml beside it
    #[arg(long, value_name = "FILE")]
    pub robot: PathBuf,
    /// SRDF of the robot [default: the one beside the URDF]
    #[arg(long, value_name = "FILE")]
    pub srdf: Option<PathBuf>,
    /// Port of the server [default: a free one]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Maximum time of a search, in seconds; a request may allow less (`allowed_planning_time`)
    #[arg(long, value_name = "S", default_value = "30", value_parser = seconds)]
    pub time_limit: Duration,
    /// Clearance that every check and proof requires between any two bodies, in millimetres
    #[arg(long, value_name = "MM", default_value = "0", value_parser = millimetres)]
    pub margin: f64,
    /// Sample rate of trajectories, in Hz
    #[arg(long, value_name = "HZ", default_value = "100", value_parser = sample_rate)]
    pub rate: f64,
}

/// Maximum size of a request in bytes, like that of a text file.
const MOST_BODY_BYTES: usize = 64 << 20;

/// Maximum number of requests that are planned or wait; others are refused.
const MOST_WAITING: u32 = 8;

/// Allowance for reading, proof and timing of one request, which its time limit does not cover.
const BESIDE_THE_SEARCH: Duration = Duration::from_mins(1);

pub fn run(arguments: &ServeArguments, output: Output) -> Result<Answer, Failure> {
    let ServeArguments { robot, srdf, port, time_limit, margin, rate } = arguments;
    let settings = MoveItSettings { most_time: *time_limit, rate_hz: *rate, margin_m: *margin };
    let planner = MoveItPlanner::open(robot, srdf.as_deref(), settings)?;
    let limits = ServerLimits {
        connections: 64,
        request: Duration::from_secs(10),
        connection: time_limit.saturating_add(BESIDE_THE_SEARCH).saturating_mul(MOST_WAITING),
    };
    let server = LocalServer::bind(*port, limits)?;
    let url = server.url();
    let stop = stop_on_interrupt();
    let mut description = json!({
        "name": "cranny",
        "version": env!("CARGO_PKG_VERSION"),
        "robot": planner.robot_name(),
        "groups": planner.groups(),
    });
    let served = Arc::new(Served {
        description: description.clone(),
        planner: Arc::new(Mutex::new(planner)),
        places: Arc::new(Semaphore::new(MOST_WAITING as usize)),
        stop: stop.clone(),
    });
    let answer = move |call| {
        let served = served.clone();
        async move { served.answer(call).await }
    };
    let mut written = Ok(());
    server.serve(answer, interrupted(stop), || {
        written = if output.json {
            description["url"] = url.into();
            text::print_json(&description)
        } else {
            text::print(&format!("{url}  (Ctrl-C ends)\n"))
        };
    })?;
    written?;
    Ok(Answer::Done)
}

/// State shared by all responses.
struct Served {
    description: Value,
    /// Planner, for one request at a time.
    planner: Arc<Mutex<MoveItPlanner>>,
    places: Arc<Semaphore>,
    /// Flag that ends the server.
    stop: Arc<AtomicBool>,
}

impl Served {
    async fn answer(&self, call: Call) -> Reply {
        match (call.method(), call.path()) {
            (&Method::GET | &Method::HEAD, "/") => Reply::json(StatusCode::OK, &self.description),
            (&Method::POST, "/plan") => self.plan(call).await.unwrap_or_else(|refusal| refusal),
            (_, "/" | "/plan") => {
                Reply::refused(StatusCode::METHOD_NOT_ALLOWED, "GET the address itself, POST plan below it")
            }
            _ => Reply::refused(StatusCode::NOT_FOUND, "there is only plan (POST) below this address"),
        }
    }

    /// Plans a request in a thread of its own, which is stopped if the client disconnects.
    async fn plan(&self, call: Call) -> Result<Reply, Reply> {
        let Ok(place) = self.places.clone().try_acquire_owned() else {
            let error = format!("{MOST_WAITING} requests are being planned or wait; try again later");
            return Err(Reply::refused(StatusCode::SERVICE_UNAVAILABLE, error));
        };
        let content = call.content(MOST_BODY_BYTES).await?;
        let malformed = |error: String| Reply::refused(StatusCode::BAD_REQUEST, error);
        let text =
            String::from_utf8(content.into()).map_err(|fault| malformed(format!("request: {fault}")))?;
        let mut planner = self.planner.clone().lock_owned().await;
        let given_up = Arc::new(AtomicBool::new(false));
        let _guard = SetWhenDropped(given_up.clone());
        let mut observer = Stoppable([self.stop.clone(), given_up]);
        let (sender, receiver) = oneshot::channel();
        std::thread::spawn(move || {
            let planned = moveit_document(&text)
                .map_err(RecordError::from)
                .and_then(|document| planner.plan(document, &mut observer))
                .map_err(|fault| cranny_file::visible_line(&fault.to_string()));
            let _ = sender.send(planned);
            // The next request begins only now, even if the client of this one has disconnected.
            drop((planner, place));
        });
        match receiver.await {
            Ok(Ok(response)) => Ok(Reply::json(StatusCode::OK, &response)),
            Ok(Err(fault)) => Err(malformed(fault)),
            Err(_) => {
                let error = "the planner has crashed; its message is on standard error of the server";
                Err(Reply::refused(StatusCode::INTERNAL_SERVER_ERROR, error))
            }
        }
    }
}

/// Flag that is set at the end of its scope, also where a future is dropped.
struct SetWhenDropped(Arc<AtomicBool>);

impl Drop for SetWhenDropped {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Observer that stops a search once a flag is set.
struct Stoppable([Arc<AtomicBool>; 2]);

impl Observer for Stoppable {
    fn should_stop(&self) -> bool {
        self.0.iter().any(|flag| flag.load(Ordering::Relaxed))
    }
}
