//! `.scene` files, as `MoveIt`'s panel in `RViz` exports the objects of a planning scene.
//!
//! Format: the name of the scene, then for each object `* NAME`, its pose, the number of its shapes, for each shape its kind,
//! dimensions, pose and colour, and the subframes; a final `.`. Older files have neither the pose of the object nor subframes:
//! the line below the first name contains only the number of shapes (`PlanningScene::loadGeometryFromStream` of `MoveIt`).

use std::path::Path;

use cranny_collision::{Body, Part};
use cranny_robot::Location;
use cranny_shape::{ShapeError, Solid, TriangleSoup};
use cranny_spatial::{Point, Pose, Vector};

use crate::files::{sizes, yaml};
use crate::{MoveItError, ScenarioError};

/// Returns true if a text is a `.scene` file: the name of the scene is followed by an object, or by the end.
pub(crate) fn is_scene_text(text: &str) -> bool {
    let mut lines = text.lines().skip(1).map(str::trim).filter(|line| !line.is_empty());
    lines.next().is_some_and(|line| line == "." || line.starts_with("* "))
}

/// Returns the objects of the `.scene` file `path` with content `text`, in the planning frame.
///
/// # Errors
/// [`MoveItError::SceneText`] for malformed content; errors of invalid shapes.
pub(crate) fn parse(path: &Path, text: &str) -> Result<Vec<Body>, ScenarioError> {
    let lines: Vec<&str> = text.lines().collect();
    let first = lines.iter().position(|line| line.starts_with('*'));
    let below = first.and_then(|first| lines.get(first + 1)).copied().unwrap_or_default();
    let mut reader = Reader { path, lines, line: 1, column: 0 };
    let has_object_poses = below.trim().contains(' ');
    let mut bodies = Vec::new();
    loop {
        match reader.word("'*' or '.'")? {
            "*" => bodies.push(reader.object(has_object_poses)?),
            "." => break,
            other => return Err(reader.unexpected("'*' or '.'", other)),
        }
    }
    match reader.next_word() {
        Some(more) => Err(reader.unexpected("the end of the file", more)),
        None => Ok(bodies),
    }
}

/// Reader of the words of a text.
struct Reader<'a> {
    path: &'a Path,
    lines: Vec<&'a str>,
    /// Index of the current line.
    line: usize,
    /// Number of bytes of that line that have been read.
    column: usize,
}

impl<'a> Reader<'a> {
    fn at(&self) -> Location {
        yaml::line(self.path, (self.line + 1).min(self.lines.len()))
    }

    fn unexpected(&self, expected: &'static str, found: &str) -> ScenarioError {
        MoveItError::SceneText { at: self.at(), expected, found: cranny_file::excerpt(found) }.into()
    }

    fn next_word(&mut self) -> Option<&'a str> {
        while let Some(line) = self.lines.get(self.line) {
            let rest = line[self.column..].trim_start();
            if !rest.is_empty() {
                let word = rest.split_whitespace().next().unwrap_or_default();
                self.column = line.len() - rest.len() + word.len();
                return Some(word);
            }
            (self.line, self.column) = (self.line + 1, 0);
        }
        None
    }

    fn word(&mut self, expected: &'static str) -> Result<&'a str, ScenarioError> {
        self.next_word().ok_or_else(|| {
            MoveItError::SceneText { at: self.at(), expected, found: "the end of the file".to_owned() }.into()
        })
    }

    fn number(&mut self) -> Result<f64, ScenarioError> {
        const EXPECTED: &str = "a number";
        let word = self.word(EXPECTED)?;
        let number = word.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.unexpected(EXPECTED, word))
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], ScenarioError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Ok(numbers)
    }

    fn count<T: std::str::FromStr>(&mut self, expected: &'static str) -> Result<T, ScenarioError> {
        let word = self.word(expected)?;
        word.parse().map_err(|_| self.unexpected(expected, word))
    }

    /// Reads a pose: a position, and a quaternion x, y, z, w.
    fn pose(&mut self) -> Result<Pose, ScenarioError> {
        let position: [f64; 3] = self.numbers()?;
        let orientation: [f64; 4] = self.numbers()?;
        let rotation = yaml::rotation_at(self.at(), orientation)?;
        Ok(Pose::from_parts(Vector::from(position).into(), rotation))
    }

    /// Reads an object, from its name on.
    fn object(&mut self, has_pose: bool) -> Result<Body, ScenarioError> {
        let name = self.lines[self.line][self.column..].trim().to_owned();
        let at = self.at();
        (self.line, self.column) = (self.line + 1, 0);
        let world_from_object = if has_pose { self.pose()? } else { Pose::identity() };
        let shapes: u32 = self.count("the number of shapes")?;
        let mut parts = Vec::new();
        for _ in 0..shapes {
            let solid = self.shape(&name)?;
            parts.push(Part { world_from_solid: world_from_object * self.pose()?, solid });
            let _colour: [f64; 4] = self.numbers()?;
        }
        if has_pose {
            for _ in 0..self.count::<u32>("the number of subframes")? {
                self.word("the name of a subframe")?;
                self.pose()?;
            }
        }
        if parts.is_empty() {
            return Err(MoveItError::NoShape { at, object: name }.into());
        }
        Ok(Body { name, parts, tilt_rad: None, center_of_mass: None })
    }

    fn shape(&mut self, object: &str) -> Result<Solid, ScenarioError> {
        const EXPECTED: &str = "a shape (box, sphere, cylinder, mesh)";
        let kind = self.word(EXPECTED)?;
        let at = self.at();
        let unsupported = |what, hint| Err(ScenarioError::Unsupported { at: at.clone(), what, hint });
        let solid = match kind {
            "box" => sizes::cuboid(self.numbers()?),
            "sphere" => Solid::sphere(self.number()?),
            "cylinder" => {
                let [radius_m, length_m] = self.numbers()?;
                sizes::cylinder(length_m, radius_m)
            }
            "mesh" => self.mesh()?,
            "cone" => return unsupported("a cone", "a cone has no exact solid here; give a mesh"),
            "plane" => return unsupported("a plane", "give a box"),
            other => return Err(self.unexpected(EXPECTED, other)),
        };
        solid.map_err(|reason| ScenarioError::Shape { at, body: object.to_owned(), reason })
    }

    /// Reads a mesh: the numbers of vertices and triangles, then both.
    fn mesh(&mut self) -> Result<Result<Solid, ShapeError>, ScenarioError> {
        let vertices: u32 = self.count("the number of vertices")?;
        let triangles: u32 = self.count("the number of triangles")?;
        let mut soup = TriangleSoup { vertices: Vec::new(), triangles: Vec::new() };
        for _ in 0..vertices {
            soup.vertices.push(Point::from(self.numbers::<3>()?));
        }
        for _ in 0..triangles {
            let corner = |reader: &mut Self| reader.count("the number of a vertex");
            soup.triangles.push([corner(self)?, corner(self)?, corner(self)?]);
        }
        Ok(Solid::mesh_with_small_holes(&soup))
    }
}
