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
    /// Side of the smallest cells of the map (m). Default: 0.02.
    pub cell_m: Option<f64>,
    /// The same within 8 cm of the target (m). Default: 0.005.
    pub fine_m: Option<f64>,
    /// Region that is mapped; all other space is unseen. Default: 0.5 m around the robot at its start and the target.
    pub region: Option<RegionEntry>,
    /// Distance from the robot at its start within which unseen space counts as free (m). Default: 0.1.
    pub robot_reach_m: Option<f64>,
    /// The same above the floor, also where no camera sees it. Default: 0.
    pub floor_reach_m: Option<f64>,
    /// Error of the poses of the target and of the obstacles of this file (m): surfaces and unseen cells within it are theirs. Default:
    /// 0.002.
    pub tolerance_m: Option<f64>,
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
            fine_m: self.fine_m.unwrap_or(default.fine_m),
            region: self.region.map(region),
            robot_reach_m: self.robot_reach_m.unwrap_or(default.robot_reach_m),
            floor_reach_m: self.floor_reach_m.unwrap_or(default.floor_reach_m),
            tolerance_m: self.tolerance_m.unwrap_or(default.tolerance_m),
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
            ("fine_m", self.fine_m, default.fine_m),
            ("robot_reach_m", self.robot_reach_m, default.robot_reach_m),
            ("floor_reach_m", self.floor_reach_m, default.floor_reach_m),
            ("tolerance_m", self.tolerance_m, default.tolerance_m),
        ] {
            if (value - default).abs() > 0.0 {
                let _ = writeln!(text, "  {key}: {value}");
            }
        }
        text
    }
}
