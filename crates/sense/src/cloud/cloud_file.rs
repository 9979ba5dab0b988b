use std::path::Path;

use cranny_file::TABLE;

use crate::cloud::read_cloud::ReadCloud;
use crate::cloud::{npy, pcd, ply};
use crate::{PointCloud, SenseError};

impl PointCloud {
    /// Reads a point cloud: PLY (text or binary), PCD of version 0.7 (text, binary or compressed), or a `NumPy` array of shape
    /// (n, 3) or (rows, columns, 3). The content decides, not the ending of the name. Points with a coordinate that is not finite
    /// are dropped and counted.
    ///
    /// # Errors
    /// [`SenseError::Unreadable`]; [`SenseError::Content`] for another format, a header that does not fit the data, data that is
    /// cut short or too long, coordinates beyond 1000 m, or no valid point.
    pub fn read(path: &Path) -> Result<ReadCloud, SenseError> {
        let bytes =
            TABLE.bytes(path).map_err(|reason| SenseError::Unreadable { path: path.to_owned(), reason })?;
        Self::of_bytes(&bytes).map_err(|problem| SenseError::content(path, problem))
    }

    /// Reads a point cloud from the bytes of a file, as [`Self::read`] does.
    ///
    /// # Errors
    /// A sentence on the fault.
    pub fn of_bytes(bytes: &[u8]) -> Result<ReadCloud, String> {
        if bytes.starts_with(b"ply") {
            ply::read(bytes)
        } else if bytes.starts_with(b"\x93NUMPY") {
            npy::read(bytes)
        } else if pcd::is_pcd(bytes) {
            pcd::read(bytes)
        } else {
            Err("no point cloud that is read: PLY, PCD or a NumPy array".to_owned())
        }
    }
}
