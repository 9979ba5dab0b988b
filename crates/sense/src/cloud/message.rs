use crate::cloud::collector::Collector;
use crate::cloud::number::Number;
use crate::cloud::read_cloud::ReadCloud;
use crate::cloud::row::{Row, axes};

/// Point cloud in the form of a `sensor_msgs/PointCloud2`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CloudMessage<'a> {
    /// Number of rows.
    pub height: usize,
    /// Number of points in a row.
    pub width: usize,
    /// Fields of a point.
    pub fields: Vec<CloudField>,
    /// True if the numbers are in big-endian order.
    pub is_bigendian: bool,
    /// Size of a point, in bytes.
    pub point_step: usize,
    /// Size of a row, in bytes.
    pub row_step: usize,
    /// All rows.
    pub data: &'a [u8],
}

/// Field of a point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CloudField {
    /// Name, such as `x`.
    pub name: String,
    /// Offset in a point, in bytes.
    pub offset: usize,
    /// Type of its numbers: 1 to 8 for `i8`, `u8`, `i16`, `u16`, `i32`, `u32`, `f32`, `f64`.
    pub datatype: u8,
    /// Number of its numbers; 0 counts as 1, as some drivers write.
    pub count: usize,
}

impl CloudMessage<'_> {
    /// Returns the points, in the order of the message. Those with a coordinate that is not finite are dropped and counted.
    ///
    /// # Errors
    /// A sentence on sizes that contradict each other, missing coordinates, coordinates beyond 1000 m, or no valid point.
    pub fn read(&self) -> Result<ReadCloud, String> {
        let Self { height, width, point_step, row_step, data, .. } = *self;
        let needed = width.checked_mul(point_step).filter(|needed| *needed <= row_step);
        let needed = needed.ok_or_else(|| {
            format!("{width} points of {point_step} bytes do not fit into a row of {row_step} bytes")
        })?;
        if height.checked_mul(row_step) != Some(data.len()) {
            let actual = data.len();
            return Err(format!(
                "{height} rows of {row_step} bytes are announced, but the data has {actual} bytes"
            ));
        }
        if width == 0 || height == 0 {
            return Err("the cloud has no points".to_owned());
        }
        if point_step == 0 {
            return Err(format!("{} points of 0 bytes are announced (point_step)", width * height));
        }
        let places = axes(&self.fields.iter().map(|field| field.name.as_str()))?;
        let mut coordinates = [(0, Number::Float(4)); 3];
        for (coordinate, place) in coordinates.iter_mut().zip(places) {
            let CloudField { name, offset, datatype, count } = &self.fields[place];
            let number = number_of(*datatype)
                .filter(|_| *count <= 1)
                .ok_or_else(|| format!("the field '{name}' is no single number of a type from 1 to 8"))?;
            let end = offset.checked_add(number.bytes());
            if end.is_none_or(|end| end > point_step) {
                return Err(format!("the field '{name}' ends beyond the {point_step} bytes of a point"));
            }
            *coordinate = (*offset, number);
        }
        let layout = Row { coordinates, is_big_endian: self.is_bigendian };
        let mut points = Collector::new(width * height);
        for row in data.chunks_exact(row_step) {
            for point in row[..needed].chunks_exact(point_step) {
                points.add(layout.point(point).ok_or("a point is cut short")?)?;
            }
        }
        points.finish()
    }
}

fn number_of(datatype: u8) -> Option<Number> {
    Some(match datatype {
        1 => Number::Signed(1),
        2 => Number::Unsigned(1),
        3 => Number::Signed(2),
        4 => Number::Unsigned(2),
        5 => Number::Signed(4),
        6 => Number::Unsigned(4),
        7 => Number::Float(4),
        8 => Number::Float(8),
        _ => return None,
    })
}
