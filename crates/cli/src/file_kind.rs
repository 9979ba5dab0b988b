//! Kinds of files, recognised by their first bytes.

/// Kind of a file that a command writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// Output of `cranny plan`.
    Plan,
    /// Output of `cranny roadmap`.
    Roadmap,
    /// Output of `cranny plan --rate`.
    Trajectory,
    /// One configuration per line, comma-separated.
    Waypoints,
    /// One line of 16 to 20 numbers per grasp, usually below a header.
    Grasps,
    /// PNG image, possibly animated.
    Png,
    /// Animated GIF.
    Gif,
    /// Film in the MP4 format.
    Mp4,
    /// SVG drawing.
    Svg,
    /// PDF drawing for print.
    Pdf,
    /// Binary glTF.
    Glb,
    /// Page of `cranny view` in one file.
    ViewerPage,
    /// Page of `cranny bench report`.
    ReportPage,
    /// Figures of a report.
    ReportJson,
    /// The paper's table in LaTeX.
    LatexTable,
    /// The paper's table in Markdown.
    MarkdownTable,
    /// The paper's table as CSV.
    CsvTable,
    /// Benchmark log of OMPL.
    OmplLog,
    /// Scenario in one file.
    Archive,
    /// Output of `cranny simulate grasps --record`: trajectories of bodies.
    Recording,
    /// Output of `cranny simulate export`.
    Experiment,
    /// Model of an experiment in MuJoCo's XML.
    Mjcf,
    /// Output of `cranny man`.
    Manual,
    /// Output of `cranny certify`.
    Certificate,
    /// File that lists the views of a folder.
    Views,
    /// Array of `NumPy`.
    Npy,
    /// Point cloud of the Point Cloud Library.
    Pcd,
    /// Progress of a campaign.
    Progress,
    /// Partial result of a computation that was stopped.
    Unfinished,
}

impl FileKind {
    /// Number of bytes that suffice to recognise the kind of a file.
    pub const HEAD_BYTES: u64 = 4096;

    /// Returns the name of the kind in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan file",
            Self::Roadmap => "roadmap",
            Self::Trajectory => "trajectory",
            Self::Waypoints => "file of way points",
            Self::Grasps => "file of grasps",
            Self::Png => "PNG picture",
            Self::Gif => "GIF picture",
            Self::Mp4 => "MP4 film",
            Self::Svg => "SVG drawing",
            Self::Pdf => "PDF drawing",
            Self::Glb => "binary glTF",
            Self::ViewerPage => "page of Cranny's viewer",
            Self::ReportPage => "page of a benchmark report",
            Self::ReportJson => "benchmark report in JSON",
            Self::LatexTable => "LaTeX table of a benchmark report",
            Self::MarkdownTable => "Markdown table of a benchmark report",
            Self::CsvTable => "CSV table of a benchmark report",
            Self::OmplLog => "OMPL benchmark log",
            Self::Archive => "packed scenario",
            Self::Recording => "recording",
            Self::Experiment => "simulated experiment",
            Self::Mjcf => "MJCF model",
            Self::Manual => "manual page of Cranny",
            Self::Certificate => "certificate",
            Self::Views => "file of views",
            Self::Npy => "NumPy array",
            Self::Pcd => "PCD point cloud",
            Self::Progress => "progress of a campaign",
            Self::Unfinished => "finished part of a stopped command",
        }
    }

    /// Returns true if a file that begins with `head` is of this kind. PNG, GIF, MP4, SVG, PDF, glTF and arrays of `NumPy` match files of any
    /// program,
    /// the other kinds only files of Cranny.
    pub fn is_that_of(self, head: &[u8]) -> bool {
        let text = String::from_utf8_lossy(head);
        let text = text.trim_start();
        let is_object_with = |keys: &[&str]| {
            text.starts_with('{') && keys.iter().all(|key| text.contains(&format!("\"{key}\"")))
        };
        let is_page_with = |mark: &str| {
            let begin: String = text.chars().take(14).collect();
            begin.eq_ignore_ascii_case("<!doctype html") && text.contains(mark)
        };
        match self {
            Self::Plan => is_object_with(&["scenario", "planner"]),
            Self::Roadmap => is_object_with(&["format"]) && text.contains("\"cranny-roadmap/"),
            Self::Trajectory => text.starts_with("time_s,"),
            Self::Waypoints => numbers(text) > 0,
            Self::Grasps => text.starts_with("t00,t01,") || (16..=20).contains(&numbers(text)),
            Self::Png => head.starts_with(b"\x89PNG\r\n\x1a\n"),
            Self::Gif => head.starts_with(b"GIF8"),
            // The length of the first box, then its kind (ISO/IEC 14496-12, §4.3).
            Self::Mp4 => head.get(4..8) == Some(b"ftyp"),
            Self::Svg => (text.starts_with("<svg") || text.starts_with("<?xml")) && text.contains("<svg"),
            Self::Pdf => head.starts_with(b"%PDF-"),
            Self::Glb => head.starts_with(b"glTF"),
            Self::ViewerPage => is_page_with("<title>Cranny</title>"),
            Self::ReportPage => is_page_with("<title>Benchmark report: "),
            Self::ReportJson => is_object_with(&["results", "version", "trials", "warnings"]),
            Self::LatexTable => text.starts_with('%') && text.contains("\\begin{tabular}"),
            Self::MarkdownTable => text.starts_with("| scenario |"),
            Self::CsvTable => text.starts_with("criterion,scenario,goals,"),
            Self::Recording => is_object_with(&["format"]) && text.contains("\"cranny-recording/"),
            Self::Experiment => is_object_with(&["object", "mjcf"]),
            Self::Mjcf => text.starts_with("<mujoco"),
            Self::Certificate => text.starts_with("cranny-certificate/"),
            Self::Views => text.starts_with("format: cranny-views/"),
            Self::Pcd => text.starts_with("# .PCD"),
            Self::Npy => head.starts_with(b"\x93NUMPY"),
            Self::Manual => text.starts_with('.') && text.contains(".TH cranny"),
            Self::Progress => is_object_with(&["trials", "planners", "elapsed_s"]),
            Self::Unfinished => is_object_with(&["format"]) && text.contains("\"cranny-unfinished/"),
            // `OMPL version 1.7`, or that of another library, then the experiment.
            Self::OmplLog => {
                let mut lines = text.lines();
                lines.next().is_some_and(|line| line.contains(" version "))
                    && lines.next().is_some_and(|line| line.starts_with("Experiment "))
            }
            // A zip archive whose first file is the manifest; the header of that entry is 30 bytes long.
            Self::Archive => {
                head.starts_with(b"PK\x03\x04")
                    && head.get(30..).is_some_and(|rest| rest.starts_with(b"manifest.json"))
            }
        }
    }
}

/// Returns the number of comma-separated numbers on the first line, whose last field may be empty; 0 for other content.
fn numbers(text: &str) -> usize {
    let line = text.lines().next().unwrap_or_default();
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    let is_number = |field: &str| field.parse::<f64>().is_ok();
    let is_table =
        fields.iter().enumerate().all(|(at, field)| is_number(field) || (at >= 16 && field.is_empty()));
    if is_table { fields.len() } else { 0 }
}
