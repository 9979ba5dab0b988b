use std::fmt::Write as _;

use crate::report::number_text::{percent, table_seconds};
use crate::report::{Row, Summary};
use cranny_file::counted;

/// Trials of one criterion in the layout of the paper's Table I. Each line is a scenario, with the number of its goals and
/// of those ever solved. Each column is a planner, with success in percent, and mean and standard deviation of the time in
/// seconds; a failure counts with its limit. A planner that runs on each goal shows its best goal, or none if no goal was
/// ever solved.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperTable<'a> {
    /// Criterion for a solved trial.
    pub criterion: &'a str,
    /// Columns of the planners.
    pub columns: Vec<Column<'a>>,
    /// Lines of the scenarios.
    pub lines: Vec<Line<'a>>,
}

/// Column of a planner.
#[derive(Clone, Debug, PartialEq)]
pub struct Column<'a> {
    /// Name of the planner, as in [`Row::planner_name`].
    pub planner_name: &'a str,
    /// Time limit of most of its runs, in seconds.
    pub time_limit_s: f64,
    /// Minimum and maximum number of runs in a cell.
    pub runs: (usize, usize),
}

/// Line of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Line<'a> {
    /// Name of the scenario, as in [`Row::scenario_name`].
    pub scenario_name: &'a str,
    /// Number of known goals (`|G_IK|`), or otherwise of goals aimed at.
    pub goals: Option<usize>,
    /// Number of goals solved at least once.
    pub goals_solved: Option<usize>,
    /// Row of the summary with its index, for each column.
    pub cells: Vec<Option<(usize, &'a Row)>>,
}

