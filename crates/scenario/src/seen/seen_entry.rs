use std::fmt::Write as _;
use std::path::PathBuf;

use cranny_sense::Unseen;
use cranny_shape::Aabb;
use cranny_spatial::Point;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::seen::seen_space::SeenOptions;

/// Views of depth cameras as obstacles. Positions are in the frame of the robot's root.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SeenEntry {
    /// Folder with a `views.yaml`, or such a file, relative to the folder of this file.
    pub views: PathBuf,
    /// Treatment of space that no camera has seen. Default: solid.
    pub unseen: Option<UnseenName>,
    /// Side of the smallest cells of the map (m). Default: 0.01.
    pub cell_m: Option<f64>,
    /// Region that is mapped; all other space is unseen. Default: 0.5 m around the robot at its start and the target.
    pub region: Option<RegionEntry>,
    /// Distance from the robot at its start within which unseen space counts as free (m). Default: 0.06.
    pub robot_reach_m: Option<f64>,
    /// The same for the floor. Default: 0.06.
    pub floor_reach_m: Option<f64>,
    /// Error of the pose of the target (m): surfaces and unseen cells within it are those of the target. Default: 0.002.
    pub target_tolerance_m: Option<f64>,
}

/// Treatment of unseen space.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum UnseenName {
    Solid,
    Free,
}

/// Box by its least and greatest coordinates (m).
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RegionEntry {
    pub low: [f64; 3],
    pub high: [f64; 3],
}

impl SeenEntry {
    /// Returns the options of the map; the views are in the folder of the file.
    pub fn options(&self) -> SeenOptions {
        let default = SeenOptions::default();
        let region = |RegionEntry { low, high }: RegionEntry| {
            let (low, high) = (Point::from(low), Point::from(high));
            Aabb { center: low + (high - low) * 0.5, half_extents: (high - low) * 0.5 }
        };
        SeenOptions {
            unseen: match self.unseen {
                Some(UnseenName::Free) => Unseen::Free,
                Some(UnseenName::Solid) | None => Unseen::Solid,
            },
            cell_m: self.cell_m.unwrap_or(default.cell_m),
            region: self.region.map(region),
            robot_reach_m: self.robot_reach_m.unwrap_or(default.robot_reach_m),
            floor_reach_m: self.floor_reach_m.unwrap_or(default.floor_reach_m),
            target_tolerance_m: self.target_tolerance_m.unwrap_or(default.target_tolerance_m),
        }
    }
}

impl SeenOptions {
    /// Returns the text of the key `seen` for views in the folder of the scenario; options with their defaults are left out.
    pub(crate) fn yaml(&self) -> String {
        let default = Self::default();
        let mut text = "seen:\n  views: .\n".to_owned();
        if self.unseen != default.unseen {
            text.push_str("  unseen: free\n");
        }
        if let Some(region) = self.region {
            let list = |point: Point| format!("[{}, {}, {}]", point.x, point.y, point.z);
            let _ =
                writeln!(text, "  region: {{low: {}, high: {}}}", list(region.low()), list(region.high()));
        }
        for (key, value, default) in [
            ("cell_m", self.cell_m, default.cell_m),
            ("robot_reach_m", self.robot_reach_m, default.robot_reach_m),
            ("floor_reach_m", self.floor_reach_m, default.floor_reach_m),
            ("target_tolerance_m", self.target_tolerance_m, default.target_tolerance_m),
        ] {
            if (value - default).abs() > 0.0 {
                let _ = writeln!(text, "  {key}: {value}");
            }
        }
        text
    }
}
