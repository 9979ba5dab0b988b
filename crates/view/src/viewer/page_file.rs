use std::io::Write as _;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::drawing::picture_file::write_whole;
use crate::{PageData, ViewError, viewer::page_bundle};

/// Placeholder for the data of a single-file page.
const PLACE: &str = "<script type=\"application/json\" id=\"page-data\">";

/// Marker after which the content security policy is inserted.
const HEAD: &str = "<head>";

/// Content security policy: everything is in the file, nothing is loaded and nothing is sent.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
     script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; font-src data:; \
     base-uri 'none'; form-action 'none'\">";

impl PageData {
    /// Returns the page as one HTML document that opens from a disk. It contains scripts and styles, and the data as base64 of
    /// gzip (RFC 1952), which the page unpacks. Equal data give equal bytes.
    ///
    /// # Errors
    /// [`ViewError::NoPage`] if the program was built without a page, [`ViewError::PageData`].
    pub fn html(&self) -> Result<String, ViewError> {
        let html = page_bundle::single()?;
        let (before, after) = html.split_once(PLACE).ok_or(ViewError::NoPage)?;
        let before = before.replacen(HEAD, &format!("{HEAD}{POLICY}"), 1);
        let data = STANDARD.encode(packed(&self.to_json()?));
        Ok([&before, PLACE, &data, after].concat())
    }

    /// Writes [`Self::html`] to a file.
    ///
    /// # Errors
    /// Those of [`Self::html`], and [`ViewError::Unwritable`].
    pub fn write_html(&self, path: &Path) -> Result<(), ViewError> {
        write_whole(path, self.html()?.as_bytes())
    }
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
    packed.expect("memory takes what is written to it")
}