impl<'a> PaperTable<'a> {
    /// Creates the table of one criterion.
    pub fn of(summary: &'a Summary, criterion: &'a str) -> Self {
        let rows = || summary.rows.iter().enumerate().filter(|(_, row)| row.criterion == criterion);
        let distinct = |name: fn(&'a Row) -> &'a str| {
            let mut names: Vec<&str> = rows().map(|(_, row)| name(row)).collect();
            names.sort_unstable();
            names.dedup();
            names
        };
        let column = |name: &'a str| {
            let of_planner: Vec<&Row> =
                rows().map(|(_, row)| row).filter(|row| row.planner_name == name).collect();
            Column::of(name, &of_planner)
        };
        let mut names = distinct(|row| &row.planner_name);
        // As in the paper, planners that aim at single goals come last.
        names.sort_by_key(|name| rows().any(|(_, row)| row.planner_name == *name && row.goals.is_some()));
        let columns: Vec<Column> = names.into_iter().map(column).collect();
        let line = |scenario_name: &'a str| {
            let of_scenario = || rows().filter(|(_, row)| row.scenario_name == scenario_name);
            let cell =
                |column: &Column| of_scenario().find(|(_, row)| row.planner_name == column.planner_name);
            let goal_wise = || of_scenario().filter_map(|(_, row)| Some((row.goals?, row.goals_solved?)));
            let known = summary.known_goals.get(scenario_name).copied();
            let goals = known.or_else(|| goal_wise().map(|(goals, _)| goals).max());
            Line {
                scenario_name,
                goals,
                goals_solved: goal_wise()
                    .map(|(_, solved)| solved)
                    .max()
                    .or(goals.filter(|&goals| goals == 0)),
                cells: columns.iter().map(cell).collect(),
            }
        };
        let lines = distinct(|row| &row.scenario_name).into_iter().map(line).collect();
        Self { criterion, columns, lines }
    }

    /// Returns true if any planner runs on single goals.
    pub fn has_goals(&self) -> bool {
        self.lines.iter().flat_map(|line| line.cells.iter().flatten()).any(|(_, row)| row.goals.is_some())
    }

    /// Formats the table in Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        let goals = if self.has_goals() { " goals |" } else { "" };
        let names: Vec<String> = self
            .columns
            .iter()
            .map(|column| format!(" {} |", column.planner_name.replace('|', "\\|")))
            .collect();
        let _ = writeln!(text, "| scenario |{goals}{}", names.concat());
        let rule = "---|".repeat(1 + usize::from(self.has_goals()) + self.columns.len());
        let _ = writeln!(text, "|{rule}");
        for line in &self.lines {
            let goals = if self.has_goals() { format!(" {} |", line.goals_text()) } else { String::new() };
            let cells: Vec<String> = self.cell_texts(line).map(|cell| format!(" {cell} |")).collect();
            let _ = writeln!(text, "| {} |{goals}{}", line.scenario_name.replace('|', "\\|"), cells.concat());
        }
        let _ = writeln!(text, "\n{}", self.note());
        text
    }

    /// Formats the table in LaTeX; it needs the package `booktabs`.
    pub fn latex(&self) -> String {
        let mut text = String::new();
        let goals = usize::from(self.has_goals());
        let alignment = format!("l{}{}", "c".repeat(goals), "r".repeat(self.columns.len()));
        let goal_head = if goals == 1 { " & $|G_{\\mathrm{IK}}|$/solved" } else { "" };
        let names: Vec<String> =
            self.columns.iter().map(|column| format!(" & {}", latex_text(column.planner_name))).collect();
        let _ = writeln!(text, "% {}", self.note());
        let _ = writeln!(text, "\\begin{{tabular}}{{{alignment}}}\n\\toprule");
        let _ = writeln!(text, "scenario{goal_head}{} \\\\\n\\midrule", names.concat());
        for line in &self.lines {
            let goals =
                if goals == 1 { format!(" & {}", latex_text(&line.goals_text())) } else { String::new() };
            let cells: Vec<String> =
                self.cell_texts(line).map(|cell| format!(" & {}", latex_text(&cell))).collect();
            let _ = writeln!(text, "{}{goals}{} \\\\", latex_text(line.scenario_name), cells.concat());
        }
        text.push_str("\\bottomrule\n\\end{tabular}\n");
        text
    }

    /// Returns the figures of the table with all their digits as CSV, a line for each cell, with the header
    /// `criterion,scenario,goals,goals_solved,planner,goal,runs,solved,success_percent,mean_s,std_s,time_limit_s`.
    pub fn csv_lines(&self) -> String {
        let mut text = String::new();
        let number = |count: Option<usize>| count.map_or_else(String::new, |count| count.to_string());
        for line in &self.lines {
            for (column, cell) in self.columns.iter().zip(&line.cells) {
                let Some((_, row)) = cell else { continue };
                let fields = [
                    self.criterion.to_owned(),
                    line.scenario_name.to_owned(),
                    number(line.goals),
                    number(line.goals_solved),
                    column.planner_name.to_owned(),
                    number(row.goal),
                    row.runs.to_string(),
                    row.solved.to_string(),
                    (row.success_rate * 100.0).to_string(),
                    row.mean_s.to_string(),
                    row.std_s.map_or_else(String::new, |std_s| std_s.to_string()),
                    row.time_limit_s.to_string(),
                ];
                let fields: Vec<String> = fields.iter().map(|field| csv_field(field)).collect();
                let _ = writeln!(text, "{}", fields.join(","));
            }
        }
        text
    }

    /// Returns the text of each cell, such as `91: 10.53/33.90`.
    fn cell_texts<'b>(&'b self, line: &'b Line) -> impl Iterator<Item = String> + 'b {
        self.columns.iter().zip(&line.cells).map(|(column, cell)| match cell {
            Some((_, row)) if shown(row) => {
                let std_s = row.std_s.map_or_else(|| "–".to_owned(), table_seconds);
                format!(
                    "{}: {}/{std_s}{}",
                    percent(row.success_rate),
                    table_seconds(row.mean_s),
                    column.other_limit(row)
                )
            }
            _ => "–".to_owned(),
        })
    }

    /// Returns the heading of the table: meaning of the cells, runs and limits.
    pub fn note(&self) -> String {
        let column = |column: &Column| {
            let runs = match column.runs {
                (least, most) if least == most => counted(least, "run"),
                (least, most) => format!("{least} to {most} runs"),
            };
            format!("{}: {runs}, limit {} s", column.planner_name, column.time_limit_s)
        };
        let columns: Vec<String> = self.columns.iter().map(column).collect();
        let goals = if self.has_goals() { " Goals: |G_IK| / ever solved." } else { "" };
        format!(
            "Criterion {}. Success %: mean/standard deviation of the time in s, a failure counted as the limit.{goals} {}.",
            self.criterion,
            columns.join("; ")
        )
    }
}

