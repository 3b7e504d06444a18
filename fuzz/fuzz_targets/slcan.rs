//! Any bytes to both sides of an slcan line: neither decoder panics, what is understood is written back so that it means the
//! same, and a bus behind an adapter that says such things does not panic and comes to an end.
#![no_main]

use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use tmcl_link::can::slcan::{BitRate, CommandDecoder, ReplyDecoder};
use tmcl_link::can::{CanFrame, CanLink, SlcanLink};
use tmcl_link::{Link, LinkError};

/// Says `bytes` once, seven at a time.
struct Adapter<'a>(&'a [u8]);

impl Link for Adapter<'_> {
    fn write(&mut self, _: &[u8]) -> Result<(), LinkError> {
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], _: Duration) -> Result<usize, LinkError> {
        let (now, later) = self.0.split_at(7.min(buffer.len()).min(self.0.len()));
        buffer[..now.len()].copy_from_slice(now);
        self.0 = later;
        Ok(now.len())
    }

    fn discard_input(&mut self) -> Result<(), LinkError> {
        Ok(())
    }
}

fuzz_target!(|data: &[u8]| {
    let (mut commands, mut again) = (CommandDecoder::default(), CommandDecoder::default());
    for command in data.iter().filter_map(|byte| commands.push(*byte)).flatten() {
        let found = command.encode().into_iter().find_map(|byte| again.push(byte));
        assert_eq!(found, Some(Ok(command)));
    }
    let (mut replies, mut again) = (ReplyDecoder::default(), ReplyDecoder::default());
    for reply in data.iter().filter_map(|byte| replies.push(*byte)) {
        let found = reply.encode().into_iter().find_map(|byte| again.push(byte));
        assert_eq!(found, Some(reply));
    }
    let Ok(mut link) = SlcanLink::open(Adapter(data), "COM1", BitRate::Kbit1000) else { return };
    let frame = CanFrame::new(1, &[136, 1, 0, 0, 0, 0, 0]).expect("it fits");
    for _ in 0..=data.len() {
        let _ = link.send(frame);
        let _ = link.receive(Duration::from_millis(1));
    }
});
