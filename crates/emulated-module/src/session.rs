//! Sessions as text: what arrives at a module's ports and what leaves them, each at its tick.
//!
//! ```text
//! # A comment. Ticks are control periods of 50 µs and never go back.
//! @0 0 > 01 88 01 00 00 00 00 00 8a
//! @0 0 < 02 01 64 88 05 1f 01 0b 1f
//! @20000 power cycle
//! @20000 load 0.05
//! @20000 input 1 high
//! @40000 end
//! ```

use core::fmt;

/// What happens at a tick.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// Bytes arrive at a port, at most 255.
    Arrive(u8, Vec<u8>),
    /// Bytes leave a port.
    Leave(u8, Vec<u8>),
    /// The module is switched off and on again.
    PowerCycle,
    /// Torque of the load from now on, in Nm.
    Load(f64),
    /// The level of a digital input.
    Input(u8, bool),
    /// Nothing happens, but the session lasts until then.
    End,
}

/// A line of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// What happens when.
    At(u64, Act),
    /// A comment, without its `#`, or an empty line: `None`.
    Comment(Option<String>),
}

/// A session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Session {
    /// Its lines, in the order of their ticks.
    pub lines: Vec<Line>,
}

/// What is wrong with the text of a session.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct SessionError {
    /// Where, from 1.
    pub line: usize,
    /// What, and what is allowed.
    pub message: String,
}

/// Bytes that arrive at once at most: their number travels as a byte.
const MOST_BYTES: usize = 255;

impl Session {
    /// Reads a session.
    ///
    /// # Errors
    /// [`SessionError`] for the first line that is none.
    pub fn parse(text: &str) -> Result<Self, SessionError> {
        let mut session = Self::default();
        let mut latest = 0;
        for (index, text) in text.lines().enumerate() {
            let failure = |message| SessionError { line: index + 1, message };
            let line = line(text.trim()).map_err(failure)?;
            if let Line::At(tick, _) = line {
                if tick < latest {
                    return Err(failure(format!(
                        "tick {tick} comes after tick {latest}; ticks never go back"
                    )));
                }
                latest = tick;
            }
            session.lines.push(line);
        }
        Ok(session)
    }

    /// What goes in, and when.
    pub fn inputs(&self) -> impl Iterator<Item = (u64, &Act)> {
        self.lines.iter().filter_map(|line| match line {
            Line::At(_, Act::Leave(..)) | Line::Comment(_) => None,
            Line::At(tick, act) => Some((*tick, act)),
        })
    }
}

fn line(text: &str) -> Result<Line, String> {
    if text.is_empty() {
        return Ok(Line::Comment(None));
    }
    if let Some(comment) = text.strip_prefix('#') {
        return Ok(Line::Comment(Some(comment.to_owned())));
    }
    let line = text.strip_prefix('@').ok_or("a line is a comment (#…) or begins with @TICK")?;
    let mut words = line.split_whitespace();
    let tick = words.next().unwrap_or_default();
    let tick = tick.parse().map_err(|_| format!("\"{tick}\" is no tick: a whole number of 50 µs"))?;
    let words: Vec<_> = words.collect();
    Ok(Line::At(tick, act(&words)?))
}

fn act(words: &[&str]) -> Result<Act, String> {
    match words {
        ["power", "cycle"] => Ok(Act::PowerCycle),
        ["load", torque] => {
            let torque_nm: f64 = torque.parse().map_err(|_| format!("\"{torque}\" is no torque in Nm"))?;
            let possible = (-100.0..=100.0).contains(&torque_nm);
            possible
                .then_some(Act::Load(torque_nm))
                .ok_or_else(|| format!("{torque} Nm is not -100 to 100 Nm"))
        }
        ["input", number, level @ ("high" | "low")] => match number.parse() {
            Ok(number @ 0..=7) => Ok(Act::Input(number, *level == "high")),
            _ => Err(format!("\"{number}\" is no input: 0 to 7")),
        },
        ["end"] => Ok(Act::End),
        [port, direction @ (">" | "<"), bytes @ ..] => {
            let port = match port.parse() {
                Ok(port @ 0..=3) => port,
                _ => return Err(format!("\"{port}\" is no port: 0 to 3")),
            };
            let bytes = bytes.iter().map(|byte| hex(byte)).collect::<Result<Vec<_>, _>>()?;
            if bytes.is_empty() || bytes.len() > MOST_BYTES {
                return Err(format!("{} bytes; 1 to {MOST_BYTES} are allowed in a line", bytes.len()));
            }
            Ok(if *direction == ">" { Act::Arrive(port, bytes) } else { Act::Leave(port, bytes) })
        }
        _ => Err("after @TICK comes PORT > BYTES, PORT < BYTES, power cycle, load NM, input NUMBER high, \
                  input NUMBER low, or end"
            .to_owned()),
    }
}

