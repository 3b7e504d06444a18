//! The client against the virtual TMCM-1311 of `tmcl-server`, over TCP and over a pseudo terminal.
#![allow(clippy::disallowed_methods, reason = "a test of two programs and what is between them")]

use std::ops::ControlFlow;
use std::time::Duration;

use tmcl_client::{Client, ClientError, Heard, ProgramMode, ProgramStatus, Settings};
use tmcl_link::{Link, LinkError, open};
use tmcl_server::Server;
use tmcl_tables::{Command, Status, tmcm_1311::AxisParameter};
use tmcl_wire::Request;
use virtual_bench::{Bench, BenchConfig, ModuleKind};

fn server() -> Server {
    Server::start(Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311)), 1.0, |_| {})
}

/// Runs `test` with a client over each carrier, each with a module of its own.
fn over_every_carrier(name: &str, test: impl Fn(&mut Client<Box<dyn Link>>)) {
    let mut over_tcp = server();
    let address = over_tcp.listen_tcp("127.0.0.1:0").expect("a free port").to_string();
    test(&mut Client::new(open(&address).expect("it listens")));
    over_pty(name, &test);
}

#[cfg(unix)]
fn over_pty(name: &str, test: &impl Fn(&mut Client<Box<dyn Link>>)) {
    let path = std::env::temp_dir().join(format!("opentmcl-client-{}-{name}", std::process::id()));
    let mut server = server();
    server.listen_pty(&path).expect("a pseudo terminal");
    for baud_rate in [9600, 115_200] {
        let address = format!("serial:{}@{baud_rate}", path.display());
        test(&mut Client::new(open(&address).expect("it is there")));
    }
}

#[cfg(not(unix))]
fn over_pty(_: &str, _: &impl Fn(&mut Client<Box<dyn Link>>)) {}

fn number(parameter: AxisParameter) -> u8 {
    parameter.spec().number
}

#[test]
fn the_module_says_which_it_is() {
    over_every_carrier("version", |client| {
        assert_eq!(client.version_string().expect("it answers"), "1311V111");
        let version = client.firmware_version().expect("it answers");
        assert_eq!(version.to_string(), "TMCM-1311 V1.11");
        assert_eq!(client.module().map(|spec| spec.id), Some("tmcm-1311"));
    });
}

#[test]
fn parameters_are_written_and_read() {
    over_every_carrier("parameters", |client| {
        let speed = number(AxisParameter::MaxVelocity);
        for value in [0, 0x0A0D, 51_200, 0x0311_1304] {
            client.set_axis_parameter(speed, value).expect("it is in range");
            assert_eq!(client.get_axis_parameter(speed).expect("it answers"), value);
        }
        for value in [i32::MIN, -1, 0x0102_6406, i32::MAX] {
            client.set_global_parameter(2, 7, value).expect("a variable takes anything");
            assert_eq!(client.get_global_parameter(2, 7).expect("it answers"), value);
        }
        client.store_global_parameter(2, 7).expect("it can be stored");
        client.set_global_parameter(2, 7, 0).expect("a variable takes anything");
        client.restore_global_parameter(2, 7).expect("it was stored");
        assert_eq!(client.get_global_parameter(2, 7).expect("it answers"), i32::MAX);
    });
}

#[test]
fn the_motor_moves_and_stops() {
    over_every_carrier("motion", |client| {
        let (position, reached) =
            (number(AxisParameter::ActualPosition), number(AxisParameter::PositionReached));
        let start = client.get_axis_parameter(position).expect("it answers");
        client.move_by(500).expect("it starts");
        while client.get_axis_parameter(reached).expect("it answers") == 0 {}
        assert_eq!(client.get_axis_parameter(position).expect("it answers"), start + 500);
        client.move_to(0).expect("it starts");
        while client.get_axis_parameter(reached).expect("it answers") == 0 {}
        assert_eq!(client.get_axis_parameter(position).expect("it answers"), 0);
        client.rotate(-51_200).expect("it starts");
        while client.get_axis_parameter(position).expect("it answers") >= 0 {}
        client.stop_motor().expect("it stops");
        assert_eq!(client.get_axis_parameter(number(AxisParameter::TargetVelocity)).expect("it answers"), 0);
    });
}

