use crate::GraspError;
use crate::csv_columns::{COLUMNS, POSE_COLUMNS};

/// Position of each of the [`COLUMNS`] in the lines of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CsvHeader {
    places: [Option<usize>; COLUMNS.len()],
    /// Number of columns that the header names; `None` without a header.
    named: Option<usize>,
}

impl CsvHeader {
    /// Column order of a file without a header.
    pub fn absent() -> Self {
        Self { places: std::array::from_fn(Some), named: None }
    }

    /// Column order of a header line; `None` for a line with a number, which is no header. `NumPy` writes `# ` before it.
    ///
    /// # Errors
    /// [`GraspError::UnknownColumn`], [`GraspError::RepeatedColumn`], [`GraspError::MissingColumn`].
    pub fn of(line: &str) -> Result<Option<Self>, GraspError> {
        let line = line.trim().trim_start_matches('\u{feff}');
        let names = || line.strip_prefix('#').unwrap_or(line).split(',').map(str::trim);
        if names().any(|name| name.parse::<f64>().is_ok()) || names().all(str::is_empty) {
            return Ok(None);
        }
        let mut places = [None; COLUMNS.len()];
        let mut named = 0;
        for (place, name) in names().enumerate() {
            let column = place + 1;
            let Some(known) = COLUMNS.iter().position(|known| *known == name) else {
                return Err(GraspError::UnknownColumn { column, name: cranny_file::excerpt(name) });
            };
            if let Some(first) = places[known].replace(place) {
                return Err(GraspError::RepeatedColumn { name: COLUMNS[known], first: first + 1, column });
            }
            named = column;
        }
        match places[..POSE_COLUMNS].iter().position(Option::is_none) {
            Some(missing) => Err(GraspError::MissingColumn { name: COLUMNS[missing] }),
            None => Ok(Some(Self { places, named: Some(named) })),
        }
    }

    /// Position of one of the [`COLUMNS`] in a line, if the file has it.
    pub fn place(&self, column: usize) -> Option<usize> {
        self.places[column]
    }

    /// Checks the number of fields of a line: as many as the header names, or fewer if those after the pose are left out.
    pub fn check_count(&self, actual: usize) -> Result<(), GraspError> {
        let needed = self.places[..POSE_COLUMNS].iter().flatten().max().map_or(POSE_COLUMNS, |last| last + 1);
        match self.named {
            None if !(POSE_COLUMNS..=COLUMNS.len()).contains(&actual) => {
                Err(GraspError::NumberCount { actual })
            }
            Some(named) if !(needed..=named).contains(&actual) => {
                Err(GraspError::ColumnCount { actual, named })
            }
            _ => Ok(()),
        }
    }
}
