use std::any::Any;
use std::fmt;
use std::sync::{Arc, OnceLock};

/// Cache of one value that a dependent crate derives from a robot. A clone starts empty, as it may be modified.
#[derive(Default)]
pub(crate) struct Derived(pub OnceLock<Arc<dyn Any + Send + Sync>>);

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

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use crate::{Robot, RobotOptions};

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
        // The cache stores one value.
        assert_eq!(*robot.derived(|robot| robot.name().to_owned()), "r");
        assert_eq!((*dof(&robot), times.get()), (1, 2));
    }
}