#[test]
fn a_program_is_stored_read_back_run_and_stepped() {
    let counts_to_three = [
        Request::new(Command::GetGlobalParameter, 0, 2, 0),
        Request::new(Command::Calculate, 0, 0, 1),
        Request::new(Command::AccumulatorToGlobalParameter, 0, 2, 0),
        Request::new(Command::Compare, 0, 0, 3),
        Request::new(Command::JumpConditional, 6, 0, 0),
        Request::new(Command::Stop, 0, 0, 0),
    ]
    .map(Request::to_bytes);
    over_every_carrier("program", |client| {
        client.set_global_parameter(2, 0, 0).expect("a variable takes anything");
        let mut stored = 0;
        client.download(&counts_to_three, &mut |count| stored = count).expect("it is stored");
        assert_eq!(stored, counts_to_three.len());
        client.verify(&counts_to_three, &mut |_| {}).expect("it reads back");
        client.reset_program().expect("it answers");
        client.step_program().expect("it answers");
        let stepped = client.program_status().expect("it answers");
        assert_eq!(stepped, ProgramStatus { mode: ProgramMode::Stepping, address: 1 });
        client.run(Some(0)).expect("address 0 is in the memory");
        let end = client.wait_until_stopped(|_| ControlFlow::Continue(())).expect("it answers");
        assert_eq!(end, ProgramStatus { mode: ProgramMode::Stopped, address: 5 });
        assert_eq!(client.get_global_parameter(2, 0).expect("it answers"), 3);
        let refused = client.run(Some(2048));
        assert!(
            matches!(refused, Err(ClientError::Status { status: Status::InvalidValue, .. })),
            "{refused:?}"
        );
    });
}

#[test]
fn outputs_are_set_and_read_back() {
    over_every_carrier("ports", |client| {
        for value in [1, 0] {
            client.set_output(0, value).expect("there is one");
            assert_eq!(client.get_input(2, 0).expect("there is one"), value);
        }
    });
}

#[test]
fn refusals_carry_their_status() {
    over_every_carrier("refusals", |client| {
        let mut status_of =
            |command, kind, motor, value| match client.request(Request::new(command, kind, motor, value)) {
                Err(ClientError::Status { status, .. }) => status,
                other => panic!("{other:?}"),
            };
        assert_eq!(status_of(Command::GetAxisParameter, 21, 0, 0), Status::WrongType);
        assert_eq!(status_of(Command::GetAxisParameter, 1, 1, 0), Status::InvalidValue);
        assert_eq!(status_of(Command::SetAxisParameter, 4, 0, -1), Status::InvalidValue);
        assert_eq!(status_of(Command::Jump, 0, 0, 0), Status::NotAvailable);
    });
}

#[test]
fn a_module_that_is_not_there_does_not_answer() {
    over_every_carrier("absent", |client| {
        let timeout = Duration::from_millis(150);
        *client.settings_mut() = Settings { module_address: 9, timeout, ..Settings::default() };
        match client.get_axis_parameter(1) {
            Err(ClientError::NoReply { attempts: 3, heard: Heard::Nothing, .. }) => {}
            other => panic!("{other:?}"),
        }
        client.settings_mut().module_address = 1;
        client.get_axis_parameter(1).expect("this one is there");
    });
}

/// A client that was killed in mid request, as far as the module can tell.
#[test]
fn a_line_that_was_left_in_mid_request_is_usable() {
    over_every_carrier("half", |client| {
        client.link_mut().write(&[1, 4, 0, 0]).expect("the line works");
        client.settings_mut().timeout = Duration::from_millis(200);
        assert_eq!(client.version_string().expect("it answers in the end"), "1311V111");
        client.settings_mut().host_address = 3;
        match client.get_axis_parameter(1) {
            Err(ClientError::NoReply { heard: Heard::Other { host: 2, module: 1 }, .. }) => {}
            other => panic!("{other:?}"),
        }
    });
}

#[test]
fn a_server_that_ends_is_reported() {
    let mut server = server();
    let address = server.listen_tcp("127.0.0.1:0").expect("a free port");
    let mut client = Client::new(open(&address.to_string()).expect("it listens"));
    client.firmware_version().expect("it answers");
    drop(server);
    let error = client.firmware_version().expect_err("nobody is there");
    assert!(matches!(error, ClientError::Link(LinkError::Closed { .. })), "{error}");
}
