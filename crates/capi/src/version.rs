//! Versions.

use std::ffi::c_char;

/// Version of the binary interface that this header describes. It grows with every change that an old program would notice.
pub const CRANNY_ABI_VERSION: u32 = 1;

/// Returns the version of the binary interface that the library has. A program may compare it with CRANNY_ABI_VERSION, the
/// version that it was compiled for.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_abi_version() -> u32 {
    CRANNY_ABI_VERSION
}

/// Returns the version of Cranny, such as "0.1.0". It is valid forever.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
