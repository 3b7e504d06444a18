//! A line that does to bytes what lines do, as often as it is told to: for the tests of those who use a link.

use std::collections::VecDeque;
use std::time::Duration;

use crate::{Link, LinkError};

/// So many bytes may be lost in one read before it gives up: a peer that never stops talking must not keep us here.
const LOSS_LIMIT: usize = 4096;

/// What happens to bytes on their way, each on its own: probabilities from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faults {
    /// The byte does not arrive.
    pub loss: f64,
    /// It arrives twice.
    pub duplication: f64,
    /// One bit of it is wrong.
    pub corruption: f64,
    /// It arrives later, and so do those behind it: a line keeps the order of its bytes.
    pub delay: f64,
    /// The longest such delay; it is anything from 0 to this.
    pub longest_delay: Duration,
    /// So many bytes at least arrive as they are, late or not, between two that do not: a sum sees one fault, and not always
    /// two.
    pub gap: u64,
}

impl Faults {
    /// A good line.
    pub const NONE: Self = Self {
        loss: 0.0,
        duplication: 0.0,
        corruption: 0.0,
        delay: 0.0,
        longest_delay: Duration::ZERO,
        gap: 0,
    };

    /// All kinds with the same probability.
    #[must_use]
    pub const fn all(probability: f64, longest_delay: Duration) -> Self {
        Self {
            loss: probability,
            duplication: probability,
            corruption: probability,
            delay: probability,
            longest_delay,
            gap: 0,
        }
    }
}

/// Which way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// What is written.
    Out,
    /// What is read.
    In,
}

/// What happened so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Bytes that came to the line.
    pub bytes: u64,
    /// Bytes lost.
    pub lost: u64,
    /// Bytes that arrived twice.
    pub duplicated: u64,
    /// Bytes with a wrong bit.
    pub corrupted: u64,
    /// Bytes that were delayed.
    pub delayed: u64,
}

/// A byte that is on its way, this long after the one before it.
#[derive(Clone, Copy, Debug)]
struct Held {
    after: Duration,
    byte: u8,
}

/// A link with faults. What happens is a function of the seed and of what is written and read; time passes by the `wait` of
/// the link inside, so that nothing here needs a clock.
#[derive(Debug)]
pub struct FaultyLink<L> {
    link: L,
    random: Random,
    out: Faults,
    incoming: Faults,
    counts: [Counts; 2],
    /// How many bytes may not be lost, doubled or spoiled before the next that may.
    good: [u64; 2],
    held: VecDeque<Held>,
}

impl<L: Link> FaultyLink<L> {
    /// The link, with the same faults both ways.
    #[must_use]
    pub fn new(link: L, seed: u64, faults: Faults) -> Self {
        let counts = [Counts::default(); 2];
        let (good, held) = ([0; 2], VecDeque::new());
        Self { link, random: Random(seed), out: faults, incoming: faults, counts, good, held }
    }

    /// Other faults from now on, one way.
    pub fn set_faults(&mut self, direction: Direction, faults: Faults) {
        match direction {
            Direction::Out => self.out = faults,
            Direction::In => self.incoming = faults,
        }
    }

    /// What happened so far, one way.
    #[must_use]
    pub fn counts(&self, direction: Direction) -> Counts {
        self.counts[direction as usize]
    }

    /// The link inside.
    pub fn inner_mut(&mut self) -> &mut L {
        &mut self.link
    }

    /// What becomes of a byte: how long it takes, and how often it arrives as what.
    fn meet(&mut self, direction: Direction, byte: u8) -> (Duration, [Option<u8>; 2]) {
        let faults = match direction {
            Direction::Out => self.out,
            Direction::In => self.incoming,
        };
        let counts = &mut self.counts[direction as usize];
        counts.bytes += 1;
        let mut after = Duration::ZERO;
        if self.random.happens(faults.delay) {
            counts.delayed += 1;
            after = faults.longest_delay.mul_f64(self.random.fraction());
        }
        let good = &mut self.good[direction as usize];
        if *good > 0 {
            *good -= 1;
            return (after, [Some(byte), None]);
        }
        let before = *counts;
        let copies = if self.random.happens(faults.loss) {
            counts.lost += 1;
            [None, None]
        } else {
            let is_corrupted = self.random.happens(faults.corruption);
            counts.corrupted += u64::from(is_corrupted);
            let arrives = if is_corrupted { byte ^ (1 << (self.random.next() % 8)) } else { byte };
            let is_duplicated = self.random.happens(faults.duplication);
            counts.duplicated += u64::from(is_duplicated);
            [Some(arrives), is_duplicated.then_some(arrives)]
        };
        if *counts != before {
            *good = faults.gap;
        }
        (after, copies)
    }

    fn hold(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let (mut after, copies) = self.meet(Direction::In, *byte);
            for byte in copies.into_iter().flatten() {
                self.held.push_back(Held { after, byte });
                after = Duration::ZERO;
            }
        }
    }

    /// Time passes for what is on its way.
    fn pass(&mut self, time: Duration) {
        let mut left = time;
        for held in &mut self.held {
            let step = held.after.min(left);
            held.after -= step;
            left -= step;
            if !held.after.is_zero() {
                break;
            }
        }
    }

    /// How many bytes have arrived.
    fn arrived(&self) -> usize {
        self.held.iter().take_while(|held| held.after.is_zero()).count()
    }
}

impl<L: Link> Link for FaultyLink<L> {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let mut ready = Vec::with_capacity(bytes.len());
        for byte in bytes {
            let (after, copies) = self.meet(Direction::Out, *byte);
            if !after.is_zero() {
                self.link.write(&ready)?;
                ready.clear();
                self.wait(after)?;
            }
            ready.extend(copies.into_iter().flatten());
        }
        self.link.write(&ready)
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        if buffer.is_empty() {
            return Ok(0);
        }
        let mut left = timeout;
        let mut read = 0;
        loop {
            let length = self.arrived().min(buffer.len());
            if length > 0 {
                for (slot, held) in buffer.iter_mut().zip(self.held.drain(..length)) {
                    *slot = held.byte;
                }
                return Ok(length);
            }
            if let Some(front) = self.held.front() {
                let step = front.after.min(left);
                if step.is_zero() {
                    return Ok(0);
                }
                self.wait(step)?;
                left -= step;
                continue;
            }
            let mut room = [0; 64];
            let length = self.link.read(&mut room, left)?;
            read += length;
            if length == 0 || read > LOSS_LIMIT {
                return Ok(0);
            }
            self.hold(&room[..length]);
        }
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        let arrived = self.arrived();
        self.held.drain(..arrived);
        if self.held.is_empty() {
            return self.link.discard_input();
        }
        // What is in the link inside has arrived there, and is still behind what is on its way here.
        let mut room = [0; 64];
        for _ in 0..LOSS_LIMIT / room.len() {
            match self.link.read(&mut room, Duration::ZERO)? {
                0 => break,
                length => self.hold(&room[..length]),
            }
        }
        Ok(())
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        self.pass(duration);
        self.link.wait(duration)
    }

    fn has_own_time(&self) -> bool {
        self.link.has_own_time()
    }
}

/// The next of a long row of numbers: SplitMix64, whose constants these are.
#[derive(Clone, Copy, Debug)]
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// From 0 to 1, without 1.
    fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn happens(&mut self, probability: f64) -> bool {
        self.fraction() < probability
    }
}

#[cfg(test)]
mod tests;
