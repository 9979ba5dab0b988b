use cranny_plan::Problem;

/// At most so many reasons are listed.
const MOST: usize = 8;

/// Why the start of a problem is not free, a line each; nothing if it is.
pub fn faults(problem: &Problem) -> Vec<String> {
    if problem.start_is_free() {
        return Vec::new();
    }
    let faults = problem.configuration_faults(problem.start());
    let mut lines: Vec<String> = faults.iter().take(MOST).map(ToString::to_string).collect();
    if faults.len() > MOST {
        lines.push(format!("and {} more", faults.len() - MOST));
    }
    lines
}
