//! Stop switches of the TMCM-1640 (§5.1 AP 164, 166; decisions 6.9), the inputs they sit on, and what programs wait for.

use crate::common::bldc::Bldc;
use crate::common::program::{STOP, kind, wait};
use tmcl_tables::tmcm_1640::AxisParameter as Ap;
use tmcl_tables::{Command, Status};

/// IN_0 and IN_1, and the bits of AP 164 and 166 for the switches on them.
#[derive(Clone, Copy, Debug)]
struct Switch {
    input: u8,
    bit: i32,
    /// Where it stops the motor.
    direction: i32,
}

const RIGHT: Switch = Switch { input: 0, bit: 0b10, direction: 1 };
const LEFT: Switch = Switch { input: 1, bit: 0b01, direction: -1 };

impl Switch {
    fn set(self, axis: &mut Bldc, level: i32) {
        axis.set(&format!("input.{}", self.input), level);
    }
}

/// Ready to turn quickly, with these switches enabled.
fn axis(enabled: i32, polarity: i32) -> Bldc {
    let mut axis = Bldc::strong();
    axis.set_all(&[
        (Ap::MaxAcceleration, 20_000),
        (Ap::StopSwitchPolarity, polarity),
        (Ap::StopSwitchEnable, enabled),
    ]);
    axis
}

fn turns(axis: &mut Bldc, rpm: i32) -> bool {
    axis.rotate(rpm);
    axis.run_ms(400);
    let from = axis.turns();
    axis.run_ms(300);
    let turned = axis.turns() - from;
    let wanted = f64::from(rpm) / 60.0 * 0.3;
    let moves = (turned / wanted - 1.0).abs() < 0.1;
    assert!(moves || turned.abs() < 0.05, "neither turning nor standing: {}", axis.figures());
    moves
}

#[test]
fn an_active_switch_stops_motion_towards_it_only() {
    for switch in [RIGHT, LEFT] {
        for (polarity, active) in [(3, 1), (0, 0)] {
            let mut axis = axis(0, polarity);
            // Both inactive before they are enabled.
            RIGHT.set(&mut axis, 1 - active);
            LEFT.set(&mut axis, 1 - active);
            axis.sap(Ap::StopSwitchEnable, switch.bit);
            assert!(turns(&mut axis, 600 * switch.direction), "{switch:?}: inactive");
            switch.set(&mut axis, active);
            axis.run_ms(300);
            assert!(axis.rpm().abs() < 15.0, "{switch:?}, polarity {polarity}: {}", axis.figures());
            assert!(!turns(&mut axis, 600 * switch.direction), "{switch:?}: still towards it");
            assert!(turns(&mut axis, -600 * switch.direction), "{switch:?}: away from it");
            switch.set(&mut axis, 1 - active);
            assert!(turns(&mut axis, 600 * switch.direction), "{switch:?}: inactive again");
        }
    }
}

#[test]
fn each_bit_of_the_polarity_is_for_its_switch() {
    // Low is active for the left one only.
    let mut axis = axis(3, 0b10);
    assert!(turns(&mut axis, 600), "IN_0 = 0 is inactive");
    assert!(!turns(&mut axis, -600), "IN_1 = 0 is active");
    LEFT.set(&mut axis, 1);
    assert!(turns(&mut axis, -600));
    RIGHT.set(&mut axis, 1);
    assert!(!turns(&mut axis, 600));
}

#[test]
fn a_switch_that_is_not_enabled_or_belongs_to_the_other_direction_does_nothing() {
    for switch in [RIGHT, LEFT] {
        let mut axis = axis(0b11 & !switch.bit, 3);
        switch.set(&mut axis, 1);
        assert!(turns(&mut axis, 600) && turns(&mut axis, -600), "{switch:?}");
    }
}

/// A move ends at the switch, short of its target and without the end flag.
#[test]
fn a_move_stops_at_the_switch() {
    let mut axis = axis(0, 3);
    axis.use_encoder();
    axis.sap(Ap::StopSwitchEnable, 3);
    axis.sap(Ap::ActualPosition, 0);
    let zero = axis.turns();
    axis.go(10 * 4096);
    while axis.turns() - zero < 4.0 {
        axis.run_ticks(1);
    }
    RIGHT.set(&mut axis, 1);
    axis.run_ms(1000);
    let turned = axis.turns() - zero;
    assert!((4.0..8.0).contains(&turned), "{}", axis.figures());
    assert!(axis.rpm().abs() < 15.0, "{}", axis.figures());
    assert_eq!(axis.gap(Ap::PositionReached), 0);
    axis.go(0);
    axis.run_ms(100);
    RIGHT.set(&mut axis, 0);
    axis.reach(8000);
    axis.run_ms(3000);
    assert!((axis.turns() - zero).abs() < 0.003, "back from it: {}", axis.figures());
}

