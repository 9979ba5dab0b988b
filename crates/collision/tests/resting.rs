//! Tests that an object may touch its support faces, and nothing else.

use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use cranny_collision::{
    Body, CONTACT_ALLOWANCE_M, Cell, CollisionError, Margins, Part, Resting, UncheckedReason, World,
};
use cranny_robot::{Hold, Robot, RobotOptions};
use cranny_shape::{Solid, TriangleSoup};
use cranny_spatial::{Point, Pose, Vector};

const HALF_M: [f64; 3] = [0.03, 0.02, 0.04];

/// A cart that slides along x, y and z: its configuration is the displacement of the held object.
const CART: &str = r#"<robot name="cart">
  <link name="rail"/><link name="x"/><link name="y"/>
  <link name="tip"><collision><origin xyz="0 0 0.4"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="along" type="prismatic"><parent link="rail"/><child link="x"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="across" type="prismatic"><parent link="x"/><child link="y"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="up" type="prismatic"><parent link="y"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
</robot>"#;

fn block(name: &str, [x, y, z]: [f64; 3], half_m: [f64; 3]) -> Body {
    Body::new(name, Pose::translation(x, y, z), Solid::cuboid(half_m.into()).unwrap())
}

/// Creates a box of 6 × 4 × 8 cm with its lowest point at `height_m` (m) above the origin.
fn object(height_m: f64) -> Body {
    block("object", [0.0, 0.0, HALF_M[2] + height_m], HALF_M)
}

fn table() -> Body {
    block("table", [0.0, 0.0, -0.05], [0.3, 0.3, 0.05])
}

fn cell(bodies: Vec<Body>, margin_m: f64) -> Cell {
    let options = RobotOptions { tip: Some("tip".to_owned()), ..RobotOptions::default() };
    let robot = Robot::from_urdf_text(CART, "cart.urdf", None, &options).unwrap();
    let margins = Margins { margin_m, ..Margins::default() };
    Cell::new(Arc::new(robot), World::new(bodies).unwrap(), margins).unwrap()
}

/// Formats a length (m) in tenths of a millimetre.
fn tenths(length_m: f64) -> String {
    // Avoid a negative zero.
    ((length_m * 1e4).round() + 0.0).to_string()
}

/// Returns the names of the supports of the first of `bodies`, with its height above each in tenths of a millimetre.
fn carried(bodies: &[Body]) -> Result<Vec<(String, String)>, CollisionError> {
    let cell = cell(bodies.to_vec(), 0.0);
    let resting = cell.resting(0)?;
    Ok(resting.supports().map(|(body, height_m)| (bodies[body].name.clone(), tenths(height_m))).collect())
}

fn touches(bodies: &[Body]) -> (String, f64) {
    match carried(bodies) {
        Err(CollisionError::Touches { other, depth_m, .. }) => (other, depth_m),
        other => panic!("{other:?}"),
    }
}

/// Returns the cell in which the hand holds the object at its initial pose, with the contacts of its supports allowed.
fn lifting(cell: &Cell) -> (Cell, Resting) {
    let resting = cell.resting(0).unwrap();
    let first = cell.world().bodies()[0].parts[0].world_from_solid;
    let held = cell.holding(0, Hold { tip_from_held: first, closing: 0.0 }).unwrap();
    (held.with_allowed_contacts(&resting), resting)
}

/// Creates a tray of 20 cm with a lip of 3 cm, its floor at height 0, as one mesh.
fn tray() -> Body {
    let mut soup = TriangleSoup::default();
    let mut add = |place: [f64; 3], half_m: [f64; 3]| {
        let solid = Solid::cuboid(half_m.into()).unwrap();
        soup.append(&solid.tessellation().unwrap(), &Pose::translation(place[0], place[1], place[2]));
    };
    add([0.0, 0.0, -0.01], [0.1, 0.1, 0.01]);
    for side in [-1.0, 1.0] {
        add([side * 0.095, 0.0, 0.005], [0.005, 0.1, 0.025]);
        add([0.0, side * 0.095, 0.005], [0.1, 0.005, 0.025]);
    }
    Body::new("tray", Pose::identity(), Solid::mesh(&soup).unwrap())
}

