use serde::Serialize;

use crate::{SceneMotion, Track, viewer::number_row};

/// Motions of bodies in the encoding of the page.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct RecordingRows {
    times_s: String,
    tracks: Vec<TrackRow>,
}

#[derive(Clone, Debug, Serialize)]
struct TrackRow {
    node: usize,
    poses: String,
}

impl RecordingRows {
    pub fn of(motion: &SceneMotion) -> Self {
        let track = |track: &Track| TrackRow {
            node: track.node,
            poses: number_row::floats64(track.poses.iter().flat_map(number_row::pose)),
        };
        Self {
            times_s: number_row::floats64(motion.times_s.iter().copied()),
            tracks: motion.tracks.iter().map(track).collect(),
        }
    }
}
