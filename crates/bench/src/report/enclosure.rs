use std::collections::BTreeMap;

/// What a page shows that no summary holds, since whoever measures sees nothing: pictures and paths.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Enclosure {
    /// A picture of each scenario, by its name in the rows, or why there is none. Of a scenario that is not here nothing
    /// is said.
    pub pictures: BTreeMap<String, Result<Png, String>>,
    /// Pages that show the path of a trial, by its number: addresses relative to the page.
    pub paths: BTreeMap<u64, String>,
}

/// A picture in a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Png {
    /// In pixels.
    pub width: usize,
    /// In pixels.
    pub height: usize,
    /// The file.
    pub bytes: Vec<u8>,
}
