use std::fmt::Write as _;

use serde_json::Value;

use crate::report::Summary;
use crate::report::number_text::{percent, plain, table_seconds};

/// Builder of a page. Figures are read from the JSON document by their path, so that the page always agrees with it.
pub struct Markup<'a> {
    pub summary: &'a Summary,
    pub text: String,
    /// The JSON document, as text.
    pub json: String,
    document: Value,
    /// Number of tables until now.
    tables: usize,
}

/// Format of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Unchanged.
    Plain,
    /// Count, possibly stored as a floating-point number.
    Count,
    /// Seconds as in the paper's table.
    TableSeconds,
    /// Share in percent.
    Percent,
    /// Memory in megabytes, stored in bytes.
    Megabytes,
    /// Length in millimetres, stored in metres.
    Millimetres,
    /// Probability, shown as "< 0.001" below a thousandth.
    Probability,
}

/// Text for a missing figure.
const NONE: &str = "–";

impl<'a> Markup<'a> {
    pub fn new(summary: &'a Summary) -> Self {
        // Serialization cannot fail: the figures of a summary are finite, and the keys of its maps are text.
        let json = serde_json::to_string(summary).unwrap_or_default();
        let document = serde_json::from_str(&json).unwrap_or_default();
        Self { summary, text: String::new(), json, document, tables: 0 }
    }

    /// Returns the figure at `path` (`rows.3.mean_s`), unchanged.
    pub fn figure(&self, path: &str) -> String {
        self.figure_as(path, Shown::Plain)
    }

    /// Returns the figure at `path` in a format.
    pub fn figure_as(&self, path: &str, shown: Shown) -> String {
        let pointer = format!("/{}", path.replace('.', "/"));
        let Some(number) = self.document.pointer(&pointer).and_then(Value::as_number) else {
            return NONE.to_owned();
        };
        let value = number.as_f64().unwrap_or(f64::NAN);
        let text = match shown {
            // A count is shown with all its digits.
            Shown::Plain if !number.is_f64() => number.to_string(),
            Shown::Plain => plain(value),
            Shown::Count => format!("{value:.0}"),
            Shown::TableSeconds => table_seconds(value),
            Shown::Percent => percent(value),
            Shown::Millimetres => plain(value * 1e3),
            Shown::Megabytes => plain(value * 1e-6),
            Shown::Probability if value < 1e-3 => "&lt; 0.001".to_owned(),
            Shown::Probability => format!("{value:.3}"),
        };
        let scale = match shown {
            Shown::Percent => " data-scale=\"100\"",
            Shown::Millimetres => " data-scale=\"1000\"",
            Shown::Megabytes => " data-scale=\"0.000001\"",
            Shown::Plain | Shown::Count | Shown::TableSeconds | Shown::Probability => "",
        };
        format!("<span data-path=\"{path}\"{scale}>{text}</span>")
    }

    /// Returns two figures as the ends of an interval.
    pub fn interval(&self, low: &str, high: &str, shown: Shown) -> String {
        format!(
            "<span class=\"interval\">[{}, {}]</span>",
            self.figure_as(low, shown),
            self.figure_as(high, shown)
        )
    }

    /// Opens a table with column heads and a caption that stays visible while the table scrolls; heads that begin with `<` are
    /// those of columns of words, the others of numbers.
    pub fn open_table(&mut self, caption: &str, heads: &[&str]) {
        self.tables += 1;
        let number = self.tables;
        let _ = write!(
            self.text,
            "<p class=\"quiet\" id=\"table-{number}\">{caption}</p>\n<div class=\"scroll\">\
             <table aria-describedby=\"table-{number}\">\n<thead><tr>"
        );
        for head in heads {
            let _ = match head.strip_prefix('<') {
                Some(words) => write!(self.text, "<th scope=\"col\" class=\"words\">{}</th>", escape(words)),
                None => write!(self.text, "<th scope=\"col\">{}</th>", escape(head)),
            };
        }
        self.text.push_str("</tr></thead>\n<tbody>\n");
    }

    /// Adds a line of a table: its head, escaped here, and cells of markup; cells that begin with `<td` have their own tag.
    pub fn table_line(&mut self, head: &str, cells: &[String]) {
        let _ = write!(self.text, "<tr><th scope=\"row\">{}</th>", escape(head));
        for cell in cells {
            if cell.starts_with("<td") {
                self.text.push_str(cell);
            } else {
                let _ = write!(self.text, "<td>{cell}</td>");
            }
        }
        self.text.push_str("</tr>\n");
    }

    /// Opens a collapsible section with a title line, which is markup; `id` is its link target.
    pub fn open_fold(&mut self, id: &str, line: &str) {
        let _ = writeln!(self.text, "<details id=\"{id}\"><summary>{line}</summary>\n<div class=\"fold\">");
    }

    pub fn close_fold(&mut self) {
        self.text.push_str("</div></details>\n");
    }

    pub fn close_table(&mut self) {
        self.text.push_str("</tbody></table></div>\n");
    }
}

/// Returns a cell of words.
pub fn words(text: &str) -> String {
    format!("<td class=\"words\">{}</td>", escape(text))
}

/// Converts words to the name of an anchor in the page.
pub fn anchor(words: &[&str]) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
    words.join("-").chars().map(letter).collect()
}

/// Escapes text for HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
