use std::collections::BTreeMap;

/// Content of a page beyond the summary: pictures and paths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Enclosure {
    /// Picture of each scenario by its name in the rows, or the reason for its absence; scenarios without an entry are skipped.
    pub pictures: BTreeMap<String, Result<Png, String>>,
    /// Pages that show the path of a trial, by its number, as addresses relative to the page.
    pub paths: BTreeMap<u64, String>,
}

/// Picture in a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Png {
    /// Width, in pixels.
    pub width: usize,
    /// Height, in pixels.
    pub height: usize,
    /// Content of the PNG file.
    pub bytes: Vec<u8>,
}
