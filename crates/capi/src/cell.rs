//! `CrannyCell`: a robot in a world, and its checks.

use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::ptr::null;
use std::sync::{Arc, Mutex, MutexGuard};

use cranny::collision::{Cell, Collider, Contact, Margins, Scratch};

use crate::boundary::{FlagBuffer, NumberBuffer, Numbers, given, guarded, put};
use crate::error::{CrannyStatus, Fault};
use crate::robot::{CrannyRobot, check_dof};
use crate::text::{c_text, c_texts};
use crate::world::CrannyWorld;

/// Robot in a world, for checks of configurations and whole motions, and for clearances.
///
/// Links and bodies are solids; pairs nearer than 10 µm, or than a required margin, count as contact. The results equal those
/// of Rust and Python, bit for bit. A cell never changes, but has memory to compute in: checks of several threads on one cell
/// wait for each other, so give each thread its own by cranny_cell_clone.
#[derive(Debug)]
pub struct CrannyCell {
    pub cell: Arc<Cell>,
    pub names: Arc<Names>,
    scratch: Mutex<CellScratch>,
}

/// Memory of the checks of one thread.
#[derive(Debug)]
pub struct CellScratch {
    pub check: Scratch,
    verdicts: Vec<bool>,
}

/// Names that contacts and motions refer to.
#[derive(Debug)]
pub struct Names {
    links: Vec<CString>,
    bodies: Vec<CString>,
    pub joints: Vec<CString>,
    pub bounds: Vec<CString>,
}

impl CrannyCell {
    /// Wraps a cell.
    pub fn of(cell: Arc<Cell>) -> Box<Self> {
        let names = Names {
            links: cell.robot().links().iter().map(|link| c_text(&link.name)).collect(),
            bodies: cell.world().bodies().iter().map(|body| c_text(&body.name)).collect(),
            joints: c_texts(cell.robot().joint_names().iter().map(String::as_str)),
            bounds: cell.tool_bounds().map(|bound| c_text(&bound.name)).collect(),
        };
        Self::with(cell, Arc::new(names))
    }

    fn with(cell: Arc<Cell>, names: Arc<Names>) -> Box<Self> {
        let scratch = Mutex::new(CellScratch { check: cell.scratch(), verdicts: Vec::new() });
        Box::new(Self { cell, names, scratch })
    }

    /// Returns the memory for a check, after the checks of other threads on this handle.
    pub fn scratch(&self) -> MutexGuard<'_, CellScratch> {
        self.scratch.lock().unwrap_or_else(|poisoned| {
            // A panic may have left anything in it.
            self.scratch.clear_poison();
            let mut scratch = poisoned.into_inner();
            *scratch = CellScratch { check: self.cell.scratch(), verdicts: Vec::new() };
            scratch
        })
    }

    /// Checks that `dof` is the number of joints.
    pub fn check_dof(&self, dof: usize) -> Result<(), Fault> {
        check_dof(self.cell.robot(), dof)
    }
}

/// Pair of bodies or links that violates its required clearance. The names are valid as long as the cell, of which they are,
/// and its clones.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CrannyContact {
    /// Name of the link; NULL if there is no contact.
    pub first: *const c_char,
    /// Name of another link, or of a body; NULL if there is no contact.
    pub second: *const c_char,
    /// Distance of the pair in metres; 0 if they overlap.
    pub clearance_m: f64,
    /// Required clearance in metres.
    pub required_m: f64,
    /// Penetration depth in metres; 0 if they are only too close.
    pub depth_m: f64,
    /// Point in the overlap, in the planning frame, in metres; NaN if they are only too close.
    pub point_m: [f64; 3],
}

impl CrannyContact {
    /// No contact.
    pub const NONE: Self = Self {
        first: null(),
        second: null(),
        clearance_m: f64::NAN,
        required_m: f64::NAN,
        depth_m: f64::NAN,
        point_m: [f64::NAN; 3],
    };

    /// Converts a contact.
    pub fn of(names: &Names, contact: &Contact) -> Self {
        let name = |collider| match collider {
            Collider::Link(link) => names.links.get(link),
            Collider::Body(body) => names.bodies.get(body),
        };
        let pointer = |collider| name(collider).map_or(null(), |name| name.as_ptr());
        Self {
            first: pointer(contact.first),
            second: pointer(contact.second),
            clearance_m: contact.clearance_m,
            required_m: contact.required_m,
            depth_m: contact.depth_m,
            point_m: contact.point.map_or([f64::NAN; 3], |point| point.coords.into()),
        }
    }
}

