use cranny_robot::LaneKinematics;
use cranny_shape::Ball;
use cranny_spatial::{Point, Vector};

use crate::cell::Cell;

impl Cell {
    /// Returns for each link the bounding balls that the lanes use, in the frame of the link: their union contains the link.
    /// Empty for a link without geometry.
    pub fn link_balls(&self) -> Vec<Vec<Ball>> {
        let kinematics = LaneKinematics::new(self.robot());
        let mut by_link = vec![Vec::new(); self.robot().links().len()];
        for (body, lane_body) in self.bodies.iter().zip(self.lanes.bodies.iter()) {
            let link_from_frame = kinematics.placement(body.link).frame_from_link.inverse();
            let leaves = lane_body.outer.iter().filter(|node| node.children == [0; 2]);
            let placed = leaves.map(|node| {
                let [x, y, z] = node.ball.center.map(f64::from);
                let center = link_from_frame * Point::from(Vector::new(x, y, z));
                Ball { center, radius_m: f64::from(node.ball.radius) }
            });
            by_link[body.link] = placed.collect();
        }
        by_link
    }
}