fn moved(mut body: Body, by: &Pose) -> Body {
    for part in &mut body.parts {
        part.world_from_solid = by * part.world_from_solid;
    }
    body
}

#[test]
fn only_what_is_below_an_object_carries_it() {
    let on_table = [("table".to_owned(), tenths(0.0))];
    assert_eq!(carried(&[object(0.0), table()]).unwrap(), on_table);
    // A post and a curb beside the object, a block flush with the table, and a lid above the object.
    let post = block("post", [0.041, 0.0, 0.1], [0.01, 0.01, 0.1]);
    let curb = block("curb", [0.0, 0.0305, 0.005], [0.01, 0.01, 0.005]);
    let flush = block("flush", [0.0, -0.031, -0.01], [0.01, 0.01, 0.01]);
    let lid = block("lid", [0.0, 0.0, 0.0915], [0.05, 0.05, 0.01]);
    let bodies = [object(0.0), table(), post, curb, flush, lid];
    assert_eq!(carried(&bodies).unwrap(), on_table);
    // They are obstacles at their actual distance, for every margin.
    for (margin_m, near) in [(0.0, vec![]), (0.004, vec!["post", "curb", "flush", "lid"])] {
        let cell = cell(bodies.to_vec(), margin_m);
        let (lifting, resting) = lifting(&cell);
        let beside: Vec<&str> = resting.beside().map(|(body, ..)| &*bodies[body].name).collect();
        assert_eq!(beside, near);
        let contacts = lifting.contacts(&[0.0; 3], &mut lifting.scratch());
        assert_eq!(contacts.len(), near.len(), "{contacts:?}");
        let clearance_m = lifting.clearance(&[0.0; 3], &mut lifting.scratch());
        assert!((clearance_m - 0.5e-3).abs() < 1e-6, "{clearance_m}");
        let [exempt] = lifting.unchecked() else { panic!("{:?}", lifting.unchecked()) };
        assert_eq!((exempt.reason, lifting.name(exempt.second)), (UncheckedReason::Resting, "table"));
    }
}

#[test]
fn an_object_is_no_deeper_in_what_carries_it_than_the_allowance() {
    for (height_m, rests) in [(0.0019, true), (5e-5, true), (-0.9e-4, true), (-1.5e-4, false), (-8e-4, false)]
    {
        let bodies = [object(height_m), table()];
        if rests {
            assert_eq!(carried(&bodies).unwrap(), [("table".to_owned(), tenths(height_m))]);
            let (lifting, _) = lifting(&cell(bodies.to_vec(), 0.0));
            assert!((lifting.unchecked()[0].depth_m - (-height_m).max(0.0)).abs() < 1e-9);
        } else {
            let (other, depth_m) = touches(&bodies);
            assert_eq!(other, "table");
            assert!((depth_m + height_m).abs() < 1e-6, "{depth_m}");
        }
    }
    // If it is lowered from there by more than the allowance, it is not proven to stay off.
    let (lifting, resting) = lifting(&cell(vec![object(-0.9e-4), table()], 0.0));
    let mut scratch = lifting.scratch();
    let mut stays =
        |z: f64| lifting.first_support_violation(&resting, 1e-4, &[0.0; 3], &[0.0, 0.0, z], &mut scratch);
    assert_eq!(stays(0.01), None);
    assert_eq!(stays(-0.05 * CONTACT_ALLOWANCE_M), None);
    assert!(stays(-0.2 * CONTACT_ALLOWANCE_M).is_some());
}

#[test]
fn what_touches_an_object_at_its_side_does_not_carry_it() {
    let beside = block("beside", [0.04, 0.0, 0.04], [0.01, 0.02, 0.04]);
    assert_eq!(touches(&[object(0.0), table(), beside.clone()]).0, "beside");
    // The object touches the lip of a tray from inside.
    let in_tray = moved(object(0.0), &Pose::translation(0.0601, 0.0, 0.0));
    let (other, depth_m) = touches(&[in_tray, tray()]);
    assert_eq!((&*other, depth_m < 1.2e-4), ("tray", true));
}

