//! Rows as tables of Parquet, and back.

use std::path::Path;

use crate::DatasetError;
use crate::demonstration::Demonstration;
use crate::parquet::column::Column;
use crate::parquet::reader::{Table, read_parquet};
use crate::parquet::writer::parquet_file;
use crate::pictures::Picture;
use crate::scene_row::SceneRow;

/// Format of the rows, in the metadata of each file.
const FORMAT: &str = "cranny-dataset/1";

/// Returns the file of demonstrations.
pub(crate) fn demonstrations_file(rows: &[Demonstration]) -> Vec<u8> {
    let columns = [
        ("row", Column::Int64(rows.iter().map(|row| row.row.cast_signed()).collect())),
        ("scene", Column::Int64(rows.iter().map(|row| row.scene.cast_signed()).collect())),
        ("task", Column::Text(rows.iter().map(|row| row.task.clone()).collect())),
        ("outcome", Column::Text(rows.iter().map(|row| row.outcome.clone()).collect())),
        ("seed", Column::Int64(rows.iter().map(|row| row.seed.cast_signed()).collect())),
        ("start", Column::Doubles(rows.iter().map(|row| row.start.clone()).collect())),
        ("waypoints", Column::Doubles(rows.iter().map(|row| row.waypoints.clone()).collect())),
        ("times_s", Column::Doubles(rows.iter().map(|row| row.times_s.clone()).collect())),
        ("segments", Column::Int32s(rows.iter().map(|row| row.segments.clone()).collect())),
        ("openings_m", Column::Doubles(rows.iter().map(|row| row.openings_m.clone()).collect())),
        ("speeds", Column::Doubles(rows.iter().map(|row| row.speeds.clone()).collect())),
        ("uneven_m", Column::Doubles(rows.iter().map(|row| row.uneven_m.clone()).collect())),
        ("grasp", Column::Int64(rows.iter().map(|row| row.grasp).collect())),
        ("grasp_pose", Column::Doubles(rows.iter().map(|row| row.grasp_pose.clone()).collect())),
        ("load", Column::Double(rows.iter().map(|row| row.load).collect())),
        ("clearance_m", Column::Double(rows.iter().map(|row| row.clearance_m).collect())),
        ("path_length", Column::Double(rows.iter().map(|row| row.path_length).collect())),
        ("duration_s", Column::Double(rows.iter().map(|row| row.duration_s).collect())),
        ("hold_checked", Column::Bool(rows.iter().map(|row| row.hold_checked).collect())),
        ("hold_factor", Column::Double(rows.iter().map(|row| row.hold_factor).collect())),
        ("reason", Column::Text(rows.iter().map(|row| row.reason.clone()).collect())),
    ];
    parquet_file(&columns, &[("format", FORMAT)])
}

/// Returns the file of scenes.
pub(crate) fn scenes_file(rows: &[SceneRow]) -> Vec<u8> {
    let columns = [
        ("scene", Column::Int64(rows.iter().map(|row| row.scene.cast_signed()).collect())),
        ("family", Column::Text(rows.iter().map(|row| row.family.clone()).collect())),
        ("robot", Column::Text(rows.iter().map(|row| row.robot.clone()).collect())),
        ("parameter_m", Column::Double(rows.iter().map(|row| row.parameter_m).collect())),
        ("placement", Column::Doubles(rows.iter().map(|row| row.placement.clone()).collect())),
        ("clutter", Column::Doubles(rows.iter().map(|row| row.clutter.clone()).collect())),
        ("boxes", Column::Floats(rows.iter().map(|row| row.boxes.clone()).collect())),
        ("target_pose", Column::Doubles(rows.iter().map(|row| row.target_pose.clone()).collect())),
        ("start", Column::Doubles(rows.iter().map(|row| row.start.clone()).collect())),
        ("grasp_results", Column::Bytes(rows.iter().map(|row| row.grasp_results.clone()).collect())),
        ("goals", Column::Int64(rows.iter().map(|row| row.goals.cast_signed()).collect())),
        ("rejected", Column::Int64(rows.iter().map(|row| row.rejected.cast_signed()).collect())),
    ];
    parquet_file(&columns, &[("format", FORMAT)])
}

