//! `[module.switches]`: stop and home switches along the travel.

use motor_physics::switch::SwitchConfig;

use super::error::ConfigError;
use super::quantity;
use super::section::Section;
use crate::ModuleKind;
use bench_hardware::SwitchName;

/// The switches of a module. A switch that is not there is one that never opens.
///
/// The contacts are normally closed (decision: reference search): a switch that the shaft presses is open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SwitchesConfig {
    /// The left stop switch; on a TMCM-1640 it is wired to IN_1.
    pub left: Option<SwitchConfig>,
    /// The right stop switch; on a TMCM-1640 it is wired to IN_0.
    pub right: Option<SwitchConfig>,
    /// The home switch; on a TMCM-1311 it is wired to IN_1. A TMCM-1640 has none.
    pub home: Option<SwitchConfig>,
}

impl SwitchesConfig {
    /// A switch by its name.
    #[must_use]
    pub fn get(&self, name: SwitchName) -> Option<SwitchConfig> {
        match name {
            SwitchName::Left => self.left,
            SwitchName::Right => self.right,
            SwitchName::Home => self.home,
        }
    }
}

/// Width of a home switch that says nothing about it (chosen: ten full steps of a 200-step motor).
const DEFAULT_WIDTH_TURNS: f64 = 0.05;

const NS_PER_MS: f64 = 1e6;

/// Which part of the travel presses a switch.
#[derive(Clone, Copy)]
enum Side {
    /// `at_turns` and below.
    Below,
    /// `at_turns` and above.
    Above,
    /// So many turns around `at_turns`.
    Window(f64),
}

/// Reads the section.
pub(super) fn read(mut section: Section<'_, '_>, kind: ModuleKind) -> SwitchesConfig {
    let home_there = has_home(kind);
    if !home_there && let Some(span) = section.key_span("home") {
        section.entry("home");
        let message = format!("the {} has no home switch", kind.spec().id);
        section.complain(ConfigError::new(span, message).with_help("it has a left and a right one"));
    }
    let mut switch = |key, name, usual| read_switch(section.section(key, name)?, usual);
    let switches = SwitchesConfig {
        left: switch("left", "module.switches.left", Side::Below),
        right: switch("right", "module.switches.right", Side::Above),
        home: home_there
            .then(|| switch("home", "module.switches.home", Side::Window(DEFAULT_WIDTH_TURNS)))
            .flatten(),
    };
    section.finish();
    switches
}

fn has_home(kind: ModuleKind) -> bool {
    match kind {
        ModuleKind::Tmcm1311 => true,
        ModuleKind::Tmcm1640 | ModuleKind::Tmcm1076 => false,
    }
}

fn read_switch(mut section: Section<'_, '_>, usual: Side) -> Option<SwitchConfig> {
    let at_turns = section.number("at_turns", &quantity::TURNS);
    let side = section.choice("side", &[("below", Side::Below), ("above", Side::Above)]);
    let window = section.number("width_turns", &quantity::WIDTH).map(Side::Window);
    let bounce_ms = section.number("bounce_ms", &quantity::BOUNCE).unwrap_or(0.0);
    if section.key_span("at_turns").is_none() {
        let message = format!("{} lacks at_turns", section.title());
        section
            .complain_here(message, Some("where the shaft presses it, in turns from the start".to_owned()));
    }
    if section.key_span("side").is_some()
        && let Some(span) = section.key_span("width_turns")
    {
        section.complain(
            ConfigError::new(span, "width_turns and side exclude each other")
                .with_help("a switch is pressed on one side of at_turns, or within a window around it"),
        );
    }
    section.finish();
    let (from_turns, to_turns) = stretch(at_turns?, window.or(side).unwrap_or(usual));
    Some(SwitchConfig { from_turns, to_turns, bounce_ns: libm::round(bounce_ms * NS_PER_MS) as u64 })
}

/// From where to where a switch is pressed.
fn stretch(at_turns: f64, side: Side) -> (f64, f64) {
    match side {
        Side::Below => (f64::NEG_INFINITY, at_turns),
        Side::Above => (at_turns, f64::INFINITY),
        Side::Window(width_turns) => (at_turns - width_turns / 2.0, at_turns + width_turns / 2.0),
    }
}
