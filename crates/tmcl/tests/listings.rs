//! Every program listing of the manuals, from its text to what the motor does.
//!
//! The texts are the fixtures of `tmcl-lang`. Each is assembled from its file, downloaded over the wire protocol into a
//! virtual module, read back, run, and held against what the manual says that it does. What the module reports, what the
//! encoder counts and what the rotor did are compared, so that an error common to two does not cancel out.
#![allow(clippy::disallowed_methods, reason = "the listings are files")]

mod listings {
    mod closed_loop;
    mod codes;
    mod host;
    mod interrupts;
    mod motion;
    mod ports;
    mod routines;
    mod text;
}
