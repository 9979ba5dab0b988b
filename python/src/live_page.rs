//! `LivePage`: the viewer in a browser, controlled from a script.

use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread::JoinHandle;

use cranny_view::{PageFeed, PageServer, ServerLimits, TreeRecording, ViewError, WatchedSearch};
use pyo3::prelude::*;
use tokio::sync::oneshot;

use crate::classes::{PyPlan, PyScenario, Task};
use crate::handover::array::configuration;
use crate::handover::fault::{bad_value, fault};
use crate::picture::page_of;

/// Viewer page of a scenario, served to this machine until it is closed (`close`, `with`, or when it is garbage-collected).
/// Browsers that have opened `url` show the effects of `pose` and `plan` at once.
#[pyclass(name = "LivePage", module = "cranny", frozen)]
pub struct PyLivePage {
    scenario: Arc<Py<PyScenario>>,
    feed: PageFeed,
    url: String,
    server: Mutex<Option<Server>>,
}

struct Server {
    stop: oneshot::Sender<()>,
    thread: JoinHandle<Result<(), ViewError>>,
}

#[pymethods]
impl PyLivePage {
    #[new]
    #[pyo3(signature = (scenario, plan=None, *, port=0))]
    fn new(
        py: Python<'_>,
        scenario: Py<PyScenario>,
        plan: Option<&Bound<'_, PyPlan>>,
        port: u16,
    ) -> PyResult<Self> {
        let (shown, plan) = (scenario.get(), plan.map(Bound::get));
        let (page, cells) = py.detach(|| page_of(shown, plan, None))?;
        PageServer::check_page().map_err(fault)?;
        let feed = PageFeed::new(&page, true).map_err(fault)?;
        let server = PageServer::bind(port, ServerLimits::default()).map_err(fault)?;
        let url = server.url();
        let (stop, told) = oneshot::channel();
        let (tell_ready, ready) = mpsc::channel();
        let of_thread = feed.clone();
        let thread = std::thread::spawn(move || {
            let stopped = async {
                let _ = told.await;
            };
            server.serve_feed(of_thread, Some(cells), stopped, || {
                let _ = tell_ready.send(());
            })
        });
        // If the server cannot start, its thread ends, and `close` reports the reason.
        let _ = py.detach(move || ready.recv());
        Ok(Self {
            scenario: Arc::new(scenario),
            feed,
            url,
            server: Mutex::new(Some(Server { stop, thread })),
        })
    }

    /// Address of the page; any user of this machine who knows it can read the page.
    #[getter]
    fn url(&self) -> &str {
        &self.url
    }

    /// Shows the robot at a configuration (dof,), m or rad; None: as in the plan.
    #[pyo3(signature = (q))]
    fn pose(&self, q: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        self.check_open()?;
        let robot = &self.scenario.get().scenario.robot;
        let q = q.map(|q| configuration(q, "q", robot)).transpose()?;
        self.feed.pose(q);
        Ok(())
    }

    /// Shows a plan; None: the scenario alone. Configurations are still checked against the initial scene of the page.
    #[pyo3(signature = (plan))]
    fn plan(&self, py: Python<'_>, plan: Option<&Bound<'_, PyPlan>>) -> PyResult<()> {
        self.check_open()?;
        let (scenario, plan) = (self.scenario.get(), plan.map(Bound::get));
        py.detach(|| {
            let (page, _) = page_of(scenario, plan, None)?;
            self.feed.show(&page, true).map_err(fault)
        })
    }

    /// Stops the server; the open page remains visible.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let server = self.server.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(Server { stop, thread }) = server else { return Ok(()) };
        let _ = stop.send(());
        match py.detach(|| thread.join()) {
            Ok(ended) => ended.map_err(fault),
            Err(_) => Err(bad_value("the server of the page has crashed")),
        }
    }

    fn __enter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __exit__(
        &self,
        py: Python<'_>,
        _kind: &Bound<'_, PyAny>,
        _value: &Bound<'_, PyAny>,
        _trace: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        self.close(py)
    }

    fn __repr__(&self) -> String {
        format!("<cranny.LivePage of '{}'>", self.scenario.get().scenario.id)
    }
}

impl PyLivePage {
    /// Observes the search for a task, so that the page shows the growth of its trees.
    pub fn watch(&self, task: &Task) -> PyResult<WatchedSearch> {
        self.check_open()?;
        let (shown, robot) = (&self.scenario.get().scenario, task.problem.robot());
        if shown.robot.joint_names() != robot.joint_names() {
            return Err(bad_value(format!(
                "watch: the page shows '{}', whose robot has other joints than that of '{}'",
                shown.id, task.source.scenario
            )));
        }
        Ok(self.feed.watch(robot.clone()))
    }

    /// Shows the plan that a search returned, with its trees; does nothing if the page was closed in the meantime.
    pub fn show_with_tree(&self, plan: &PyPlan, search_tree: TreeRecording) -> PyResult<()> {
        if self.check_open().is_err() {
            return Ok(());
        }
        let (page, _) = page_of(self.scenario.get(), Some(plan), Some(search_tree))?;
        self.feed.show(&page, true).map_err(fault)
    }

    fn check_open(&self) -> PyResult<()> {
        let is_open = self.server.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        if is_open { Ok(()) } else { Err(bad_value("this page is closed")) }
    }
}
