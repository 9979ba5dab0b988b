use std::borrow::Cow;

use rust_embed::RustEmbed;

use crate::ViewError;

/// Page that `build.rs` found or built; empty if it could do neither.
#[derive(RustEmbed)]
#[folder = "$OUT_DIR/page"]
struct Files;

/// Name of the served page.
const INDEX: &str = "index.html";

/// Name of the single-file page, with a placeholder for its data.
const SINGLE: &str = "single.html";

/// File of the page.
pub(crate) struct PageAsset {
    pub bytes: Cow<'static, [u8]>,
    /// Media type.
    pub kind: &'static str,
}

/// Returns the file at a path of the page, `/` being the page itself; `None` if it is not embedded in the program.
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

/// Checks that the program contains a page.
///
/// # Errors
/// [`ViewError::NoPage`], which names what to install.
pub(crate) fn check() -> Result<(), ViewError> {
    single().map(|_| ())
}

/// Returns the single-file page.
///
/// # Errors
/// [`ViewError::NoPage`].
pub(crate) fn single() -> Result<String, ViewError> {
    let file = Files::get(SINGLE).ok_or(ViewError::NoPage)?;
    String::from_utf8(file.data.into_owned()).map_err(|_| ViewError::NoPage)
}