#[test]
fn the_lip_of_a_tray_is_an_obstacle_and_its_floor_carries() {
    let at = |gap_m: f64| moved(object(0.0), &Pose::translation(0.06 - gap_m, 0.0, 0.0));
    assert_eq!(carried(&[at(0.0015), tray()]).unwrap(), [("tray".to_owned(), tenths(0.0))]);
    for (margin_m, is_free) in [(0.0, true), (0.001, true), (0.004, false)] {
        let (lifting, _) = lifting(&cell(vec![at(0.0015), tray()], margin_m));
        let mut scratch = lifting.scratch();
        assert_eq!(lifting.is_clear(&[0.0; 3], &mut scratch), is_free, "{margin_m}");
        assert!((lifting.clearance(&[0.0; 3], &mut scratch) - 0.0015).abs() < 1e-6);
        // The object slides into the lip, and above it.
        assert!(!lifting.is_clear(&[0.002, 0.0, 0.0], &mut scratch));
        assert!(lifting.is_clear(&[0.02, 0.0, 0.0351], &mut scratch));
    }
    // On the lip it is supported if its centre is over it.
    let on_lip = moved(object(0.03), &Pose::translation(0.095, 0.0, 0.0));
    assert_eq!(carried(&[on_lip, tray()]).unwrap(), [("tray".to_owned(), tenths(0.0))]);
    // Deep inside the lip it has no support.
    let sunk = moved(object(0.0), &Pose::translation(0.0608, 0.0, 0.0));
    assert_eq!(touches(&[sunk, tray()]).0, "tray");
}

#[test]
fn the_centre_of_mass_is_over_what_carries() {
    let beam = |name: &str, x: f64| block(name, [x, 0.0, -0.01], [0.005, 0.3, 0.01]);
    let both = [object(0.0), beam("left", -0.02), beam("right", 0.02)];
    assert_eq!(carried(&both).unwrap().len(), 2);
    // A slightly lower beam supports too if it is needed, and does not otherwise.
    let lower = moved(beam("right", 0.02), &Pose::translation(0.0, 0.0, -5e-4));
    assert_eq!(carried(&[object(0.0), beam("left", -0.02), lower.clone()]).unwrap().len(), 2);
    assert_eq!(
        carried(&[object(0.0), beam("left", 0.0), lower]).unwrap(),
        [("left".to_owned(), tenths(0.0))]
    );
    for bodies in [&both[..2], &[object(0.0), beam("left", -0.02), beam("left too", -0.01)]] {
        match carried(bodies) {
            Err(CollisionError::Topples { name, off_m, .. }) => {
                assert!(name == "object" && off_m > 0.004, "{off_m}");
            }
            other => panic!("{other:?}"),
        }
    }
    // A stool rests on its legs alone: the gap between them gives no support.
    let mut stool = block("stool", [0.0, 0.0, 0.09], [0.1, 0.1, 0.01]);
    for (x, y) in [(-0.09, -0.09), (-0.09, 0.09), (0.09, -0.09), (0.09, 0.09)] {
        let solid = Solid::cuboid([0.01, 0.01, 0.04].into()).unwrap();
        stool.parts.push(Part { world_from_solid: Pose::translation(x, y, 0.04), solid });
    }
    assert!(carried(&[stool.clone(), block("floor", [0.0, 0.0, -0.05], [0.2, 0.2, 0.05])]).is_ok());
    let half = block("half", [0.1, 0.0, -0.05], [0.12, 0.2, 0.05]);
    assert!(matches!(carried(&[stool, half]), Err(CollisionError::Topples { .. })));
}

#[test]
fn points_and_lines_of_contact_carry_what_is_right_above_them() {
    let ball = Body::new("ball", Pose::translation(0.0, 0.0, 0.03), Solid::sphere(0.03).unwrap());
    assert_eq!(carried(&[ball.clone(), table()]).unwrap(), [("table".to_owned(), tenths(0.0))]);
    assert_eq!(carried(&[ball.clone(), Body::floor(0.0)]).unwrap(), [("floor".to_owned(), tenths(0.0))]);
    let mesh = Solid::mesh(&ball.parts[0].solid.tessellation().unwrap()).unwrap();
    assert_eq!(
        carried(&[Body::new("mesh", Pose::translation(0.0, 0.0, 0.03), mesh), table()]).unwrap().len(),
        1
    );
    let turned = |angle: f64| {
        let reach = angle.sin() * HALF_M[0] + angle.cos() * HALF_M[2];
        let solid = Solid::cuboid(HALF_M.into()).unwrap();
        Body::new("edge", Pose::translation(0.0, 0.0, reach) * Pose::rotation(Vector::y() * angle), solid)
    };
    // Balanced on an edge, and leaning.
    let balanced = HALF_M[0].atan2(HALF_M[2]);
    assert!(carried(&[turned(balanced), table()]).is_ok());
    assert!(matches!(carried(&[turned(FRAC_PI_4 + 0.2), table()]), Err(CollisionError::Topples { .. })));
}

