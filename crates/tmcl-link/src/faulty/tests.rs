use super::*;

/// Gives back what it is given, at once; remembers how long it waited.
#[derive(Debug, Default)]
struct Echo {
    bytes: VecDeque<u8>,
    now: Duration,
}

impl Link for Echo {
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.bytes.extend(bytes);
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkError> {
        let length = buffer.len().min(self.bytes.len());
        for (slot, byte) in buffer.iter_mut().zip(self.bytes.drain(..length)) {
            *slot = byte;
        }
        if length == 0 {
            self.now += timeout;
        }
        Ok(length)
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        self.bytes.clear();
        Ok(())
    }

    fn wait(&mut self, duration: Duration) -> Result<(), LinkError> {
        self.now += duration;
        Ok(())
    }
}

const TIMEOUT: Duration = Duration::from_millis(50);

fn line(seed: u64, out: Faults, incoming: Faults) -> FaultyLink<Echo> {
    let mut line = FaultyLink::new(Echo::default(), seed, out);
    line.set_faults(Direction::In, incoming);
    line
}

fn read_all(line: &mut FaultyLink<Echo>) -> Vec<u8> {
    let mut all = Vec::new();
    let mut buffer = [0; 7];
    loop {
        match line.read(&mut buffer, TIMEOUT).expect("an echo works") {
            0 => return all,
            length => all.extend(&buffer[..length]),
        }
    }
}

fn echoed(line: &mut FaultyLink<Echo>, bytes: &[u8]) -> Vec<u8> {
    line.write(bytes).expect("an echo works");
    read_all(line)
}

#[test]
fn a_good_line_changes_nothing() {
    let all: Vec<u8> = (0..=255).collect();
    let mut line = line(1, Faults::NONE, Faults::NONE);
    assert_eq!(echoed(&mut line, &all), all);
    assert_eq!(line.counts(Direction::In), Counts { bytes: 256, ..Counts::default() });
}

#[test]
fn every_fault_is_what_it_is_called() {
    let bytes: Vec<u8> = (0..=255).collect();
    let always = |change: fn(&mut Faults)| {
        let mut faults = Faults::NONE;
        change(&mut faults);
        faults
    };
    let lost = always(|faults| faults.loss = 1.0);
    assert_eq!(echoed(&mut line(1, lost, Faults::NONE), &bytes), []);
    assert_eq!(echoed(&mut line(1, Faults::NONE, lost), &bytes), []);
    let doubled = always(|faults| faults.duplication = 1.0);
    let twice: Vec<u8> = bytes.iter().flat_map(|byte| [*byte; 2]).collect();
    assert_eq!(echoed(&mut line(1, doubled, Faults::NONE), &bytes), twice);
    assert_eq!(echoed(&mut line(1, Faults::NONE, doubled), &bytes), twice);
    let spoiled = always(|faults| faults.corruption = 1.0);
    let found = echoed(&mut line(1, Faults::NONE, spoiled), &bytes);
    assert_eq!(found.len(), bytes.len());
    assert!(found.iter().zip(&bytes).all(|(found, byte)| (found ^ byte).count_ones() == 1));
    let seldom = Faults { gap: 9, ..spoiled };
    let found = echoed(&mut line(1, seldom, Faults::NONE), &bytes);
    let wrong: Vec<_> = (0..found.len()).filter(|index| found[*index] != bytes[*index]).collect();
    assert_eq!(wrong, (0..256).step_by(10).collect::<Vec<_>>());
}

#[test]
fn what_is_delayed_comes_later_and_in_order() {
    let slow = Faults { delay: 1.0, longest_delay: 3 * TIMEOUT, ..Faults::NONE };
    let bytes: Vec<u8> = (0..100).collect();
    let mut incoming = line(5, Faults::NONE, slow);
    incoming.write(&bytes).expect("an echo works");
    let mut found: Vec<u8> = Vec::new();
    let mut silences = 0;
    while found.len() < bytes.len() {
        let mut buffer = [0; 9];
        let before = incoming.inner_mut().now;
        let length = incoming.read(&mut buffer, TIMEOUT).expect("an echo works");
        assert!(incoming.inner_mut().now - before <= TIMEOUT);
        silences += usize::from(length == 0);
        found.extend(&buffer[..length]);
    }
    assert_eq!(found, bytes);
    assert!((20..200).contains(&silences), "{silences}");
    // Written bytes take their time before the write returns.
    let mut outgoing = line(5, slow, Faults::NONE);
    assert_eq!(echoed(&mut outgoing, &bytes), bytes);
    assert!(outgoing.inner_mut().now > 50 * TIMEOUT);
}

#[test]
fn what_is_discarded_had_arrived() {
    let slow = Faults { delay: 1.0, longest_delay: TIMEOUT, ..Faults::NONE };
    let mut line = line(3, Faults::NONE, slow);
    line.write(&[1, 2]).expect("an echo works");
    assert_eq!(line.read(&mut [0], Duration::ZERO).expect("an echo works"), 0);
    line.discard_input().expect("an echo works");
    assert_eq!(read_all(&mut line), [1, 2]);
    line.write(&[3]).expect("an echo works");
    assert_eq!(line.read(&mut [0], Duration::ZERO).expect("an echo works"), 0);
    line.wait(TIMEOUT).expect("an echo works");
    line.discard_input().expect("an echo works");
    assert_eq!(read_all(&mut line), []);
}

#[test]
fn the_same_seed_is_the_same_line() {
    let faults = Faults::all(0.1, TIMEOUT);
    let run = |seed| {
        let mut line = line(seed, faults, faults);
        let found: Vec<_> = (0..50).map(|byte| echoed(&mut line, &[byte; 9])).collect();
        (found, line.counts(Direction::Out), line.counts(Direction::In), line.inner_mut().now)
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7).0, run(8).0);
    let (_, out, incoming, _) = run(7);
    assert_eq!(out.bytes, 450);
    for counts in [out, incoming] {
        for count in [counts.lost, counts.duplicated, counts.corrupted, counts.delayed] {
            assert!((15..90).contains(&count), "{counts:?}");
        }
    }
}

#[test]
fn a_peer_that_never_stops_keeps_nobody() {
    struct Torrent;
    impl Link for Torrent {
        fn write(&mut self, _: &[u8]) -> Result<(), LinkError> {
            Ok(())
        }
        fn read(&mut self, buffer: &mut [u8], _: Duration) -> Result<usize, LinkError> {
            Ok(buffer.len())
        }
        fn discard_input(&mut self) -> Result<(), LinkError> {
            Ok(())
        }
    }
    let mut line = FaultyLink::new(Torrent, 1, Faults { loss: 1.0, ..Faults::NONE });
    assert_eq!(line.read(&mut [0; 9], TIMEOUT).expect("it works"), 0);
    line.discard_input().expect("it works");
}
