use std::borrow::Cow;

use rust_embed::RustEmbed;

use crate::ViewError;

/// The page as `build.rs` found or built it; empty where it could do neither.
#[derive(RustEmbed)]
#[folder = "$OUT_DIR/page"]
struct Files;

/// The page that is served.
const INDEX: &str = "index.html";

/// The page that is one file, with a place for its data.
const SINGLE: &str = "single.html";

/// A file of the page.
pub(crate) struct PageAsset {
    pub bytes: Cow<'static, [u8]>,
    /// Its media type.
    pub kind: &'static str,
}

/// The file at a path of the page, `/` being the page itself; `None` if there is none. Nothing outside the program
/// is looked at.
pub(crate) fn asset(path: &str) -> Option<PageAsset> {
    let name = path.strip_prefix('/')?;
    let name = if name.is_empty() { INDEX } else { name };
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
    let kind = match ending {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" => "application/json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "wasm" => "application/wasm",
        _ => "application/octet-stream",
    };
    Files::get(name).map(|file| PageAsset { bytes: file.data, kind })
}

/// Whether there is a page in this program.
///
/// # Errors
/// [`ViewError::NoPage`], which says what to install.
pub(crate) fn check() -> Result<(), ViewError> {
    single().map(|_| ())
}

/// The page that is one file.
///
/// # Errors
/// [`ViewError::NoPage`].
pub(crate) fn single() -> Result<String, ViewError> {
    let file = Files::get(SINGLE).ok_or(ViewError::NoPage)?;
    String::from_utf8(file.data.into_owned()).map_err(|_| ViewError::NoPage)
}
