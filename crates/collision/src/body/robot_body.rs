use std::sync::{Arc, Mutex, PoisonError};

use cranny_robot::{LaneKinematics, Robot};
use cranny_shape::Ball;

use crate::body::link_body::LinkBody;
use crate::lane::lane_body::LaneBody;
use crate::pair::pairs::{Other, Pair};
use crate::pair::self_pairs::SelfPairs;
use crate::proof::joint_table::JointTable;
use crate::proof::link_sweep::swept_ball;

/// Data of a robot for the checks in any world: computed once per robot, and cached with it.
#[derive(Debug)]
pub(crate) struct RobotBody {
    /// Links with geometry.
    pub links: Arc<[LinkBody]>,
    /// For each of these links, a ball in the root frame that the link never leaves.
    pub swept: Vec<Option<Ball>>,
    /// Pairs of these links, compared or exempt.
    pub self_pairs: SelfPairs,
    pub kinematics: Arc<LaneKinematics>,
    /// Links in lane form.
    pub lanes: Arc<[LaneBody]>,
    tables: Arc<Mutex<Vec<KnownTables>>>,
}

/// Key of the tables of one robot: the pairs, each with the bits of its demanded distance.
type TableKey = Vec<(usize, usize, u64)>;

type KnownTables = (TableKey, Arc<[JointTable]>);

/// Maximum number of cached sets of tables: a robot is used with only a few different margins.
const MOST_TABLES: usize = 8;

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
                tables: Arc::default(),
            }
        })
    }

    /// Returns the data of this robot with an object of these solids in its hand ([`Robot::holding`]).
    pub fn holding(&self, robot: &Robot, held: LinkBody) -> Self {
        let links: Arc<[LinkBody]> = self.links.iter().cloned().chain([held]).collect();
        let kinematics = LaneKinematics::new(robot);
        let lane_body = |(index, link): (usize, &LinkBody)| match self.lanes.get(index) {
            Some(known) if !robot.is_loose(link.link) => known.clone(),
            _ => LaneBody::new(&kinematics, link),
        };
        let swept = |(index, link): (usize, &LinkBody)| {
            // The pose of a held link is not known here.
            if robot.is_loose(link.link) { None } else { self.swept[index] }
        };
        Self {
            swept: links.iter().enumerate().map(swept).collect(),
            self_pairs: self.self_pairs.with_held(robot, &links),
            lanes: links.iter().enumerate().map(lane_body).collect(),
            kinematics: Arc::new(kinematics),
            links,
            tables: self.tables.clone(),
        }
    }

    /// Returns the tables of these pairs of links, numbered from the first pair. No table covers the held object. With a held
    /// object, the tables of the empty hand are not used for fingers, because their opening is not known here.
    pub fn tables(&self, robot: &Robot, pairs: &[Pair]) -> Vec<JointTable> {
        let links = |pair: &Pair| match pair.second {
            Other::Link { body, .. } => [pair.first, body].map(|body| self.links[body].link),
            Other::Part(_) => [self.links[pair.first].link; 2],
        };
        let is_of_held = |pair: &Pair| links(pair).iter().any(|link| robot.held_link() == Some(*link));
        // The pairs of the held object come last.
        let own = &pairs[..pairs.iter().position(is_of_held).unwrap_or(pairs.len())];
        let key: TableKey = own
            .iter()
            .map(|pair| {
                let [first, second] = links(pair);
                (first, second, pair.required_m.to_bits())
            })
            .collect();
        // A panic in another thread leaves only complete tables.
        let mut known = self.tables.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known.iter().find(|(other, _)| *other == key).map(|(_, found)| found.clone());
        let found = found.unwrap_or_else(|| {
            let found: Arc<[JointTable]> = JointTable::all(robot, &self.links, own).into();
            if known.len() == MOST_TABLES {
                known.remove(0);
            }
            known.push((key, found.clone()));
            found
        });
        let is_rigid = |pair: u32| !links(&own[pair as usize]).iter().any(|link| robot.is_loose(*link));
        found.iter().map(|table| table.asked_about(is_rigid)).collect()
    }
}
