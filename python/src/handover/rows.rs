//! Batches of rows: without the GIL, on one core or several, interruptible by Ctrl-C.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use pyo3::prelude::*;

use crate::handover::array::Configurations;
use crate::handover::interrupt::Interrupt;

/// Computes `count` rows of `width` values each, in blocks of `block` rows, in an order that does not depend on the number of
/// `threads` (`None`: all cores). Each thread allocates its scratch with `scratch`; `work` fills the rows of a range.
///
/// # Errors
/// Exception of a signal handler; the computed rows are then discarded.
pub fn computed<T: Clone + Default + Send, S>(
    py: Python<'_>,
    (count, width): (usize, usize),
    block: usize,
    threads: Option<usize>,
    scratch: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, Range<usize>, &mut [T]) + Sync,
) -> PyResult<Vec<T>> {
    let threads = threads.unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from));
    let mut interrupt = Interrupt::new();
    let stop = AtomicBool::new(false);
    let values = py.detach(|| {
        let mut values = vec![T::default(); count * width];
        let blocks = Mutex::new(values.chunks_mut((block * width).max(1)).enumerate());
        let serve = |mut interrupt: Option<&mut Interrupt>| {
            let mut room = scratch();
            while !stop.load(Ordering::Relaxed) {
                let next = blocks.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some((index, part)) = next else { break };
                work(&mut room, index * block..(index * block + part.len() / width.max(1)), part);
                if interrupt.as_deref_mut().is_some_and(Interrupt::asks) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        };
        let helpers = threads.min(count.div_ceil(block.max(1))).saturating_sub(1);
        thread::scope(|scope| {
            for _ in 0..helpers {
                // If the system refuses a thread, the other threads take its blocks.
                let _ = thread::Builder::new().spawn_scoped(scope, || serve(None));
            }
            serve(Some(&mut interrupt));
        });
        values
    });
    interrupt.result().map(|()| values)
}

impl Configurations<'_> {
    /// Computes `width` values for each configuration, as [`computed`]; `work` fills those of one.
    pub fn computed<T: Clone + Default + Send, S>(
        &self,
        py: Python<'_>,
        width: usize,
        block: usize,
        threads: Option<usize>,
        scratch: impl Fn() -> S + Sync,
        work: impl Fn(&mut S, &[f64], &mut [T]) + Sync,
    ) -> PyResult<Vec<T>> {
        let (values, dof) = (self.values()?, self.dof);
        computed(py, (self.count, width), block, threads, scratch, |scratch, range, out| {
            let rows = values[range.start * dof..range.end * dof].chunks_exact(dof);
            rows.zip(out.chunks_exact_mut(width)).for_each(|(q, out)| work(scratch, q, out));
        })
    }
}
