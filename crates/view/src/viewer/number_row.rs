//! Numbers in the encoding of the page: base64 (RFC 4648) of little-endian values.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use cranny_spatial::Pose;

pub(crate) fn floats64(values: impl IntoIterator<Item = f64>) -> String {
    STANDARD.encode(values.into_iter().flat_map(f64::to_le_bytes).collect::<Vec<u8>>())
}

pub(crate) fn floats32(values: impl IntoIterator<Item = f32>) -> String {
    STANDARD.encode(values.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}

pub(crate) fn unsigned32(values: impl IntoIterator<Item = u32>) -> String {
    STANDARD.encode(values.into_iter().flat_map(u32::to_le_bytes).collect::<Vec<u8>>())
}

/// Converts to the precision of graphics.
#[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}

/// Converts an index; every scene has far fewer entries than the maximum.
pub(crate) fn index(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

/// Returns a pose as `[x, y, z, qx, qy, qz, qw]`, target-from-source.
pub(crate) fn pose(pose: &Pose) -> [f64; 7] {
    let (t, q) = (&pose.translation.vector, &pose.rotation.coords);
    [t.x, t.y, t.z, q.x, q.y, q.z, q.w]
}
