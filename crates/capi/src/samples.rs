//! `CrannySamples`: a trajectory sampled at equal intervals.

use std::ptr::null;

use cranny::plan::PlanError;
use cranny::solve::TaskTrajectory;

use crate::boundary::{answered, given};

/// Trajectory at `count` instants. It never changes. The arrays that the functions return are valid as long as it.
#[derive(Debug)]
pub struct CrannySamples {
    times: Vec<f64>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    /// Finger openings, in metres, if the fingers close on an object; otherwise empty.
    openings: Vec<f64>,
    dof: usize,
}

impl CrannySamples {
    /// Samples a trajectory.
    pub fn of(trajectory: &TaskTrajectory, rate_hz: f64) -> Result<Box<Self>, PlanError> {
        let mut samples = Self {
            times: Vec::new(),
            positions: Vec::new(),
            velocities: Vec::new(),
            accelerations: Vec::new(),
            openings: Vec::new(),
            dof: trajectory.joint_names().len(),
        };
        for sample in trajectory.samples(rate_hz)? {
            samples.times.push(sample.time_s);
            samples.positions.extend(sample.position);
            samples.velocities.extend(sample.velocity);
            samples.accelerations.extend(sample.acceleration);
            samples.openings.extend(trajectory.opening_m(sample.time_s));
        }
        Ok(Box::new(samples))
    }
}

/// Frees samples. NULL is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_samples_free(samples: Option<Box<CrannySamples>>) {
    drop(samples);
}

/// Returns the number of instants; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_samples_count(samples: Option<&CrannySamples>) -> usize {
    answered(0, || Ok(given(samples, "samples")?.times.len()))
}

/// Returns the number of joints; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_samples_dof(samples: Option<&CrannySamples>) -> usize {
    answered(0, || Ok(given(samples, "samples")?.dof))
}

/// Returns the times, count values, in seconds from 0.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_samples_times(samples: Option<&CrannySamples>) -> *const f64 {
    answered(null(), || Ok(given(samples, "samples")?.times.as_ptr()))
}

/// Returns the joint values, count × dof, in m or rad.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_samples_positions(samples: Option<&CrannySamples>) -> *const f64 {
    answered(null(), || Ok(given(samples, "samples")?.positions.as_ptr()))
}

/// Returns the joint velocities, count × dof, in m/s or rad/s.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_samples_velocities(samples: Option<&CrannySamples>) -> *const f64 {
    answered(null(), || Ok(given(samples, "samples")?.velocities.as_ptr()))
}

/// Returns the joint accelerations, count × dof, in m/s² or rad/s²; at a discontinuity, the value right after it.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_samples_accelerations(samples: Option<&CrannySamples>) -> *const f64 {
    answered(null(), || Ok(given(samples, "samples")?.accelerations.as_ptr()))
}

/// Returns the distances between the fingers, count values, in metres; NULL if the fingers do not close on an object.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_samples_openings(samples: Option<&CrannySamples>) -> *const f64 {
    answered(null(), || {
        let samples = given(samples, "samples")?;
        Ok(if samples.openings.is_empty() { null() } else { samples.openings.as_ptr() })
    })
}
