use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use cranny_plan::Observer;
use cranny_scenario::exit_without_temporaries;
use indicatif::{ProgressBar, ProgressStyle};

/// Minimum duration of work for which progress is shown.
const PATIENCE: Duration = Duration::from_secs(1);

/// Interval at which the flag is checked.
const CHECK_EVERY: Duration = Duration::from_millis(20);

/// Flag that Ctrl-C, SIGTERM and SIGHUP set.
static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// True once a command ends by itself after a signal.
static IS_HANDLED: AtomicBool = AtomicBool::new(false);

/// Lets Ctrl-C, SIGTERM and SIGHUP end the program with exit code 1 and without its temporary files, until a command takes
/// over by [`stop_on_interrupt`]. SIGHUP stays ignored under `nohup` (Linux).
pub fn end_on_interrupt() {
    for signal in cranny_file::system::stop_signals() {
        // Without a handler, the signal ends the program at once.
        let _ = signal_hook::flag::register(signal, STOP.clone());
    }
    std::thread::spawn(|| {
        while !IS_HANDLED.load(Ordering::Relaxed) {
            if STOP.load(Ordering::Relaxed) {
                // If stderr cannot be written, the exit code still reports the end.
                let _ = writeln!(std::io::stderr(), "stopped");
                exit_without_temporaries(1)
            }
            std::thread::sleep(CHECK_EVERY);
        }
    });
}

/// Returns when no signal has come; after one, waits until it ends the program.
pub fn await_end() {
    while STOP.load(Ordering::Relaxed) && !IS_HANDLED.load(Ordering::Relaxed) {
        std::thread::sleep(CHECK_EVERY);
    }
}

/// Returns the flag that Ctrl-C, SIGTERM and SIGHUP set, for a command that ends by itself and keeps what it has finished.
pub fn stop_on_interrupt() -> Arc<AtomicBool> {
    IS_HANDLED.store(true, Ordering::Relaxed);
    STOP.clone()
}

/// Completes when the flag is set.
pub async fn interrupted(stop: Arc<AtomicBool>) {
    while !stop.load(Ordering::Relaxed) {
        tokio::time::sleep(CHECK_EVERY).await;
    }
}

/// Runs work that reports no progress and returns its result; `None` if the flag is set first: the work is then abandoned.
pub fn unless_stopped<T: Send + 'static>(
    stop: &AtomicBool,
    work: impl FnOnce() -> T + Send + 'static,
) -> Option<T> {
    let working = std::thread::spawn(work);
    while !working.is_finished() {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Some(working.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
}

/// Returns a progress bar over `total` items, hidden if `quiet` or if standard error is no terminal.
pub fn bar(total: u64, quiet: bool) -> ProgressBar {
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(total) };
    bar.set_style(style("{bar:30} {pos}/{len} {msg} {elapsed} (about {eta} left)"));
    bar
}

/// Returns a spinner with a message, for work of unknown duration.
pub fn spinner(message: &'static str, quiet: bool) -> ProgressBar {
    let spinner = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    spinner.set_style(style("{spinner} {msg}, {elapsed}"));
    spinner.set_message(message);
    spinner.enable_steady_tick(PATIENCE / 4);
    spinner
}

/// Observer that shows the progress of a search after one second, and stops it on Ctrl-C.
pub struct SearchProgress {
    spinner: ProgressBar,
    begin: Instant,
    stop: Arc<AtomicBool>,
}

impl SearchProgress {
    /// Creates the progress of a search that the flag stops.
    pub fn new(quiet: bool, stop: Arc<AtomicBool>) -> Self {
        let spinner = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        spinner.set_style(style("{spinner} searching: {pos} iterations, {elapsed}  (Ctrl-C stops)"));
        Self { spinner, begin: Instant::now(), stop }
    }

    pub fn finish(&self) {
        self.spinner.finish_and_clear();
    }
}

impl Observer for SearchProgress {
    fn progress(&mut self, iterations: u64) {
        if self.begin.elapsed() > PATIENCE {
            self.spinner.set_position(iterations);
        }
    }

    fn should_stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
