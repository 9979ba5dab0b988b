use clap::Command;

/// Maximum width of a line of examples, in columns: terminals have at least as many.
const COLUMNS: usize = 80;

/// Lays out the text after the help of a command for a terminal of any width. Prose becomes one line per paragraph, which is
/// wrapped when printed. If a remark extends beyond [`COLUMNS`], all remarks move below their examples.
pub fn laid_out(command: Command) -> Command {
    let after = command.get_after_help().map(ToString::to_string);
    let command = match after {
        Some(text) => command.after_help(paragraphs(&text)),
        None => command,
    };
    command.mut_subcommands(laid_out)
}

fn paragraphs(text: &str) -> String {
    let is_long = |line: &str| line.starts_with(' ') && line.chars().count() > COLUMNS;
    let are_below = text.lines().any(is_long);
    let mut laid_out: Vec<String> = Vec::new();
    for line in text.lines() {
        let is_prose = |line: &str| !line.is_empty() && !line.starts_with(' ') && !line.ends_with(':');
        match laid_out.last_mut() {
            Some(last) if is_prose(line) && is_prose(last) => {
                last.push(' ');
                last.push_str(line);
            }
            _ if are_below => laid_out.extend(example_above_its_remark(line)),
            _ => laid_out.push(line.to_owned()),
        }
    }
    laid_out.join("\n")
}

/// Splits an example from its remark, which are separated by two or more spaces; other lines are unchanged.
fn example_above_its_remark(line: &str) -> Vec<String> {
    match line.trim_start().split_once("  ").filter(|_| line.starts_with(' ')) {
        Some((command, remark)) => vec![format!("  {command}"), format!("      {}", remark.trim_start())],
        None => vec![line.to_owned()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prose_is_a_line_a_paragraph_and_remarks_stand_below_where_one_is_long() {
        let said = paragraphs("Examples:\n  a b   does b\n  a c\n\nOne\nparagraph.\n\nThen:\n  a d");
        assert_eq!(said, "Examples:\n  a b   does b\n  a c\n\nOne paragraph.\n\nThen:\n  a d");
        let (command, remark) = ("b".repeat(40), "c".repeat(50));
        let said = paragraphs(&format!("Examples:\n  a b   does b\n  {command}   {remark}"));
        assert_eq!(said, format!("Examples:\n  a b\n      does b\n  {command}\n      {remark}"));
    }

    #[test]
    fn no_example_of_any_command_is_broken_at_eighty_columns() {
        fn check(command: &Command) {
            let after = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            for line in after.lines().filter(|line| line.starts_with(' ')) {
                assert!(line.chars().count() <= COLUMNS, "{}: {line}", command.get_name());
            }
            command.get_subcommands().for_each(check);
        }
        check(&crate::whole_command());
    }
}
