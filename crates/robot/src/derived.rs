use std::any::Any;
use std::fmt;
use std::sync::{Arc, OnceLock};

use crate::Robot;

/// What a room above has worked out of a robot. A clone begins without it: it may become another robot.
#[derive(Default)]
pub(crate) struct Derived(OnceLock<Arc<dyn Any + Send + Sync>>);

impl Clone for Derived {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl fmt::Debug for Derived {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.get().is_some() { "Derived(known)" } else { "Derived(unknown)" })
    }
}

impl Robot {
    /// What `work_out` makes of this robot, worked out once as long as the robot lives. There is room for one such
    /// thing, of the type that is asked for first; others are worked out every time.
    pub fn derived<T: Any + Send + Sync>(&self, work_out: impl FnOnce(&Self) -> T) -> Arc<T> {
        let mut work_out = Some(work_out);
        let known = self.derived.0.get_or_init(|| match work_out.take() {
            Some(work_out) => Arc::new(work_out(self)),
            None => Arc::new(()),
        });
        match (known.clone().downcast::<T>(), work_out) {
            (Ok(known), _) => known,
            (Err(_), Some(work_out)) => Arc::new(work_out(self)),
            (Err(_), None) => unreachable!("what was worked out is of the type that was asked for"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::RobotOptions;

    #[test]
    fn one_thing_is_worked_out_once_a_robot() {
        let urdf = r#"<robot name="r"><link name="a"/><link name="b"/>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><limit velocity="1" effort="1"/></joint></robot>"#;
        let robot =
            Robot::from_urdf_text(urdf, "r.urdf", None, &RobotOptions::default()).expect("a good URDF");
        let times = Cell::new(0);
        let dof = |robot: &Robot| {
            robot.derived(|robot| {
                times.set(times.get() + 1);
                robot.dof()
            })
        };
        assert_eq!((*dof(&robot), *dof(&robot), times.get()), (1, 1, 1));
        assert_eq!((*dof(&robot.clone()), times.get()), (1, 2));
        // There is room for one thing.
        assert_eq!(*robot.derived(|robot| robot.name().to_owned()), "r");
        assert_eq!((*dof(&robot), times.get()), (1, 2));
    }
}
