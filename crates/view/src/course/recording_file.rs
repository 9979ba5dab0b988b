use std::path::Path;

use cranny_scenario::ScenarioError;
use cranny_shape::TriangleSoup;
use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Point, Pose, Rotation, Vector};
use serde::{Deserialize, Serialize};

use crate::{BodyRecording, MovingBody, ViewError};

/// Contents of a recording file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RecordingFile {
    format: String,
    name: String,
    times_s: Vec<f64>,
    /// Frame whose plane z = 0 is the floor.
    #[serde(default)]
    world_from_floor: Option<PoseEntry>,
    bodies: Vec<BodyEntry>,
}

/// Position (m), then the quaternion (x, y, z, w).
type PoseEntry = [f64; 7];

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyEntry {
    name: String,
    #[serde(default)]
    is_grasped: bool,
    /// One pose, or one per instant.
    world_from_body: Vec<PoseEntry>,
    /// Vertices in the frame of the body, in metres.
    vertices: Vec<[f64; 3]>,
    /// Three vertex indices per triangle, from 0, counter-clockwise seen from outside.
    triangles: Vec<[u32; 3]>,
}

/// Beginning of a file, read before the rest.
// Other keys are for the parser of the format.
#[derive(Deserialize)]
struct Head {
    #[serde(default)]
    format: Option<String>,
}

/// Maximum coordinate, in metres: single precision can still draw it.
const FARTHEST_M: f64 = 1e6;

/// Tolerance on the norm of a quaternion.
const UNIT_TOLERANCE: f64 = 1e-6;

impl BodyRecording {
    /// Format identifier of the files that [`Self::read`] accepts.
    pub const FORMAT: &'static str = "cranny-recording/1";

    /// Serializes the recording for [`Self::read`]; bodies without a surface are left out.
    ///
    /// # Errors
    /// [`ViewError::PageData`] for values that JSON cannot represent.
    pub fn json(&self) -> Result<String, ViewError> {
        let body = |body: &MovingBody| BodyEntry {
            name: body.name.clone(),
            is_grasped: body.is_grasped,
            world_from_body: body.world_from_body.iter().map(entry_of).collect(),
            vertices: body.surface.vertices.iter().map(|vertex| vertex.coords.into()).collect(),
            triangles: body.surface.triangles.clone(),
        };
        let file = RecordingFile {
            format: Self::FORMAT.to_owned(),
            name: self.name.clone(),
            times_s: self.times_s.clone(),
            world_from_floor: self.world_from_floor.as_ref().map(entry_of),
            bodies: self.bodies.iter().filter(|body| !body.surface.triangles.is_empty()).map(body).collect(),
        };
        let text = serde_json::to_string(&file).map_err(|reason| ViewError::PageData { reason })?;
        Ok(text + "\n")
    }

    /// Reads a recording from a file.
    ///
    /// # Errors
    /// [`ViewError::Scenario`] for a file that cannot be read or is not JSON of this form, [`ViewError::Recording`] for another
    /// format or an invalid value.
    pub fn read(path: &Path) -> Result<Self, ViewError> {
        let text = cranny_file::TABLE
            .bytes(path)
            .map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })?;
        let malformed = |reason| ScenarioError::Json { path: path.to_owned(), reason };
        let fault = |problem: String| ViewError::Recording { path: path.to_owned(), problem };
        let Head { format } = cranny_file::json(&text).map_err(malformed)?;
        match format.as_deref() {
            Some(Self::FORMAT) => {}
            Some(other) => {
                let other = cranny_file::excerpt(other);
                return Err(fault(format!(
                    "its format is '{other}', but a recording is '{}' (a plan is shown with the ID of its scenario before \
                     it)",
                    Self::FORMAT
                )));
            }
            None => return Err(fault(format!("it names no format, but a recording is '{}'", Self::FORMAT))),
        }
        let file: RecordingFile = cranny_file::json(&text).map_err(malformed)?;
        file.recording().map_err(fault)
    }
}

