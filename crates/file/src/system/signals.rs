/// Returns the numbers of the signals by which a user stops a program: Ctrl-C, SIGTERM and, where it is not ignored as under
/// `nohup`, SIGHUP (Unix; whether it is ignored is known on Linux).
pub fn stop_signals() -> Vec<i32> {
    const INTERRUPT: i32 = 2;
    const HANGUP: i32 = 1;
    const TERMINATION: i32 = 15;
    let mut signals = vec![INTERRUPT, TERMINATION];
    if cfg!(unix) && !is_ignored(HANGUP) {
        signals.push(HANGUP);
    }
    signals
}

/// Returns true if this process ignores a signal (proc(5), `SigIgn`).
fn is_ignored(signal: i32) -> bool {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else { return false };
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or_default();
    mask >> (signal - 1) & 1 == 1
}
