//! Generates a family of problems like those of `MotionBenchMaker` in which the Panda reaches under a table:
//! `cargo run --release -p cranny-measure --bin under_table -- DATA FOLDER [COUNT]`
//!
//! DATA contains `panda_spherized.urdf` and `panda.srdf`. FOLDER gets copies of both and `under_table_panda` with COUNT (100)
//! scenes and requests, which `motion_bench` and `path_quality` read. The table stands in front of the arm: a top, four legs,
//! up to three boxes below it and two on it. The goal is a random free configuration with the hand well below the top.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use cranny_collision::Margins;
use cranny_scenario::{MoveItOptions, MoveItProblem};
use cranny_spatial::Stream;
use cranny_task::Problem;

/// Start configuration of the arms in `MotionBenchMaker` (rad), and the position of their fingers in metres.
const START: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
const FINGER_M: f64 = 0.065;

/// Maximum number of configurations drawn for a goal before another table is drawn.
const DRAWS: usize = 20_000;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [data, folder, rest @ ..] = &words[..] else { return Err("DATA FOLDER [COUNT]".into()) };
    let count: usize = rest.first().map_or(Ok(100), |word| word.parse())?;
    let (data, folder) = (Path::new(data), Path::new(folder));
    let family = folder.join("under_table_panda");
    fs::create_dir_all(&family)?;
    for file in ["panda_spherized.urdf", "panda.srdf"] {
        fs::copy(data.join(file), folder.join(file))?;
    }
    let mut random = Stream::new(0, 0);
    let mut made = 0;
    while made < count {
        let [scene, request] =
            ["scene", "request"].map(|what| family.join(format!("{what}{:04}.yaml", made + 1)));
        let table = Table::draw(&mut random);
        fs::write(&scene, table.scene(&mut random))?;
        fs::write(&request, request_to(&START))?;
        let opened = MoveItProblem::open(&scene, &request, &MoveItOptions::default())?;
        let goal = table.goal(&opened.problem(Margins::default())?, &mut random);
        if let Some(goal) = goal {
            fs::write(&request, request_to(&goal))?;
            made += 1;
        }
    }
    Ok(())
}

/// Dimensions of a table in front of the arm, in metres.
struct Table {
    /// Position of its near edge (x), and of its centre across (y).
    near: f64,
    aside: f64,
    depth: f64,
    width: f64,
    /// Height and thickness of the top.
    height: f64,
    thickness: f64,
}

impl Table {
    fn draw(random: &mut Stream) -> Self {
        let mut between = |low, high| random.uniform_between(low, high);
        Self {
            near: between(0.25, 0.45),
            aside: between(-0.2, 0.2),
            depth: between(0.6, 1.0),
            width: between(0.8, 1.4),
            height: between(0.4, 0.7),
            thickness: between(0.02, 0.06),
        }
    }

    /// Returns a free configuration with the hand below the top, if one is found and the start is free.
    fn goal(&self, problem: &Problem, random: &mut Stream) -> Option<Vec<f64>> {
        let (cell, robot) = (problem.cell()?, problem.robot());
        let mut scratch = cell.scratch();
        if !cell.is_free(&START, &mut scratch) {
            return None;
        }
        let is_below = |q: &Vec<f64>| {
            let hand = robot.frames_at(q).link(robot.tip()).translation.vector;
            let (along, across) = (hand.x - self.near, (hand.y - self.aside).abs());
            (0.1..self.depth).contains(&along)
                && across < 0.5 * self.width - 0.1
                && (0.05..self.height - self.thickness - 0.08).contains(&hand.z)
        };
        (0..DRAWS)
            .map(|_| robot.random_configuration(random))
            .find(|q| is_below(q) && cell.is_free(q, &mut scratch))
    }

    fn scene(&self, random: &mut Stream) -> String {
        /// Half the thickness of a leg.
        const LEG: f64 = 0.025;
        let mut boxes = Vec::new();
        let middle = self.near + 0.5 * self.depth;
        let top = self.height - 0.5 * self.thickness;
        boxes.push(([middle, self.aside, top], [self.depth, self.width, self.thickness]));
        let under = self.height - self.thickness;
        for (x, y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let corner = [0.5 * self.depth - LEG, 0.5 * self.width - LEG];
            let place = [middle + x * corner[0], self.aside + y * corner[1], 0.5 * under];
            boxes.push((place, [2.0 * LEG, 2.0 * LEG, under]));
        }
        for (most, floor) in [(3.0, 0.0), (2.0, self.height)] {
            let mut left = random.uniform() * (most + 1.0);
            while left >= 1.0 {
                left -= 1.0;
                let size: [f64; 3] = std::array::from_fn(|_| random.uniform_between(0.06, 0.2));
                let x = middle + random.uniform_between(-0.4, 0.4) * self.depth;
                let y = self.aside + random.uniform_between(-0.4, 0.4) * self.width;
                boxes.push(([x, y, floor + 0.5 * size[2]], size));
            }
        }
        let mut text = "robot_model_name: panda\nworld:\n  collision_objects:\n".to_owned();
        for (index, (place, size)) in boxes.iter().enumerate() {
            let _ = write!(
                text,
                "    - id: box{index}\n      primitives:\n        - {{type: box, dimensions: {size:?}}}\n      \
                 primitive_poses:\n        - {{position: {place:?}, orientation: [0, 0, 0, 1]}}\n"
            );
        }
        text
    }
}

fn request_to(goal: &[f64]) -> String {
    let joints: Vec<String> = (1..=7).map(|joint| format!("panda_joint{joint}")).collect();
    let fingers = [FINGER_M; 2];
    let mut text = format!(
        "group_name: panda_arm\nstart_state:\n  joint_state:\n    name: [{}, panda_finger_joint1, panda_finger_joint2]\n    \
         position: {:?}\ngoal_constraints:\n  - joint_constraints:\n",
        joints.join(", "),
        [&START[..], &fingers].concat(),
    );
    for (joint, position) in joints.iter().zip(goal) {
        let _ = writeln!(text, "      - {{joint_name: {joint}, position: {position:?}}}");
    }
    text
}
