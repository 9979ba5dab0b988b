use crate::cloud::number::Number;

/// Places of the coordinates in the binary row of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Row {
    /// Offset in bytes and type of x, y and z.
    pub coordinates: [(usize, Number); 3],
    pub is_big_endian: bool,
}

impl Row {
    /// Returns the coordinates of a row; `None` if it is too short.
    pub fn point(&self, row: &[u8]) -> Option<[f64; 3]> {
        let mut point = [0.0; 3];
        for (value, (offset, number)) in point.iter_mut().zip(self.coordinates) {
            *value = number.read(row.get(offset..)?, self.is_big_endian)?;
        }
        Some(point)
    }
}

/// Returns the places of x, y and z among the names of fields; each must occur once.
pub(crate) fn axes<'a>(names: &(impl Iterator<Item = &'a str> + Clone)) -> Result<[usize; 3], String> {
    let mut places = [0; 3];
    for (place, axis) in places.iter_mut().zip(["x", "y", "z"]) {
        let mut found = names.clone().enumerate().filter(|(_, name)| *name == axis);
        *place = match (found.next(), found.next()) {
            (Some((index, _)), None) => index,
            (None, _) => return Err(format!("there is no field '{axis}'")),
            _ => return Err(format!("there are two fields '{axis}'")),
        };
    }
    Ok(places)
}
