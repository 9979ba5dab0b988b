use std::path::Path;

/// Quotes a word for a POSIX shell if necessary: it is then one word, in which nothing is expanded.
pub fn shell_word(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-=:,+@%".contains(c);
    // Some shells expand a leading equals sign.
    if !word.is_empty() && !word.starts_with('=') && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Quotes the path of a file for a POSIX shell, so that no program takes it for an option. A path that is not UTF-8 becomes the
/// output of `printf` with its bytes: any other text would name another file.
pub fn shell_file(path: &Path) -> String {
    let beside = if path.as_os_str().as_encoded_bytes().starts_with(b"-") { "./" } else { "" };
    if let Some(path) = path.to_str() {
        return shell_word(&format!("{beside}{path}"));
    }
    let bytes = path.as_os_str().as_encoded_bytes().iter().map(|byte| format!("\\{byte:03o}"));
    format!("\"$(printf '{beside}{}')\"", bytes.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_quoted_only_if_a_shell_would_change_it() {
        assert_eq!(shell_word("runs/results.db"), "runs/results.db");
        assert_eq!(shell_word("my results.db"), "'my results.db'");
        assert_eq!(shell_word("=ls"), "'=ls'");
        assert_eq!(shell_file(Path::new("-r.db")), "./-r.db");
    }

    #[cfg(unix)]
    #[test]
    fn words_reach_a_shell_as_they_are() {
        for word in
            ["plain/path.db", "with space", "it's", "$HOME", "", "a;b", "`id`", "~", "a\nb", "größer", "50%"]
        {
            let script = format!("printf %s {}", shell_word(word));
            let echoed = std::process::Command::new("sh").args(["-c", &script]).output();
            assert_eq!(String::from_utf8(echoed.unwrap().stdout).unwrap(), word);
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_path_that_is_not_text_reaches_a_shell_as_it_is() {
        use std::os::unix::ffi::OsStrExt as _;
        for (bytes, reached) in
            [(b"a \xff'%s\\n$HOME", &b"a \xff'%s\\n$HOME"[..]), (b"-rf\xffxxxxxxxxx", b"./-rf\xffxxxxxxxxx")]
        {
            let script = format!("printf %s {}", shell_file(Path::new(std::ffi::OsStr::from_bytes(bytes))));
            let echoed = std::process::Command::new("sh").args(["-c", &script]).output();
            assert_eq!(echoed.unwrap().stdout, reached);
        }
    }
}
