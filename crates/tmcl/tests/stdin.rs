//! Programs that come through a pipe, and readers that have had enough.
#![allow(clippy::disallowed_methods, reason = "a test of a program")]

use std::io::Write;
use std::process::{Command, Output, Stdio};

/// Runs `tmcl` with `input` on its stdin.
fn tmcl(arguments: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_tmcl"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    child.stdin.take().expect("a pipe").write_all(input).expect("it listens");
    child.wait_with_output().expect("it ends")
}

const PROGRAM: &[u8] = b"// \xb5Steps\nLoop: MVP ABS,0,100\nJA Loop\n";

#[test]
fn a_program_is_formatted_from_pipe_to_pipe() {
    let output = tmcl(&["fmt", "-"], PROGRAM);
    assert_eq!(output.stdout, b"// \xb5Steps\nLoop:   MVP ABS, 0, 100\n        JA Loop\n");
    assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()));
    let again = tmcl(&["fmt", "-"], &output.stdout);
    assert_eq!(again.stdout, output.stdout, "also when nothing changes");
}

#[test]
fn what_is_not_formatted_is_named() {
    let output = tmcl(&["fmt", "--check", "-"], PROGRAM);
    assert_eq!((output.status.code(), output.stdout), (Some(1), b"<stdin>\n".to_vec()));
}

/// Without -o there is no file to name the compiled one after.
#[test]
fn a_program_is_assembled_from_pipe_to_pipe_and_back() {
    let compiled = tmcl(&["asm", "-"], PROGRAM);
    assert_eq!((compiled.status.code(), compiled.stderr), (Some(0), Vec::new()));
    assert_eq!(compiled.stdout, [4, 0, 0, 0, 0, 0, 100, 104, 22, 0, 0, 0, 0, 0, 0, 22]);
    let text = tmcl(&["disasm", "-"], &compiled.stdout);
    let again = tmcl(&["asm", "-"], &text.stdout);
    assert_eq!(again.stdout, compiled.stdout);
}

#[test]
fn errors_name_the_pipe() {
    let output = tmcl(&["check", "-"], b"MPV 0\n");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(said.contains(" --> <stdin>:1:1\n"), "{said}");
    assert_eq!(output.status.code(), Some(1));
    let output = tmcl(&["disasm", "-"], b"MPV 0\n");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(said.starts_with("error: <stdin> is no compiled program"), "{said}");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_program_runs_from_a_pipe() {
    let output = tmcl(&["run", "-", "--expect", "target_position == 100"], PROGRAM);
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(said.ends_with("the program still runs at <stdin>:3\n"), "{said}");
    assert_eq!(output.status.code(), Some(0));
}

/// `tmcl explain | head -1`: no complaint.
#[test]
fn a_reader_may_leave() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_tmcl"))
        .args(["commands", "tmcm-1311", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!((output.status.code(), output.stderr), (Some(0), Vec::new()));
}
