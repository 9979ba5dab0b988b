//! Texts for C.

use std::ffi::CString;

/// Text for C: without zero bytes, which would end it.
pub fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}

/// Texts for C.
pub fn c_texts<'a>(texts: impl IntoIterator<Item = &'a str>) -> Vec<CString> {
    texts.into_iter().map(c_text).collect()
}