/// Returns the file of pictures.
pub(crate) fn pictures_file(rows: &[Picture]) -> Vec<u8> {
    let columns = [
        ("scene", Column::Int64(rows.iter().map(|row| row.scene.cast_signed()).collect())),
        ("camera", Column::Text(rows.iter().map(|row| row.camera.clone()).collect())),
        ("width", Column::Int64(rows.iter().map(|row| row.width.cast_signed()).collect())),
        ("height", Column::Int64(rows.iter().map(|row| row.height.cast_signed()).collect())),
        ("intrinsics_px", Column::Doubles(rows.iter().map(|row| row.intrinsics_px.clone()).collect())),
        ("pose", Column::Doubles(rows.iter().map(|row| row.pose.clone()).collect())),
        ("depth_png", Column::Bytes(rows.iter().map(|row| row.depth_png.clone()).collect())),
        ("segments_png", Column::Bytes(rows.iter().map(|row| row.segments_png.clone()).collect())),
        ("segments", Column::Texts(rows.iter().map(|row| row.segments.clone()).collect())),
    ];
    parquet_file(&columns, &[("format", FORMAT)])
}

/// Reads a file of pictures.
///
/// # Errors
/// [`DatasetError::Unreadable`], [`DatasetError::Content`].
pub(crate) fn read_pictures(path: &Path) -> Result<Vec<Picture>, DatasetError> {
    let mut table = Columns::read(path)?;
    let mut rows = vec![Picture::default(); table.rows()];
    table.numbers("scene", &mut rows, |row, value| row.scene = value.cast_unsigned())?;
    table.texts("camera", &mut rows, |row, value| row.camera = value)?;
    table.numbers("width", &mut rows, |row, value| row.width = value.cast_unsigned())?;
    table.numbers("height", &mut rows, |row, value| row.height = value.cast_unsigned())?;
    table.lists("intrinsics_px", &mut rows, |row, value| row.intrinsics_px = value)?;
    table.lists("pose", &mut rows, |row, value| row.pose = value)?;
    table.bytes("depth_png", &mut rows, |row, value| row.depth_png = value)?;
    table.bytes("segments_png", &mut rows, |row, value| row.segments_png = value)?;
    let Column::Texts(segments) = table.take("segments")? else { return Err(table.other("segments")) };
    fill(&mut rows, segments, |row, value| row.segments = value);
    Ok(rows)
}

/// Reads a file of demonstrations.
///
/// # Errors
/// [`DatasetError::Unreadable`], [`DatasetError::Content`].
pub(crate) fn read_demonstrations(path: &Path) -> Result<Vec<Demonstration>, DatasetError> {
    let mut table = Columns::read(path)?;
    let mut rows = vec![Demonstration::default(); table.rows()];
    table.numbers("row", &mut rows, |row, value| row.row = value.cast_unsigned())?;
    table.numbers("scene", &mut rows, |row, value| row.scene = value.cast_unsigned())?;
    table.texts("task", &mut rows, |row, value| row.task = value)?;
    table.texts("outcome", &mut rows, |row, value| row.outcome = value)?;
    table.numbers("seed", &mut rows, |row, value| row.seed = value.cast_unsigned())?;
    table.lists("start", &mut rows, |row, value| row.start = value)?;
    table.lists("waypoints", &mut rows, |row, value| row.waypoints = value)?;
    table.lists("times_s", &mut rows, |row, value| row.times_s = value)?;
    let Column::Int32s(segments) = table.take("segments")? else { return Err(table.other("segments")) };
    fill(&mut rows, segments, |row, value| row.segments = value);
    table.lists("openings_m", &mut rows, |row, value| row.openings_m = value)?;
    table.lists("speeds", &mut rows, |row, value| row.speeds = value)?;
    table.lists("uneven_m", &mut rows, |row, value| row.uneven_m = value)?;
    table.numbers("grasp", &mut rows, |row, value| row.grasp = value)?;
    table.lists("grasp_pose", &mut rows, |row, value| row.grasp_pose = value)?;
    table.doubles("load", &mut rows, |row, value| row.load = value)?;
    table.doubles("clearance_m", &mut rows, |row, value| row.clearance_m = value)?;
    table.doubles("path_length", &mut rows, |row, value| row.path_length = value)?;
    table.doubles("duration_s", &mut rows, |row, value| row.duration_s = value)?;
    let Column::Bool(checked) = table.take("hold_checked")? else { return Err(table.other("hold_checked")) };
    fill(&mut rows, checked, |row, value| row.hold_checked = value);
    table.doubles("hold_factor", &mut rows, |row, value| row.hold_factor = value)?;
    table.texts("reason", &mut rows, |row, value| row.reason = value)?;
    Ok(rows)
}

