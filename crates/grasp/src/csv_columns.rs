/// Columns of a `grasps.csv`, in the order in which they are written and, without a header, read.
pub const COLUMNS: [&str; 21] = [
    "t00",
    "t01",
    "t02",
    "t03",
    "t10",
    "t11",
    "t12",
    "t13",
    "t20",
    "t21",
    "t22",
    "t23",
    "t30",
    "t31",
    "t32",
    "t33",
    "score",
    "width_m",
    "robust_score",
    "robust_trials",
    "load",
];

/// Number of columns that every file has: those of the pose.
pub const POSE_COLUMNS: usize = 16;
