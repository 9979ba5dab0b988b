//! Temporary.
use cranny_scenario::{GivenGrasps, OpenOptions, Scenario, brief_model_notes};
use std::time::Instant;
fn main() {
    let id = std::env::args().nth(1).unwrap();
    let t = Instant::now();
    let s =
        Scenario::open(&id, &OpenOptions { grasps: GivenGrasps::None, ..OpenOptions::default() }).unwrap();
    eprintln!("open {:?}", t.elapsed());
    let t = Instant::now();
    let n = brief_model_notes(&s.robot, &s.world).len();
    eprintln!("notes {n} {:?}", t.elapsed());
    let t = Instant::now();
    let m = s.misplaced_grasps().is_some();
    eprintln!("misplaced {m} {:?}", t.elapsed());
    let t = Instant::now();
    let p = s.problem(cranny_collision::Margins::default()).unwrap();
    eprintln!("problem {} {:?}", p.robot().dof(), t.elapsed());
}
