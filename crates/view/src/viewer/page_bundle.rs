use crate::ViewError;

// `FILES`: names with `/` between folders, and contents, of the page that `build.rs` found or built; empty if it could do
// neither.
include!(concat!(env!("OUT_DIR"), "/page_files.rs"));

/// Name of the served page.
const INDEX: &str = "index.html";

/// Name of the single-file page, with a placeholder for its data.
const SINGLE: &str = "single.html";

/// File of the page.
pub(crate) struct PageAsset {
    pub bytes: &'static [u8],
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
    file(name).map(|bytes| PageAsset { bytes, kind })
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
    let text = file(SINGLE).and_then(|bytes| std::str::from_utf8(bytes).ok());
    text.map(str::to_owned).ok_or(ViewError::NoPage)
}

fn file(name: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(own, _)| *own == name).map(|(_, bytes)| *bytes)
}
