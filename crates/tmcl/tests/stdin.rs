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

/// Lines of stdin are commands, and errors name them.
#[test]
fn commands_come_through_a_pipe() {
    let port = ["--port", "virtual:tmcm-1311"];
    let exec = |input: &[u8]| tmcl(&[&["exec", "-", "--json"], &port[..]].concat(), input);
    let output = exec(b"// where it is\nTurn = 51200\n\nMVP REL, 0, Turn\nGAP 0, 0\n");
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    assert_eq!(output.status.code(), Some(0));
    assert!(said.contains("\"command\": \"GAP 0, 0\"") && said.contains("\"value\": 51200"), "{said}");
    let output = exec(b"GAP 1, 0\nGAP Nothing, 0\n");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(said.contains("--> <stdin>:2:5\n") && said.ends_with("error: nothing was sent\n"), "{said}");
    assert_eq!((output.status.code(), output.stdout), (Some(2), Vec::new()));
}

/// Time passes on a virtual module while the shell waits. One line for each exchange, and no prompt.
#[test]
fn a_shell_talks_through_a_pipe() {
    let input = b"set max_velocity=51200\nMVP ABS, 0, 51200\nget actual_position\nwait 3s\nget actual_position status_word\n\
                  help MVP\nexit\nGAP 1, 0\n";
    let output = tmcl(&["shell", "--port", "virtual:tmcm-1311"], input);
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    let lines: Vec<&str> = said.lines().collect();
    let expected = [
        "SAP 4, 0, 51200         01 05 04 00 00 00 c8 00 d2  100 OK    51200 pps  Maximum positioning speed",
        "MVP ABS, 0, 51200       01 04 00 00 00 00 c8 00 cd  100 OK    51200  Move to position",
        "GAP 1, 0                01 06 01 00 00 00 00 00 08  100 OK    0 \u{b5}step  Actual position (encoder step in closed loop)",
        "GAP 1, 0                01 06 01 00 00 00 00 00 08  100 OK    51200 \u{b5}step  Actual position (encoder step in closed loop)",
        "GAP 18, 0               01 06 12 00 00 00 00 00 19  100 OK    9  Status word: target_reached, position_mode",
        "MVP KEYWORD, MOTOR, POSITION",
    ];
    assert_eq!(lines.get(..6), Some(&expected[..]));
    assert_eq!((output.status.code(), lines.len()), (Some(0), 10), "{said}");
}

/// The shell goes on after an error; the worst of them is its exit code.
#[test]
fn a_shell_tells_the_worst() {
    let code = |input: &[u8]| tmcl(&["shell", "--port", "virtual:tmcm-1311"], input).status.code();
    assert_eq!(code(b""), Some(0));
    assert_eq!(code(b"get nothing\nGAP 1, 0\n"), Some(2));
    assert_eq!(code(b"set max_velocity\nwait long\nJA 1\n"), Some(2));
    assert_eq!(code(b"GAP 29, 0\nget nothing\n"), Some(4));
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
