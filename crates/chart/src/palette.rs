use crate::Ink;

/// Colours of the series, distinguishable also with colour blindness: Okabe & Ito 2008, "Color universal design", whole,
/// without yellow (too light on white) and black (too strong), with a darker purple, and with grey added.
const SERIES: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#aa4499", "#e69f00", "#56b4e9", "#5f5f5f"];

impl Ink {
    /// Returns the colour on white, as `#rrggbb`.
    pub(crate) fn on_white(self) -> &'static str {
        match self {
            Self::Text => "#1a1a1a",
            Self::Quiet => "#555555",
            Self::Grid => "#dddddd",
            Self::Series(index) => SERIES[index % SERIES.len()],
        }
    }

    /// Returns the colour as a variable of the page's style sheet.
    pub(crate) fn in_page(self) -> String {
        match self {
            Self::Text => "var(--text)".to_owned(),
            Self::Quiet => "var(--quiet)".to_owned(),
            Self::Grid => "var(--grid)".to_owned(),
            Self::Series(index) => format!("var(--series-{})", index % SERIES.len() + 1),
        }
    }

    /// Returns red, green and blue on white.
    pub(crate) fn rgb(self) -> [u8; 3] {
        let code = u32::from_str_radix(&self.on_white()[1..], 16).unwrap_or(0);
        let [_, red, green, blue] = code.to_be_bytes();
        [red, green, blue]
    }
}
