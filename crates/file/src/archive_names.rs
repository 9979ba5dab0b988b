/// Returns the names listed in the central directory of a ZIP archive, including duplicates, of which the library returns only
/// the last (APPNOTE 6.3.10, 4.3.12).
pub fn archive_names(mut directory: &[u8]) -> Vec<String> {
    const SIGNATURE: &[u8] = b"PK\x01\x02";
    const HEADER: usize = 46;
    let mut names = Vec::new();
    while directory.len() >= HEADER && directory.starts_with(SIGNATURE) {
        let length = |at: usize| usize::from(u16::from_le_bytes([directory[at], directory[at + 1]]));
        let (name, rest) = (length(28), length(30) + length(32));
        let Some(bytes) = directory.get(HEADER..HEADER + name) else { break };
        names.push(String::from_utf8_lossy(bytes).into_owned());
        directory = directory.get(HEADER + name + rest..).unwrap_or_default();
    }
    names
}
