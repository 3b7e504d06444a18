//! Playing a session.

use crate::session::{Act, Line, Session};

/// A module that a session is played against.
pub trait Target {
    /// What can go wrong with it.
    type Error;

    /// Control periods since power was first switched on.
    fn tick(&self) -> u64;
    /// Lets control periods pass until so many have. What leaves ports meanwhile is appended to `left`, in the order of ticks
    /// and ports.
    ///
    /// # Errors
    /// Where the target cannot be reached.
    fn run_to(&mut self, tick: u64, left: &mut Vec<(u64, u8, Vec<u8>)>) -> Result<(), Self::Error>;
    /// Something from outside happens now; likewise.
    ///
    /// # Errors
    /// Where the target cannot be reached.
    fn act(&mut self, act: &Act, left: &mut Vec<(u64, u8, Vec<u8>)>) -> Result<(), Self::Error>;
}

/// Plays the inputs of a session, and returns it as it went: its comments and inputs, with what really left the ports.
///
/// Ticks count from where the target is.
///
/// # Errors
/// Where the target cannot be reached.
pub fn play<T: Target>(session: &Session, target: &mut T) -> Result<Session, T::Error> {
    let start = target.tick();
    let mut lines = Vec::new();
    for line in &session.lines {
        let mut left = Vec::new();
        match line {
            Line::Comment(_) => lines.push(line.clone()),
            Line::At(_, Act::Leave(..)) => {}
            Line::At(tick, act) => {
                target.run_to(start + tick, &mut left)?;
                note(&mut lines, &mut left, start);
                lines.push(line.clone());
                target.act(act, &mut left)?;
                note(&mut lines, &mut left, start);
            }
        }
    }
    Ok(Session { lines: settled(lines) })
}

fn note(lines: &mut Vec<Line>, left: &mut Vec<(u64, u8, Vec<u8>)>, start: u64) {
    for (tick, port, bytes) in left.drain(..) {
        // What leaves one port at one tick is one line, in however many pieces it was collected.
        if let Some(Line::At(last_tick, Act::Leave(last_port, last))) = lines.last_mut()
            && (*last_tick, *last_port) == (tick - start, port)
        {
            last.extend(bytes);
        } else {
            lines.push(Line::At(tick - start, Act::Leave(port, bytes)));
        }
    }
}

/// Comments stand before what they speak of: those that were reached before replies of earlier ticks move behind them.
fn settled(lines: Vec<Line>) -> Vec<Line> {
    let mut settled = Vec::with_capacity(lines.len());
    let mut waiting = Vec::new();
    for line in lines {
        match line {
            Line::Comment(_) => waiting.push(line),
            Line::At(_, Act::Leave(..)) => settled.push(line),
            Line::At(..) => {
                settled.append(&mut waiting);
                settled.push(line);
            }
        }
    }
    settled.append(&mut waiting);
    settled
}