impl<'a> Column<'a> {
    fn of(planner_name: &'a str, rows: &[&Row]) -> Self {
        let mut limits_s: Vec<f64> = rows.iter().map(|row| row.time_limit_s).collect();
        limits_s.sort_by(f64::total_cmp);
        let runs = || rows.iter().map(|row| row.runs);
        Self {
            planner_name,
            // The median of the limits is the limit of most rows.
            time_limit_s: limits_s.get(limits_s.len() / 2).copied().unwrap_or(0.0),
            runs: (runs().min().unwrap_or(0), runs().max().unwrap_or(0)),
        }
    }

    /// Returns ` (limit 900 s)` if the limit of a cell differs from that of the column.
    pub fn other_limit(&self, row: &Row) -> String {
        if row.time_limit_s.total_cmp(&self.time_limit_s).is_eq() {
            String::new()
        } else {
            format!(" (limit {} s)", row.time_limit_s)
        }
    }
}

impl Line<'_> {
    /// Returns the numbers of goals and of goals ever solved, such as `8/0`.
    pub fn goals_text(&self) -> String {
        let number = |count: Option<usize>| count.map_or_else(|| "–".to_owned(), |count| count.to_string());
        if self.goals.is_none() {
            "–".to_owned()
        } else {
            format!("{}/{}", number(self.goals), number(self.goals_solved))
        }
    }
}

/// Returns true if the table shows the row; as in the paper, a row without a solved goal is omitted.
pub fn shown(row: &Row) -> bool {
    row.goals_solved != Some(0)
}

/// Header of [`PaperTable::csv_lines`].
pub const CSV_HEADER: &str = "criterion,scenario,goals,goals_solved,planner,goal,runs,solved,success_percent,mean_s,std_s,\
                              time_limit_s";

fn csv_field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

fn latex_text(text: &str) -> String {
    let letter = |letter: char| match letter {
        '\\' => "\\textbackslash{}".to_owned(),
        '&' | '%' | '$' | '#' | '_' | '{' | '}' => format!("\\{letter}"),
        '~' => "\\textasciitilde{}".to_owned(),
        '^' => "\\textasciicircum{}".to_owned(),
        '–' => "--".to_owned(),
        '⁺' => "$^{+}$".to_owned(),
        other => other.to_string(),
    };
    text.chars().map(letter).collect()
}

impl Summary {
    /// Formats the paper's tables in Markdown, one for each criterion.
    pub fn markdown(&self) -> String {
        self.tables().iter().map(PaperTable::markdown).collect::<Vec<_>>().join("\n")
    }

    /// Formats the paper's tables in LaTeX, one for each criterion.
    pub fn latex(&self) -> String {
        self.tables().iter().map(PaperTable::latex).collect::<Vec<_>>().join("\n")
    }

    /// Formats all tables as a single CSV table.
    pub fn csv(&self) -> String {
        let lines: Vec<String> = self.tables().iter().map(PaperTable::csv_lines).collect();
        format!("{CSV_HEADER}\n{}", lines.concat())
    }

    fn tables(&self) -> Vec<PaperTable<'_>> {
        self.criteria().into_iter().map(|criterion| PaperTable::of(self, criterion)).collect()
    }
}
