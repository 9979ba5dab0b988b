use std::fs::FileType;

/// Returns true if bytes can be read from an entry that is no file: a pipe, or a device such as a terminal.
pub fn is_stream(kind: FileType) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        kind.is_fifo() || kind.is_char_device()
    }
    #[cfg(not(unix))]
    {
        let _ = kind;
        true
    }
}

/// Returns the name of a kind of entry that is neither file nor folder, with its article.
pub fn kind_name(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        match kind {
            _ if kind.is_fifo() => return "a pipe",
            _ if kind.is_socket() => return "a socket",
            _ => {}
        }
    }
    let _ = kind;
    "a device"
}
