//! What a sum of eight bits sees, and what it does not.
//!
//! One wrong byte it always sees. A byte that comes twice shifts those behind it, and one in 256 such datagrams adds up all
//! the same, with another value in it. A host cannot know; so the values of this bus are such that it does not happen.

use tmcl_tables::{Command, Status};
use tmcl_wire::serial::{DATAGRAM_LENGTH, encode_reply, encode_request};
use tmcl_wire::{Reply, Request};

const HOST: u8 = 2;

/// Whether the checksums of these commands with this value, and of their replies, see every doubled byte.
pub(crate) fn sees<const N: usize>(
    commands: [Command; N],
    address: u8,
    kind: u8,
    motor: u8,
    value: i32,
) -> bool {
    commands.into_iter().all(|command| {
        let request = encode_request(address, Request::new(command, kind, motor, value));
        let replies = [Status::Ok, Status::Loaded]
            .map(|status| encode_reply(HOST, address, Reply { status, command: command.number(), value }));
        sees_doubles(request) && replies.into_iter().all(sees_doubles)
    })
}

/// With byte n doubled, the ninth byte is the last of the value, and the sum is short of it and has byte n twice.
fn sees_doubles(datagram: [u8; DATAGRAM_LENGTH]) -> bool {
    let [summed @ .., last, sum] = datagram;
    let unseen = last.wrapping_mul(2).wrapping_sub(sum);
    last != unseen && !summed.contains(&unseen)
}