impl RecordingFile {
    fn recording(self) -> Result<BodyRecording, String> {
        let times_s = self.times_s;
        let is_ascending = times_s.windows(2).all(|pair| pair[0] < pair[1]);
        if times_s.first().is_none_or(|first| *first < 0.0) || !is_ascending {
            return Err("times_s must be seconds, at least one, ascending from 0 or later".to_owned());
        }
        if self.bodies.is_empty() {
            return Err("it has no bodies, so there is nothing to see".to_owned());
        }
        let floor =
            self.world_from_floor.map(|pose| pose_of(&pose).ok_or_else(|| wrong_pose("the floor", 0)));
        let body = |entry: BodyEntry| entry.body(times_s.len());
        let bodies = self.bodies.into_iter().map(body).collect::<Result<_, _>>()?;
        Ok(BodyRecording { name: self.name, world_from_floor: floor.transpose()?, bodies, times_s })
    }
}

impl BodyEntry {
    fn body(self, instants: usize) -> Result<MovingBody, String> {
        let name = cranny_file::excerpt(&self.name);
        let (poses, corners) = (self.world_from_body.len(), self.vertices.len());
        if poses != instants && poses != 1 {
            return Err(format!(
                "body '{name}' has {poses} poses; give one for each of the {instants} times_s, or a single one"
            ));
        }
        if self.triangles.is_empty() {
            return Err(format!("body '{name}' has no triangles"));
        }
        if let Some(corner) = self.triangles.iter().flatten().find(|corner| **corner as usize >= corners) {
            return Err(format!(
                "a triangle of body '{name}' has vertex {corner}, but there are {corners}, from 0"
            ));
        }
        if let Some(vertex) = self.vertices.iter().position(|vertex| !is_near(vertex)) {
            return Err(format!("vertex {vertex} of body '{name}' is farther away than {FARTHEST_M} m"));
        }
        let pose =
            |(index, entry)| pose_of(entry).ok_or_else(|| wrong_pose(&format!("body '{name}'"), index));
        let world_from_body = self.world_from_body.iter().enumerate().map(pose).collect::<Result<_, _>>()?;
        let vertices = self.vertices.into_iter().map(Point::from).collect();
        let surface = TriangleSoup { vertices, triangles: self.triangles };
        Ok(MovingBody { name: self.name, surface, is_grasped: self.is_grasped, world_from_body })
    }
}

fn entry_of(pose: &Pose) -> PoseEntry {
    let (at, q) = (pose.translation.vector, pose.rotation.coords);
    [at.x, at.y, at.z, q.x, q.y, q.z, q.w]
}

/// Converts an entry to a pose; `None` if it is invalid.
fn pose_of(&[x, y, z, i, j, k, w]: &PoseEntry) -> Option<Pose> {
    let quaternion = Quaternion::new(w, i, j, k);
    let is_unit = (quaternion.norm() - 1.0).abs() <= UNIT_TOLERANCE;
    (is_near(&[x, y, z]) && is_unit)
        .then(|| Pose::from_parts(Vector::new(x, y, z).into(), Rotation::new_unchecked(quaternion)))
}

fn is_near(coordinates: &[f64; 3]) -> bool {
    coordinates.iter().all(|x| x.abs() <= FARTHEST_M)
}

