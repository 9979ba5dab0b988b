use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::report::number_text::{percent, table_seconds};
use crate::report::{Row, Summary};
use cranny_file::{counted, visible_line};

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
        let mut of_planner: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
        let mut of_scenario: BTreeMap<&str, BTreeMap<&str, (usize, &Row)>> = BTreeMap::new();
        for (index, row) in rows() {
            of_planner.entry(&row.planner_name).or_default().push(row);
            let cells = of_scenario.entry(&row.scenario_name).or_default();
            cells.entry(&row.planner_name).or_insert((index, row));
        }
        let mut columns: Vec<(bool, Column)> = of_planner
            .into_iter()
            .map(|(name, rows)| (rows.iter().any(|row| row.goals.is_some()), Column::of(name, &rows)))
            .collect();
        // As in the paper, planners that aim at single goals come last.
        columns.sort_by_key(|(is_goal_wise, _)| *is_goal_wise);
        let columns: Vec<Column> = columns.into_iter().map(|(_, column)| column).collect();
        let line = |(scenario_name, cells): (&'a str, BTreeMap<&'a str, (usize, &'a Row)>)| {
            let goal_wise = || cells.values().filter_map(|(_, row)| Some((row.goals?, row.goals_solved?)));
            let known = summary.known_goals.get(scenario_name).copied();
            let goals = known.or_else(|| goal_wise().map(|(goals, _)| goals).max());
            Line {
                scenario_name,
                goals,
                goals_solved: goal_wise()
                    .map(|(_, solved)| solved)
                    .max()
                    .or(goals.filter(|&goals| goals == 0)),
                cells: columns.iter().map(|column| cells.get(column.planner_name).copied()).collect(),
            }
        };
        let lines = of_scenario.into_iter().map(line).collect();
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
        let names: Vec<String> =
            self.columns.iter().map(|column| format!(" {} |", markdown_text(column.planner_name))).collect();
        let _ = writeln!(text, "| scenario |{goals}{}", names.concat());
        let rule = "---|".repeat(1 + usize::from(self.has_goals()) + self.columns.len());
        let _ = writeln!(text, "|{rule}");
        for line in &self.lines {
            let goals = if self.has_goals() { format!(" {} |", line.goals_text()) } else { String::new() };
            let cells: Vec<String> = self.cell_texts(line).map(|cell| format!(" {cell} |")).collect();
            let _ = writeln!(text, "| {} |{goals}{}", markdown_text(line.scenario_name), cells.concat());
        }
        let _ = writeln!(text, "\n{}", markdown_text(&self.note()));
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
        let _ = writeln!(text, "% {}", visible_line(&self.note()));
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
                    csv_text(self.criterion),
                    csv_text(line.scenario_name),
                    number(line.goals),
                    number(line.goals_solved),
                    csv_text(column.planner_name),
                    number(row.goal),
                    row.runs.to_string(),
                    row.solved.to_string(),
                    (row.success_rate * 100.0).to_string(),
                    row.mean_s.to_string(),
                    row.std_s.map_or_else(String::new, |std_s| std_s.to_string()),
                    row.time_limit_s.to_string(),
                ];
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

/// Returns a text as a field of CSV. A spreadsheet takes a field that begins like a formula for one and evaluates it, quoted or
/// not: an apostrophe before it makes it a text.
///
/// Source: OWASP, "CSV Injection", whole.
fn csv_text(text: &str) -> String {
    let text = visible_line(text);
    let mark = if text.trim_start().starts_with(['=', '+', '-', '@', '＝', '＋', '－', '＠']) {
        "'"
    } else {
        ""
    };
    if text.contains([',', ';', '"']) {
        format!("\"{mark}{}\"", text.replace('"', "\"\""))
    } else {
        format!("{mark}{text}")
    }
}

/// Escapes what Markdown takes for markup within a line or a cell.
///
/// Source: `CommonMark` 0.31, §2.4; GitHub Flavored Markdown, §4.10.
fn markdown_text(text: &str) -> String {
    let letter = |letter: char| match letter {
        '\\' | '`' | '*' | '_' | '[' | ']' | '<' | '>' | '|' | '~' | '$' | '&' => format!("\\{letter}"),
        other => other.to_string(),
    };
    visible_line(text).chars().map(letter).collect()
}

/// Escapes what LaTeX takes for a command, and what its default font shows as another letter.
fn latex_text(text: &str) -> String {
    let letter = |letter: char| match letter {
        '\\' => "\\textbackslash{}".to_owned(),
        '&' | '%' | '$' | '#' | '_' | '{' | '}' => format!("\\{letter}"),
        '~' => "\\textasciitilde{}".to_owned(),
        '^' => "\\textasciicircum{}".to_owned(),
        '<' => "\\textless{}".to_owned(),
        '>' => "\\textgreater{}".to_owned(),
        '|' => "\\textbar{}".to_owned(),
        // At the beginning of a line they would be arguments of the line break before.
        '[' | '*' => format!("{{{letter}}}"),
        '–' => "--".to_owned(),
        '⁺' => "$^{+}$".to_owned(),
        other => other.to_string(),
    };
    visible_line(text).chars().map(letter).collect()
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