#[test]
fn inputs_are_read_whether_they_are_switches_or_not() {
    let mut axis = Bldc::new();
    for input in [0, 1] {
        assert_eq!(axis.ok(Command::GetInput, input, 0, 0), 0, "idle");
        axis.set(&format!("input.{input}"), 1);
        axis.run_ms(1);
        assert_eq!(axis.ok(Command::GetInput, input, 0, 0), 1);
    }
    assert_eq!(axis.ok(Command::GetInput, 255, 0, 0), 0b11);
}

/// WAIT (§4.6.19): every condition, on a program that then switches the output on.
mod waiting {
    use super::*;

    /// Runs this WAIT and then SIO 0, 2, 1; both inputs are active high.
    fn waiting(condition: u8, timeout: i32) -> Bldc {
        let mut axis = axis(0, 3);
        axis.download(&[wait(condition, timeout), crate::common::program::sio(0, 1), STOP]);
        axis
    }

    fn gone_on(axis: &mut Bldc) -> bool {
        axis.ok(Command::GetInput, 0, 2, 0) == 1
    }

    #[test]
    fn ticks_are_10_ms() {
        let mut axis = waiting(kind::TICKS, 20);
        axis.run_from(0);
        axis.run_ms(198);
        assert!(!gone_on(&mut axis));
        axis.run_ms(4);
        assert!(gone_on(&mut axis));
    }

    #[test]
    fn pos_waits_for_the_end_flag() {
        let mut axis = waiting(kind::POS, 0);
        axis.use_encoder();
        axis.go_by(8192);
        axis.run_from(0);
        let mut ms = 0;
        while axis.gap(Ap::PositionReached) == 0 {
            assert!(!gone_on(&mut axis), "{}", axis.figures());
            axis.run_ms(1);
            ms += 1;
            assert!(ms < 3000);
        }
        axis.run_ms(2);
        assert!(gone_on(&mut axis));
    }

    #[test]
    fn refsw_and_limsw_wait_for_a_stop_switch() {
        for condition in [kind::REFSW, kind::LIMSW] {
            for switch in [RIGHT, LEFT] {
                let mut axis = waiting(condition, 0);
                axis.run_from(0);
                axis.run_ms(500);
                assert!(!gone_on(&mut axis), "{condition} {switch:?}");
                switch.set(&mut axis, 1);
                axis.run_ms(2);
                assert!(gone_on(&mut axis), "{condition} {switch:?}");
            }
        }
    }

    #[test]
    fn rfs_goes_on_at_once() {
        let mut axis = waiting(kind::RFS, 0);
        axis.run_from(0);
        axis.run_ms(1);
        assert!(gone_on(&mut axis));
    }

    /// JC ETO tells a timeout, and CLE takes it back.
    #[test]
    fn a_timeout_sets_eto() {
        use crate::common::program::{jc, op, sio};
        let mut axis = axis(0, 3);
        axis.download(&[
            wait(kind::REFSW, 10),
            jc(kind::ETO, 3),
            STOP,
            sio(0, 1),
            op(Command::ClearErrorFlags, 1, 0, 0),
            jc(kind::ETO, 7),
            STOP,
            sio(0, 0),
            STOP,
        ]);
        axis.run_from(0);
        axis.run_ms(95);
        assert!(!gone_on(&mut axis));
        axis.run_ms(10);
        assert!(gone_on(&mut axis), "after 100 ms");
        assert_eq!(axis.refused(), []);
    }
}

/// SIO 255 and the one output there is.
#[test]
fn the_output_is_switched_and_read_back() {
    let mut axis = Bldc::new();
    for (kind, value, level) in [(0, 1, 1), (0, 0, 0), (255, 1, 1), (255, 0, 0)] {
        axis.ok(Command::SetOutput, kind, 2, value);
        axis.run_ms(1);
        assert_eq!(axis.ok(Command::GetInput, 0, 2, 0), level);
        assert_eq!(axis.read("output.0"), f64::from(level));
    }
    assert_eq!(axis.status(Command::SetOutput, 1, 2, 1), Status::WrongType);
    assert_eq!(axis.status(Command::SetOutput, 0, 2, 2), Status::InvalidValue);
}
