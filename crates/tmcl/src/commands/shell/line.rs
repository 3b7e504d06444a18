//! What a line of the shell asks for: a command of the module, or a word of the shell's own.

use std::time::Duration;

use tmcl_config::nanoseconds;

/// A line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Line<'a> {
    /// Nothing.
    Empty,
    /// `help`, `help GAP`, `help max_velocity`.
    Help(&'a str),
    /// `exit`, `quit`.
    Leave,
    /// `get NAME…`.
    Get(Vec<String>),
    /// `set NAME=VALUE…`.
    Set(Vec<(&'a str, &'a str)>),
    /// `wait 500ms`.
    Wait(Duration),
    /// Anything else is program text.
    Command(&'a str),
}

/// The words that are the shell's own, and what each does.
pub(super) const WORDS: [(&str, &str); 6] = [
    ("get NAME…", "read parameters by name"),
    ("set NAME=VALUE…", "write parameters by name; a value is a number or a name"),
    ("wait TIME", "let time pass: 500ms, 2s"),
    ("help [WHAT]", "say what a command or a parameter is"),
    ("exit", "leave; so does Ctrl-D"),
    ("quit", "the same"),
];

/// Understands a line, or says what is expected.
pub(super) fn parse(text: &str) -> Result<Line<'_>, String> {
    let text = text.trim();
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let rest = rest.trim();
    match word.to_ascii_lowercase().as_str() {
        "" => Ok(Line::Empty),
        "help" | "?" => Ok(Line::Help(rest)),
        "exit" | "quit" if rest.is_empty() => Ok(Line::Leave),
        "get" if rest.is_empty() => {
            Err("`get` takes names of parameters, such as `get actual_position`".to_owned())
        }
        "get" => Ok(Line::Get(words(rest).map(str::to_owned).collect())),
        "set" => set(rest),
        "wait" => wait(word, rest, text),
        _ => Ok(Line::Command(text)),
    }
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| letter.is_whitespace() || letter == ',').filter(|word| !word.is_empty())
}

fn set(rest: &str) -> Result<Line<'_>, String> {
    const EXPECTED: &str = "`set` takes a name and a value, such as `set max_velocity=51200`";
    let pairs: Option<Vec<_>> = words(rest)
        .map(|word| word.split_once('=').filter(|(name, value)| !name.is_empty() && !value.is_empty()))
        .collect();
    pairs.filter(|pairs| !pairs.is_empty()).map(Line::Set).ok_or_else(|| EXPECTED.to_owned())
}

/// In capitals, or with operands, it is the command of that name, which only programs have.
fn wait<'a>(word: &str, rest: &str, text: &'a str) -> Result<Line<'a>, String> {
    if word == "WAIT" || rest.contains(',') {
        return Ok(Line::Command(text));
    }
    nanoseconds(rest)
        .filter(|time_ns| (0.0..=3.6e12).contains(time_ns))
        .map(|time_ns| Line::Wait(Duration::from_nanos(time_ns as u64)))
        .ok_or_else(|| "`wait` takes a time up to 1h, such as 500ms or 2s".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_shell_and_commands() {
        assert_eq!(parse("  "), Ok(Line::Empty));
        assert_eq!(parse("help gap"), Ok(Line::Help("gap")));
        assert_eq!(parse("QUIT"), Ok(Line::Leave));
        assert_eq!(parse("get a, b c"), Ok(Line::Get(["a", "b", "c"].map(str::to_owned).to_vec())));
        assert_eq!(parse("set a=1 b=on"), Ok(Line::Set(vec![("a", "1"), ("b", "on")])));
        assert_eq!(parse("wait 2s"), Ok(Line::Wait(Duration::from_secs(2))));
        assert_eq!(parse("WAIT TICKS, 0, 5"), Ok(Line::Command("WAIT TICKS, 0, 5")));
        assert_eq!(parse(" GAP 1, 0 "), Ok(Line::Command("GAP 1, 0")));
    }

    #[test]
    fn what_is_expected_is_said() {
        for wrong in ["get", "set", "set a", "set a=", "set =1", "wait", "wait 5", "wait 2h"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
