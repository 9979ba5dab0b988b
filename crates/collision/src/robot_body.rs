use std::sync::{Arc, Mutex, PoisonError};

use cranny_robot::{LaneKinematics, Robot};
use cranny_shape::Ball;

use crate::joint_table::JointTable;
use crate::lane_body::LaneBody;
use crate::link_body::LinkBody;
use crate::link_sweep::swept_ball;
use crate::pairs::{Other, Pair};
use crate::self_pairs::SelfPairs;

/// What every check needs of a robot, in whatever world it stands: worked out once a robot, and kept with it.
#[derive(Debug)]
pub(crate) struct RobotBody {
    /// The links with geometry.
    pub links: Arc<[LinkBody]>,
    /// For each of them where it can be at all.
    pub swept: Vec<Option<Ball>>,
    /// Which of them are compared with which.
    pub self_pairs: SelfPairs,
    pub kinematics: Arc<LaneKinematics>,
    /// The links as the lanes see them.
    pub lanes: Arc<[LaneBody]>,
    tables: Mutex<Vec<(TableKey, Arc<[JointTable]>)>>,
}

/// What tables depend on beside the robot: the pairs, and the bits of the distance that each demands.
type TableKey = Vec<(usize, usize, u64)>;

/// More sets of tables are not kept: a robot is asked with a few margins.
const MOST_TABLES: usize = 4;

impl RobotBody {
    pub fn of(robot: &Robot) -> Arc<Self> {
        robot.derived(|robot| {
            let links: Arc<[LinkBody]> = LinkBody::all(robot).into();
            let kinematics = LaneKinematics::new(robot);
            Self {
                swept: links.iter().map(|link| swept_ball(robot, link)).collect(),
                self_pairs: SelfPairs::of(robot, &links),
                lanes: links.iter().map(|link| LaneBody::new(&kinematics, link)).collect(),
                kinematics: Arc::new(kinematics),
                links,
                tables: Mutex::default(),
            }
        })
    }

    /// The tables of these pairs of links, their pairs counted from the first.
    pub fn tables(&self, robot: &Robot, pairs: &[Pair]) -> Arc<[JointTable]> {
        let of_pair = |pair: &Pair| match pair.second {
            Other::Link { body, .. } => Some((pair.first, body, pair.required_m.to_bits())),
            Other::Part(_) => None,
        };
        let key: TableKey = pairs.iter().filter_map(of_pair).collect();
        // A thread that panicked left what was finished.
        let mut known = self.tables.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, tables)) = known.iter().find(|(other, _)| *other == key) {
            return tables.clone();
        }
        let tables: Arc<[JointTable]> = JointTable::all(robot, &self.links, pairs).into();
        if known.len() == MOST_TABLES {
            known.remove(0);
        }
        known.push((key, tables.clone()));
        tables
    }
}