#[test]
fn down_is_where_gravity_pulls_and_slopes_are_known() {
    // A robot that is tilted by 20° stands on level ground.
    let tilt = Pose::rotation(Vector::x() * 0.35);
    let tilted: Vec<Body> = [object(0.0), table()].map(|body| moved(body, &tilt)).to_vec();
    let up = tilt.rotation * Vector::z();
    let of = |world: World| {
        let cell = cell(Vec::new(), 0.0);
        let cell = Cell::new(cell.robot().clone(), world, Margins::default()).unwrap();
        cell.resting(0).unwrap().slope_rad(&cell.world().up())
    };
    assert!(of(World::new(tilted.clone()).unwrap().with_up(&up)) < 1e-9);
    let floor = moved(Body::floor(-5.0), &tilt);
    assert!(of(World::new([&tilted[..], &[floor]].concat()).unwrap()) < 1e-9);
    // A floor that is level in the robot's frame is a slope.
    let level = World::new(vec![object(0.0), table()]).unwrap().with_up(&up);
    assert!((of(level) - 0.35).abs() < 1e-9);
    // So steep a face supports nothing.
    let steep = Pose::rotation(Vector::x() * 0.9);
    assert!(carried(&[object(0.0), table()].map(|body| moved(body, &steep))).is_err());
    assert_eq!(World::new(Vec::new()).unwrap().up(), Vector::z());
    assert_eq!(World::new(vec![Body::floor(1.0)]).unwrap().up(), Vector::z());
}

#[test]
fn uneven_ground_carries_by_what_is_under_the_object() {
    // A grid that rises to both sides, flat in the middle to a twentieth of a millimetre.
    let side = 40_u32;
    let height = |x: f64, y: f64| {
        let beyond = (x.abs() - 0.05).max(0.0);
        0.4 * beyond + 2.5e-5 * ((x * 400.0).sin() * (y * 300.0).cos() - 1.0)
    };
    let mut soup = TriangleSoup::default();
    for index in 0..(side + 1) * (side + 1) {
        let [x, y] =
            [index % (side + 1), index / (side + 1)].map(|at| (f64::from(at) / f64::from(side) - 0.5) * 0.4);
        soup.vertices.push(Point::new(x, y, height(x, y)));
    }
    let top = u32::try_from(soup.vertices.len()).unwrap();
    let below: Vec<Point> = soup.vertices.iter().map(|vertex| Point::new(vertex.x, vertex.y, -0.1)).collect();
    soup.vertices.extend(below);
    let at = |x: u32, y: u32| y * (side + 1) + x;
    for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        soup.triangles.extend([[a, b, c], [a, c, d]]);
        soup.triangles.extend([[a + top, c + top, b + top], [a + top, d + top, c + top]]);
    }
    for step in 0..side {
        for [a, b] in [
            [at(step + 1, 0), at(step, 0)],
            [at(step, side), at(step + 1, side)],
            [at(0, step), at(0, step + 1)],
            [at(side, step + 1), at(side, step)],
        ] {
            soup.triangles.extend([[a, b, b + top], [a, b + top, a + top]]);
        }
    }
    let ground = Body::new("ground", Pose::identity(), Solid::mesh(&soup).unwrap());
    let bodies = vec![object(0.0), ground];
    assert_eq!(carried(&bodies).unwrap().len(), 1);
    let (lifting, _) = lifting(&cell(bodies, 0.0));
    let mut scratch = lifting.scratch();
    assert!(lifting.is_clear(&[0.0; 3], &mut scratch));
    assert!(lifting.is_clear(&[0.01, 0.0, 0.0], &mut scratch));
    assert!(!lifting.is_clear(&[0.03, 0.0, 0.0], &mut scratch), "the slope beside it is an obstacle");
}