fn wrong_pose(of: &str, index: usize) -> String {
    format!(
        "pose {index} of {of} is none: three metres, at most {FARTHEST_M}, then a quaternion x, y, z, w of length 1"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording() -> BodyRecording {
        let surface = TriangleSoup {
            vertices: [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]].map(Point::from).to_vec(),
            triangles: vec![[0, 1, 2]],
        };
        let body = |name: &str, is_grasped, world_from_body| MovingBody {
            name: name.to_owned(),
            surface: surface.clone(),
            is_grasped,
            world_from_body,
        };
        let turned = Pose::new(Vector::new(1.0 / 3.0, 0.0, 0.5), Vector::new(0.1, 0.2, 0.3));
        BodyRecording {
            name: "test".to_owned(),
            times_s: vec![0.0, 0.02, 0.04],
            world_from_floor: Some(Pose::translation(0.0, 0.0, -0.1)),
            bodies: vec![
                body("ball", true, vec![Pose::identity(), turned, turned]),
                body("palm", false, vec![turned; 3]),
                body("shelf", false, vec![turned]),
            ],
        }
    }

    fn read(text: &str) -> Result<BodyRecording, ViewError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.json");
        std::fs::write(&path, text).unwrap();
        BodyRecording::read(&path)
    }

    #[test]
    fn what_is_written_is_read_back_bit_by_bit() {
        assert_eq!(read(&recording().json().unwrap()).unwrap(), recording());
    }

    #[test]
    fn at_a_lower_rate_there_are_fewer_instants() {
        let thinned = recording().thinned(25.0);
        assert_eq!(thinned.times_s, [0.0, 0.04]);
        let poses: Vec<usize> = thinned.bodies.iter().map(|body| body.world_from_body.len()).collect();
        assert_eq!(poses, [2, 2, 1]);
        assert_eq!(recording().thinned(50.0), recording());
    }

    #[test]
    fn at_a_higher_rate_poses_are_interpolated() {
        let whole = recording();
        assert_eq!(whole.sampled(50.0), whole);
        let slow = whole.sampled(200.0);
        assert_eq!(slow.times_s.len(), 9);
        let pose = |body: usize, instant: usize| slow.bodies[body].world_from_body[instant];
        for (instant, recorded) in [(0, 0), (4, 1), (8, 2)] {
            assert_eq!(pose(0, instant), whole.bodies[0].world_from_body[recorded]);
        }
        let turned = whole.bodies[0].world_from_body[1];
        let half = pose(0, 2);
        assert!((half.translation.vector - 0.5 * turned.translation.vector).norm() < 1e-12);
        assert!((half.rotation.angle() - 0.5 * turned.rotation.angle()).abs() < 1e-12);
        assert_eq!(slow.bodies[2].world_from_body.len(), 1);
        assert_eq!(whole.sampled(10.0).times_s, [0.0]);
    }

    #[test]
    fn what_cannot_be_is_refused_with_its_place() {
        let text = recording().json().unwrap();
        let change = |from: &str, to: &str| {
            assert!(text.contains(from), "{from} in {text}");
            read(&text.replacen(from, to, 1)).unwrap_err().to_string()
        };
        for (from, to, words) in [
            (
                "cranny-recording/1",
                "cranny-plan/1",
                &["run.json", "'cranny-plan/1'", "cranny-recording/1"][..],
            ),
            ("[0.0,0.02,0.04]", "[0.0,0.04,0.02]", &["times_s", "ascending"]),
            ("[0.0,0.02,0.04]", "[]", &["times_s", "at least one"]),
            ("[0.0,0.02,0.04]", "[0.0,0.02]", &["body 'ball' has 3 poses", "each of the 2 times_s"]),
            ("[0,1,2]", "[0,1,3]", &["body 'ball' has vertex 3", "there are 3"]),
            ("[[0,1,2]]", "[]", &["body 'ball' has no triangles"]),
            ("[0.1,0.0,0.0]", "[1e300,0.0,0.0]", &["vertex 1 of body 'ball'", "farther"]),
            (
                "0.0,0.0,0.0,0.0,0.0,0.0,1.0",
                "0.0,0.0,0.0,0.0,0.0,0.0,2.0",
                &["pose 0 of body 'ball'", "length 1"],
            ),
            ("\"times_s\"", "\"time_s\"", &["run.json:1", "times_s"]),
        ] {
            let said = change(from, to);
            for word in words {
                assert!(said.contains(word), "no '{word}' in: {said}");
            }
        }
        assert!(read("{}").unwrap_err().to_string().contains("names no format"));
        assert!(read("").is_err() && read("[]").is_err());
    }
}
