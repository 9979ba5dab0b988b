use std::fmt::Write as _;

use serde_json::Value;

use crate::report::Summary;
use crate::report::number_text::{percent, plain, table_seconds};

/// A page as it grows. Figures are looked up in the JSON document by their path, so that the page cannot say
/// anything else than the document.
pub struct Markup<'a> {
    pub summary: &'a Summary,
    pub text: String,
    /// The document, as text.
    pub json: String,
    document: Value,
    /// How many tables it has.
    tables: usize,
}

/// How a figure is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// As it is.
    Plain,
    /// A count, which may stand as a number with a point.
    Count,
    /// Seconds as in the paper's table.
    TableSeconds,
    /// In percent.
    Percent,
    /// Memory in bytes, in megabytes.
    Megabytes,
    /// A length in metres, in millimetres.
    Millimetres,
    /// A probability, which is no more than "small" below a thousandth.
    Probability,
}

/// What stands where there is no figure.
const NONE: &str = "–";

impl<'a> Markup<'a> {
    pub fn new(summary: &'a Summary) -> Self {
        // A summary holds nothing that JSON has not: its figures are finite, its maps have text for keys.
        let json = serde_json::to_string(summary).unwrap_or_default();
        let document = serde_json::from_str(&json).unwrap_or_default();
        Self { summary, text: String::new(), json, document, tables: 0 }
    }

    /// The figure at `path` (`rows.3.mean_s`), as it is.
    pub fn figure(&self, path: &str) -> String {
        self.figure_as(path, Shown::Plain)
    }

    /// The figure at `path`.
    pub fn figure_as(&self, path: &str, shown: Shown) -> String {
        let pointer = format!("/{}", path.replace('.', "/"));
        let Some(number) = self.document.pointer(&pointer).and_then(Value::as_number) else {
            return NONE.to_owned();
        };
        let value = number.as_f64().unwrap_or(f64::NAN);
        let text = match shown {
            // A count has all its digits.
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
        format!("<data value=\"{number}\" data-path=\"{path}\"{scale}>{text}</data>")
    }

    /// Two figures as the ends of an interval.
    pub fn interval(&self, low: &str, high: &str, shown: Shown) -> String {
        format!(
            "<span class=\"interval\">[{}, {}]</span>",
            self.figure_as(low, shown),
            self.figure_as(high, shown)
        )
    }

    /// Opens a table with a caption, which stays in sight where the table is scrolled, and column heads;
    /// those that begin with `<` hold words, the others numbers.
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

    /// A line of a table: its head, escaped here, and cells that are markup already; those that begin with
    /// `<td` bring their own tag.
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

    /// Opens what stands behind a line, which is markup; `id` leads to it from elsewhere.
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

/// A cell of words.
pub fn words(text: &str) -> String {
    format!("<td class=\"words\">{}</td>", escape(text))
}

/// Words as the name of a place in the page.
pub fn anchor(words: &[&str]) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
    words.join("-").chars().map(letter).collect()
}

/// Text as HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
