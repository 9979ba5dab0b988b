//! Colours of the bodies of a `scenario.yaml`, for display.

use cranny_shape::mesh_colour;
use serde_saphyr::Spanned;

use crate::layout::own::Layout;
use crate::layout::own_file::{BodyEntry, ShapeEntry};
use crate::object::folder::object_colour;
use crate::{BodyColours, OBJECT_FILE, ScenarioError};

impl Layout<'_> {
    /// Adds the colours of the shapes of a body, if any has one.
    pub fn add_colours(&self, entry: &BodyEntry, colours: &mut BodyColours) -> Result<(), ScenarioError> {
        let of_shapes = entry.shapes.iter().map(|shape| self.colour(shape)).collect::<Result<Vec<_>, _>>()?;
        if of_shapes.iter().any(Option::is_some) {
            colours.insert(entry.name.value.clone(), of_shapes);
        }
        Ok(())
    }

    /// Returns the stated colour of a shape, else that of its mesh file or object.
    fn colour(&self, shape: &Spanned<ShapeEntry>) -> Result<Option<[f64; 3]>, ScenarioError> {
        if let Some(stated) = self.stated_colour(shape)? {
            return Ok(Some(stated));
        }
        let ShapeEntry { mesh, hull, object, .. } = &shape.value;
        if let Some(entry) = mesh.as_ref().or(hull.as_ref()) {
            return Ok(mesh_colour(&self.folder.join(&entry.file)));
        }
        let object = object.as_ref().map(|name| self.folder.join(name).join(OBJECT_FILE));
        Ok(object.filter(|file| file.is_file()).and_then(|file| object_colour(&file)))
    }

    /// Returns the stated colour of a shape, which must be three numbers from 0 to 1.
    pub fn stated_colour(&self, shape: &Spanned<ShapeEntry>) -> Result<Option<[f64; 3]>, ScenarioError> {
        let Some(colour) = shape.value.colour else { return Ok(None) };
        if colour.iter().all(|channel| (0.0..=1.0).contains(channel)) {
            return Ok(Some(colour));
        }
        Err(ScenarioError::Colour { at: self.at(shape.referenced), colour })
    }
}
