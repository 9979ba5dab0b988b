//! Ctrl-C, while the interpreter is free for others.

use std::cell::RefCell;
use std::time::{Duration, Instant};

use cranny_plan::Observer;
use pyo3::{PyErr, PyResult, Python};

/// So often a signal is looked for: sooner than a person notices, too seldom to cost a search anything.
const LOOK_EVERY: Duration = Duration::from_millis(30);

/// Looks for signals from time to time, and keeps the exception that one raised.
#[derive(Debug)]
pub struct Interrupt {
    looked: Instant,
    raised: Option<PyErr>,
}

impl Interrupt {
    pub fn new() -> Self {
        Self { looked: Instant::now(), raised: None }
    }

    /// Whether to stop: a signal handler of Python has raised something. Called without the interpreter held.
    pub fn asks(&mut self) -> bool {
        if self.raised.is_none() && self.looked.elapsed() >= LOOK_EVERY {
            self.looked = Instant::now();
            #[allow(
                clippy::redundant_closure_for_method_calls,
                reason = "the method is not general enough in its lifetime"
            )]
            let looked = Python::attach(|py| py.check_signals());
            self.raised = looked.err();
        }
        self.raised.is_some()
    }

    /// What was raised, as the result of whatever was stopped by it.
    pub fn result(self) -> PyResult<()> {
        self.raised.map_or(Ok(()), Err)
    }
}

/// Ends a search on Ctrl-C.
#[derive(Debug)]
pub struct InterruptObserver(RefCell<Interrupt>);

impl InterruptObserver {
    pub fn new() -> Self {
        Self(RefCell::new(Interrupt::new()))
    }

    pub fn result(self) -> PyResult<()> {
        self.0.into_inner().result()
    }
}

impl Observer for InterruptObserver {
    fn should_stop(&self) -> bool {
        self.0.borrow_mut().asks()
    }
}
