//! Proofs of motions and paths.

use std::ffi::{CString, c_char};
use std::mem::MaybeUninit;
use std::ptr::null;

use cranny::collision::Motion;

use crate::boundary::{FlagBuffer, NumberBuffer, Numbers, given, guarded, put};
use crate::cell::{CrannyCell, CrannyContact, Names};
use crate::error::{CrannyStatus, Fault};

/// Result of the check of a straight motion between two configurations.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrannyMotionKind {
    /// All of the motion is proven free.
    Proven = 0,
    /// Some point of it is in contact, or closer than demanded.
    Contact = 1,
    /// Contact is neither found nor excluded: a pair comes within 1 µm of the required clearance.
    Unresolved = 2,
    /// A bound of the tool is exceeded, or not proven.
    OutOfBounds = 3,
    /// An end is out of the joint limits.
    OutOfLimits = 4,
}

/// Proof of a straight motion, or the obstruction to it. The names are valid as long as the cell and its clones.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CrannyMotion {
    /// Kind of the result.
    pub kind: CrannyMotionKind,
    /// Position along the motion, in [0, 1], at which it is not free; NaN if it is proven, or if an end is out of limits.
    pub at: f64,
    /// Pair that touches or is undecided there; its names are NULL for the other kinds.
    pub contact: CrannyContact,
    /// Name of the joint that is out of limits, or of the bound that is exceeded; NULL for the other kinds.
    pub name: *const c_char,
}

impl CrannyMotion {
    fn of(names: &Names, motion: &Motion) -> Self {
        let pointer = |names: &[CString], index: usize| names.get(index).map_or(null(), |name| name.as_ptr());
        let (kind, at, contact, name) = match motion {
            Motion::Proven => (CrannyMotionKind::Proven, f64::NAN, None, null()),
            Motion::Contact { at, contact } => (CrannyMotionKind::Contact, *at, Some(contact), null()),
            Motion::Unresolved { at, contact } => (CrannyMotionKind::Unresolved, *at, Some(contact), null()),
            Motion::OutOfBounds { at, bound, .. } => {
                (CrannyMotionKind::OutOfBounds, *at, None, pointer(&names.bounds, *bound))
            }
            Motion::OutOfLimits { joint } => {
                (CrannyMotionKind::OutOfLimits, f64::NAN, None, pointer(&names.joints, *joint))
            }
        };
        let contact = contact.map_or(CrannyContact::NONE, |contact| CrannyContact::of(names, contact));
        Self { kind, at, contact, name }
    }
}

/// Checks the straight motion from `a` to `b`, `dof` values each, along its whole length; samples prove nothing.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_motion(
    cell: Option<&CrannyCell>,
    a: Numbers<'_>,
    b: Numbers<'_>,
    dof: usize,
    motion: Option<&mut MaybeUninit<CrannyMotion>>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        cell.check_dof(dof)?;
        let (a, b) = (a.finite("a", 1, dof)?, b.finite("b", 1, dof)?);
        let found = cell.cell.motion_is_free(a, b, &mut cell.scratch().check);
        put(motion, "motion", CrannyMotion::of(&cell.names, &found))
    })
}

/// Checks `rows` straight motions, from each row of `a` to that of `b`, `rows` × `dof` both. `are_free` receives `rows` verdicts:
/// whether the whole motion is proven free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_motions_are_free(
    cell: Option<&CrannyCell>,
    a: Numbers<'_>,
    b: Numbers<'_>,
    rows: usize,
    dof: usize,
    mut are_free: FlagBuffer<'_>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        cell.check_dof(dof)?;
        let a = a.finite("a", rows, dof)?.chunks_exact(dof.max(1));
        let b = b.finite("b", rows, dof)?.chunks_exact(dof.max(1));
        let scratch = &mut cell.scratch().check;
        let proven: Vec<bool> =
            a.zip(b).map(|(a, b)| cell.cell.motion_is_free(a, b, scratch).is_proven()).collect();
        are_free.write("are_free", &proven)
    })
}

/// Checks a path of `rows` way points, `rows` × `dof`, joined by straight lines. `motion` receives the first edge that is not
/// proven, and `edge` its number from 0; if all are proven, `edge` is `rows` - 1. A path of one way point is a motion that stands
/// still.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_path(
    cell: Option<&CrannyCell>,
    path: Numbers<'_>,
    rows: usize,
    dof: usize,
    edge: Option<&mut MaybeUninit<usize>>,
    motion: Option<&mut MaybeUninit<CrannyMotion>>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        cell.check_dof(dof)?;
        if rows == 0 {
            return Err(Fault::Lacking { what: "path", problem: "it has no way point" });
        }
        let path: Vec<&[f64]> = path.finite("path", rows, dof)?.chunks_exact(dof.max(1)).collect();
        let scratch = &mut cell.scratch().check;
        let mut prove = |a: &[f64], b: &[f64]| cell.cell.motion_is_free(a, b, scratch);
        let still = if let [only] = path[..] { prove(only, only) } else { Motion::Proven };
        let mut edges = path.windows(2).map(|ends| prove(ends[0], ends[1])).enumerate();
        let first = edges.find(|(_, motion)| !motion.is_proven());
        let (index, found) = first.unwrap_or((rows - 1, still));
        let (edge, motion) = (given(edge, "edge")?, given(motion, "motion")?);
        edge.write(index);
        motion.write(CrannyMotion::of(&cell.names, &found));
        Ok(())
    })
}

/// Measures the straight motion from `a` to `b`, `dof` values each. `clearance_m` receives one value: the least distance over
/// all pairs along it in metres, a certified lower bound, at most 10 µm too low; 0 if there is contact. Joint limits are not
/// checked.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_cell_least_clearance(
    cell: Option<&CrannyCell>,
    a: Numbers<'_>,
    b: Numbers<'_>,
    dof: usize,
    mut clearance_m: NumberBuffer<'_>,
) -> CrannyStatus {
    guarded(|| {
        let cell = given(cell, "cell")?;
        cell.check_dof(dof)?;
        let (a, b) = (a.finite("a", 1, dof)?, b.finite("b", 1, dof)?);
        let least_m = cell.cell.least_clearance(a, b, &mut cell.scratch().check);
        clearance_m.write("clearance_m", &[least_m])
    })
}
