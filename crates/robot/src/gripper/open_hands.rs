use crate::chain::joint_group::{named_group, range};
use crate::description::options::RobotOptions;
use crate::description::robot_description::RobotDescription;
use crate::description::srdf::Srdf;
use crate::description::text_source::parsed;
use crate::description::urdf_model::Urdf;
use crate::error::RobotError;
use crate::gripper::hand_description::HandDescription;
use crate::tree::Tree;

impl RobotOptions {
    /// Returns these options with the robot's own hand as the first known hand, or without known hands for a robot with a tool;
    /// fingers are open, and the gripper frame is the tip, as far as the robot has those joints and links and the options do not set them.
    pub(crate) fn with_open_hands(
        &self,
        urdf: &Urdf,
        tree: &Tree,
        srdf: Option<&Srdf>,
    ) -> Result<(Self, Option<RobotDescription>), RobotError> {
        let mut options = self.clone();
        let motion = |finger: &str| urdf.joints[tree.joint(finger)?].motion.as_ref();
        let limits = |finger: &str| motion(finger).map_or((f64::MIN, f64::MAX), range);
        let own = parsed(self.description.as_ref(), |text, file| {
            let own = RobotDescription::parse(text, file)?;
            own.check_names((text, file), urdf, tree)?;
            own.hand.iter().try_for_each(|hand| hand.check_fingers(text, file, limits))?;
            Ok(own)
        })?;
        if let Some(own) = &own {
            own.complete(&mut options);
        }
        if let Some(own) = own.as_ref().and_then(|own| own.hand.clone()) {
            options.known_hands.insert(0, own);
        }
        if let Some(tool) = own.as_ref().and_then(|own| own.tool.as_ref()) {
            options.tip = options.tip.or_else(|| tool.tip.clone());
            options.known_hands.clear();
        }
        // A finger's joint in the group is not fixed; one that mimics another follows it.
        let group = named_group(urdf, tree, srdf, &options)?;
        let is_held = |finger: &String| {
            let mimics = motion(finger).is_some_and(|motion| motion.mimic.is_some());
            tree.joint(finger).is_some_and(|joint| !group.contains(&joint)) && !mimics
        };
        for HandDescription { tip, fingers, .. } in &options.known_hands {
            options.tip = options.tip.or_else(|| tip.clone().filter(|tip| tree.node(tip).is_some()));
            for (finger, range) in fingers.iter().filter(|(finger, _)| is_held(finger)) {
                options.fixed.entry(finger.clone()).or_insert(range.open);
            }
        }
        Ok((options, own))
    }
}