/// Reads a file of scenes.
///
/// # Errors
/// [`DatasetError::Unreadable`], [`DatasetError::Content`].
pub(crate) fn read_scenes(path: &Path) -> Result<Vec<SceneRow>, DatasetError> {
    let mut table = Columns::read(path)?;
    let mut rows = vec![SceneRow::default(); table.rows()];
    table.numbers("scene", &mut rows, |row, value| row.scene = value.cast_unsigned())?;
    table.texts("family", &mut rows, |row, value| row.family = value)?;
    table.texts("robot", &mut rows, |row, value| row.robot = value)?;
    table.doubles("parameter_m", &mut rows, |row, value| row.parameter_m = value)?;
    table.lists("placement", &mut rows, |row, value| row.placement = value)?;
    table.lists("clutter", &mut rows, |row, value| row.clutter = value)?;
    let Column::Floats(boxes) = table.take("boxes")? else { return Err(table.other("boxes")) };
    fill(&mut rows, boxes, |row, value| row.boxes = value);
    table.lists("target_pose", &mut rows, |row, value| row.target_pose = value)?;
    table.lists("start", &mut rows, |row, value| row.start = value)?;
    table.bytes("grasp_results", &mut rows, |row, value| row.grasp_results = value)?;
    table.numbers("goals", &mut rows, |row, value| row.goals = value.cast_unsigned())?;
    table.numbers("rejected", &mut rows, |row, value| row.rejected = value.cast_unsigned())?;
    Ok(rows)
}

fn fill<R, T>(rows: &mut [R], values: Vec<T>, mut set: impl FnMut(&mut R, T)) {
    for (row, value) in rows.iter_mut().zip(values) {
        set(row, value);
    }
}

/// Columns of a file that are not yet taken.
struct Columns<'a> {
    path: &'a Path,
    table: Table,
}

impl<'a> Columns<'a> {
    fn read(path: &'a Path) -> Result<Self, DatasetError> {
        let bytes = cranny_file::TABLE
            .bytes(path)
            .map_err(|reason| DatasetError::Unreadable { path: path.to_owned(), reason })?;
        let fault = |problem| DatasetError::Content { path: path.to_owned(), problem };
        Ok(Self { path, table: read_parquet(&bytes).map_err(fault)? })
    }

    fn rows(&self) -> usize {
        self.table.first().map_or(0, |(_, column)| column.len())
    }

    fn take(&mut self, name: &str) -> Result<Column, DatasetError> {
        let place = self.table.iter().position(|(known, _)| known == name);
        let missing = || self.fault(format!("column '{name}' is missing"));
        let place = place.ok_or_else(missing)?;
        Ok(self.table.swap_remove(place).1)
    }

    fn fault(&self, problem: String) -> DatasetError {
        DatasetError::Content { path: self.path.to_owned(), problem }
    }

    fn other(&self, name: &str) -> DatasetError {
        self.fault(format!("column '{name}' holds values of another type"))
    }

    fn numbers<R>(
        &mut self,
        name: &str,
        rows: &mut [R],
        set: impl FnMut(&mut R, i64),
    ) -> Result<(), DatasetError> {
        let Column::Int64(values) = self.take(name)? else { return Err(self.other(name)) };
        fill(rows, values, set);
        Ok(())
    }

    fn doubles<R>(
        &mut self,
        name: &str,
        rows: &mut [R],
        set: impl FnMut(&mut R, f64),
    ) -> Result<(), DatasetError> {
        let Column::Double(values) = self.take(name)? else { return Err(self.other(name)) };
        fill(rows, values, set);
        Ok(())
    }

    fn texts<R>(
        &mut self,
        name: &str,
        rows: &mut [R],
        set: impl FnMut(&mut R, String),
    ) -> Result<(), DatasetError> {
        let Column::Text(values) = self.take(name)? else { return Err(self.other(name)) };
        fill(rows, values, set);
        Ok(())
    }

    fn lists<R>(
        &mut self,
        name: &str,
        rows: &mut [R],
        set: impl FnMut(&mut R, Vec<f64>),
    ) -> Result<(), DatasetError> {
        let Column::Doubles(values) = self.take(name)? else { return Err(self.other(name)) };
        fill(rows, values, set);
        Ok(())
    }

    fn bytes<R>(
        &mut self,
        name: &str,
        rows: &mut [R],
        set: impl FnMut(&mut R, Vec<u8>),
    ) -> Result<(), DatasetError> {
        let Column::Bytes(values) = self.take(name)? else { return Err(self.other(name)) };
        fill(rows, values, set);
        Ok(())
    }
}
