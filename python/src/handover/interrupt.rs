//! Interruption by Ctrl-C while the interpreter is released.

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use cranny_plan::Observer;
use pyo3::{PyErr, PyResult, Python};

use crate::handover::fault::fault;

/// Interval of the checks for signals: imperceptible to a user, and negligible for a search.
const LOOK_EVERY: Duration = Duration::from_millis(30);

/// Checks for signals from time to time, and keeps the exception that one raised.
#[derive(Debug)]
pub struct Interrupt {
    looked: Instant,
    raised: Option<PyErr>,
}

impl Interrupt {
    pub fn new() -> Self {
        Self { looked: Instant::now(), raised: None }
    }

    /// Returns true if a signal handler of Python has raised an exception. Called without the GIL.
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

    /// Returns the raised exception as an error.
    pub fn result(self) -> PyResult<()> {
        self.raised.map_or(Ok(()), Err)
    }
}

/// Runs `work` on the cores of the pool, while this thread checks for signals: Python runs their handlers in its main thread only.
/// `work` should end soon once the function that it is given returns true.
///
/// # Errors
/// Exception of a signal handler; the result is then discarded.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> T + Send,
) -> PyResult<T> {
    let (mut interrupt, stop) = (Interrupt::new(), AtomicBool::new(false));
    let is_stopped: &(dyn Fn() -> bool + Sync) = &|| stop.load(Ordering::Relaxed);
    let done = py.detach(|| {
        rayon::in_place_scope(|scope| {
            let (tell, told) = mpsc::channel();
            scope.spawn(move |_| {
                // The receiver waits for it.
                let _ = tell.send(work(is_stopped));
            });
            loop {
                match told.recv_timeout(LOOK_EVERY) {
                    Ok(done) => return Some(done),
                    Err(RecvTimeoutError::Timeout) => stop.store(interrupt.asks(), Ordering::Relaxed),
                    Err(RecvTimeoutError::Disconnected) => return None,
                }
            }
        })
    });
    interrupt.result()?;
    done.ok_or_else(|| fault("the work ended unexpectedly, which is a bug in Cranny; please report it"))
}

/// Observer that stops a search on Ctrl-C.
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