/// Makes a cell of a robot in a world. All checks require the clearance `margin_m` (m) between any two bodies or links. The
/// caller frees it with cranny_cell_free. cranny_scenario_cell makes that of a scenario.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_new(
    robot: Option<&CrannyRobot>,
    world: Option<&CrannyWorld>,
    margin_m: f64,
    cell: Option<&mut MaybeUninit<Option<Box<CrannyCell>>>>,
) -> CrannyStatus {
    guarded(|| {
        let (robot, world) = (given(robot, "robot")?, given(world, "world")?);
        let margins = Margins { margin_m, ..Margins::default() };
        let made = Cell::new(robot.robot.clone(), world.now()?, margins)?;
        put(cell, "cell", Some(CrannyCell::of(Arc::new(made))))
    })
}

/// Makes a second handle of a cell, for another thread: they share everything but the memory of the checks. The caller frees it
/// with cranny_cell_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_clone(
    cell: Option<&CrannyCell>,
    clone: Option<&mut MaybeUninit<Option<Box<CrannyCell>>>>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        put(clone, "clone", Some(CrannyCell::with(cell.cell.clone(), cell.names.clone())))
    })
}

/// Frees a cell. NULL is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_free(cell: Option<Box<CrannyCell>>) {
    drop(cell);
}

/// Makes a handle of the robot of a cell. The caller frees it with cranny_robot_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_robot(
    cell: Option<&CrannyCell>,
    robot: Option<&mut MaybeUninit<Option<Box<CrannyRobot>>>>,
) -> CrannyStatus {
    guarded(|| put(robot, "robot", Some(CrannyRobot::of(given(cell, "cell")?.cell.robot().clone()))))
}

/// Checks a configuration, `dof` values. `is_free` receives whether it is within the joint limits and every pair keeps its
/// clearance; a value that is not finite is not within them.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_is_free(
    cell: Option<&CrannyCell>,
    q: Numbers<'_>,
    dof: usize,
    is_free: Option<&mut MaybeUninit<bool>>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        cell.check_dof(dof)?;
        let q = q.values("q", 1, dof)?;
        put(is_free, "is_free", cell.cell.is_free(q, &mut cell.scratch().check))
    })
}

/// Checks `rows` configurations, `rows` × `dof`, as cranny_cell_is_free, several times as fast. `are_free` receives `rows`
/// verdicts.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_are_free(
    cell: Option<&CrannyCell>,
    q: Numbers<'_>,
    rows: usize,
    dof: usize,
    mut are_free: FlagBuffer<'_>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        cell.check_dof(dof)?;
        let q = q.values("q", rows, dof)?;
        let CellScratch { check, verdicts } = &mut *cell.scratch();
        cell.cell.are_free(q, check, verdicts);
        are_free.write("are_free", verdicts)
    })
}

/// Measures `rows` configurations, `rows` × `dof`. `clearances_m` receives `rows` values: the least distance over all pairs in
/// metres, a certified lower bound; 0 in contact, infinite without any pair. Joint limits are not checked.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_clearances(
    cell: Option<&CrannyCell>,
    q: Numbers<'_>,
    rows: usize,
    dof: usize,
    mut clearances_m: NumberBuffer<'_>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        cell.check_dof(dof)?;
        let q = q.finite("q", rows, dof)?.chunks_exact(dof.max(1));
        let scratch = &mut cell.scratch().check;
        let measured: Vec<f64> = q.map(|q| cell.cell.clearance(q, scratch)).collect();
        clearances_m.write("clearances_m", &measured)
    })
}

/// Finds the first pair at a configuration, `dof` values, that violates its clearance, in a fixed order, hand and wrist before
/// the base. Without one, the names of `contact` are NULL. Joint limits are not checked.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_first_contact(
    cell: Option<&CrannyCell>,
    q: Numbers<'_>,
    dof: usize,
    contact: Option<&mut MaybeUninit<CrannyContact>>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        cell.check_dof(dof)?;
        let found = cell.cell.first_contact(q.finite("q", 1, dof)?, &mut cell.scratch().check);
        let found = found.map_or(CrannyContact::NONE, |found| CrannyContact::of(&cell.names, &found));
        put(contact, "contact", found)
    })
}