fn hex(byte: &str) -> Result<u8, String> {
    let digits = byte.len() == 2 && byte.bytes().all(|digit| digit.is_ascii_hexdigit());
    let value = digits.then(|| u8::from_str_radix(byte, 16).ok()).flatten();
    value.ok_or_else(|| format!("\"{byte}\" is no byte: two hexadecimal digits"))
}

impl fmt::Display for Act {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = |f: &mut fmt::Formatter<'_>, bytes: &[u8]| {
            bytes.iter().try_for_each(|byte| write!(f, " {byte:02x}"))
        };
        match self {
            Self::Arrive(port, arriving) => {
                write!(f, "{port} >")?;
                bytes(f, arriving)
            }
            Self::Leave(port, leaving) => {
                write!(f, "{port} <")?;
                bytes(f, leaving)
            }
            Self::PowerCycle => f.write_str("power cycle"),
            Self::Load(torque_nm) => write!(f, "load {torque_nm}"),
            Self::Input(number, high) => write!(f, "input {number} {}", if *high { "high" } else { "low" }),
            Self::End => f.write_str("end"),
        }
    }
}

impl fmt::Display for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in &self.lines {
            match line {
                Line::At(tick, act) => writeln!(f, "@{tick} {act}")?,
                Line::Comment(None) => writeln!(f)?,
                Line::Comment(Some(comment)) => writeln!(f, "#{comment}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_act() -> impl Strategy<Value = Act> {
        let bytes = || proptest::collection::vec(any::<u8>(), 1..40);
        prop_oneof![
            (0..4_u8, bytes()).prop_map(|(port, bytes)| Act::Arrive(port, bytes)),
            (0..4_u8, bytes()).prop_map(|(port, bytes)| Act::Leave(port, bytes)),
            Just(Act::PowerCycle),
            (-100.0..100.0).prop_map(Act::Load),
            (0..8_u8, any::<bool>()).prop_map(|(number, high)| Act::Input(number, high)),
            Just(Act::End),
        ]
    }

    proptest! {
        #[test]
        fn what_is_written_reads_as_the_same(
            acts in proptest::collection::vec((0..1000_u64, any_act()), 0..20),
            comment in "[ a-z]{0,10}",
        ) {
            let mut tick = 0;
            let mut lines = vec![Line::Comment(Some(comment.trim_end().to_owned())), Line::Comment(None)];
            for (later, act) in acts {
                tick += later;
                lines.push(Line::At(tick, act));
            }
            let session = Session { lines };
            prop_assert_eq!(Session::parse(&session.to_string()), Ok(session));
        }

        #[test]
        fn no_text_panics(text in ".{0,80}") {
            let _ = Session::parse(&text);
        }
    }

    #[test]
    fn wrong_lines_say_what_is_allowed() {
        let message = |text: &str| Session::parse(text).expect_err("wrong").to_string();
        assert_eq!(message("\n0 0 > 01"), "line 2: a line is a comment (#…) or begins with @TICK");
        assert_eq!(message("@x end"), "line 1: \"x\" is no tick: a whole number of 50 µs");
        assert_eq!(message("@0 4 > 01"), "line 1: \"4\" is no port: 0 to 3");
        assert_eq!(message("@0 0 > 1"), "line 1: \"1\" is no byte: two hexadecimal digits");
        assert_eq!(message("@0 0 >"), "line 1: 0 bytes; 1 to 255 are allowed in a line");
        assert_eq!(message("@5 end\n@4 end"), "line 2: tick 4 comes after tick 5; ticks never go back");
        assert_eq!(message("@0 input 8 high"), "line 1: \"8\" is no input: 0 to 7");
        assert_eq!(message("@0 load 101"), "line 1: 101 Nm is not -100 to 100 Nm");
    }
}
