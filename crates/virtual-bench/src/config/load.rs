//! `[module.load]`: what the motor turns.

use motor_physics::load::{LoadTorque, MAX_POINTS, Profile};
use motor_physics::mechanics::HardStops;
use toml::de::DeValue;

use super::error::ConfigError;
use super::quantity;
use super::section::{self, Entry, Section};
use crate::ModuleKind;

/// The load on a motor's shaft.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadConfig {
    /// Moment of inertia, the rotor's own not included; 0 to 10 kgm².
    pub inertia_kgm2: f64,
    /// Coulomb friction, 0 to 100 Nm.
    pub friction_nm: f64,
    /// Viscous friction, 0 to 1 Nm·s/rad.
    pub viscous_nm_s_per_rad: f64,
    /// The torque from outside; a positive one drives the shaft to the right (as ROR does), a weight that pulls it back is
    /// negative.
    pub torque: LoadTorque,
    /// Where travel ends, if it does; one of the ends may be infinitely far. The shaft starts at 0, between them.
    pub hard_stops: Option<HardStops>,
}

/// Bounce of a hard stop that says nothing about it (chosen: steel on steel through a coupling).
const DEFAULT_RESTITUTION: f64 = 0.3;

impl LoadConfig {
    /// The load on a module of this kind unless the file says otherwise: a free shaft, with friction that lets it settle.
    ///
    /// Chosen: with a QSH5718-51-28-101 at the TMCM-1311's default current a shaft released one full step off comes to rest,
    /// within a twentieth of a step, after 85 ms; it crosses its resonance near one turn a second without coming more than
    /// 0.4 full steps off; it rests within 0.02 full steps; and at 20 turns a second the friction takes 6 % of the holding
    /// torque. With a QBL4208-61-04-013 the friction at 4000 rpm takes 0.0134 Nm, a current of 0.37 A between two lines: what
    /// such a motor takes without load.
    #[must_use]
    pub fn default_for(kind: ModuleKind) -> Self {
        let (friction_nm, viscous_nm_s_per_rad) = match kind {
            ModuleKind::Tmcm1311 | ModuleKind::Tmcm1076 => (0.01, 4e-4),
            ModuleKind::Tmcm1640 => (0.005, 2e-5),
        };
        Self {
            inertia_kgm2: 0.0,
            friction_nm,
            viscous_nm_s_per_rad,
            torque: LoadTorque::Constant(0.0),
            hard_stops: None,
        }
    }
}

/// Reads the section.
pub(super) fn read(mut section: Section<'_, '_>, kind: ModuleKind) -> LoadConfig {
    let default = LoadConfig::default_for(kind);
    let load = LoadConfig {
        inertia_kgm2: section.number("inertia_kgm2", &quantity::LOAD_INERTIA).unwrap_or(default.inertia_kgm2),
        friction_nm: section.number("friction_nm", &quantity::FRICTION).unwrap_or(default.friction_nm),
        viscous_nm_s_per_rad: section
            .number("viscous_nm_s_per_rad", &quantity::VISCOUS)
            .unwrap_or(default.viscous_nm_s_per_rad),
        torque: read_torque(&mut section).unwrap_or(default.torque),
        hard_stops: section.section("hard_stops", "module.load.hard_stops").map(read_hard_stops),
    };
    section.finish();
    load
}

fn read_torque(section: &mut Section<'_, '_>) -> Option<LoadTorque> {
    let constant = section.number("torque_nm", &quantity::TORQUE).map(LoadTorque::Constant);
    let profile = section.section("torque", "module.load.torque").and_then(read_profile);
    if section.key_span("torque_nm").is_some()
        && let Some(span) = section.key_span("torque")
    {
        section.complain(
            ConfigError::new(span, "torque and torque_nm exclude each other")
                .with_help("torque_nm is the same torque always, torque is a profile"),
        );
    }
    constant.or(profile)
}

/// What a torque profile depends on.
#[derive(Clone, Copy)]
enum Axis {
    Position,
    Time,
}

fn read_profile(mut section: Section<'_, '_>) -> Option<LoadTorque> {
    let by = section.choice("by", &[("position", Axis::Position), ("time", Axis::Time)]);
    let points = section.entry("points").and_then(|entry| read_points(entry, &mut section));
    let period = section.number("period", &quantity::PERIOD);
    for (key, help) in [("by", "by = \"position\" or \"time\""), ("points", "points = [[x, torque_nm], ...]")]
    {
        if section.key_span(key).is_none() {
            let message = format!("{} lacks {key}", section.title());
            section.complain_here(message, Some(help.to_owned()));
        }
    }
    if let (Some(points), Some(period)) = (&points, period) {
        check_period(&mut section, points, period);
    }
    section.finish();
    let (by, points) = (by?, points?);
    let profile = Profile::new(&points, period)?;
    Some(match by {
        Axis::Position => LoadTorque::ByPosition(profile),
        Axis::Time => LoadTorque::ByTime(profile),
    })
}

fn check_period(section: &mut Section<'_, '_>, points: &[(f64, f64)], period: f64) {
    let outside = points.iter().find(|(x, _)| !(0.0..=period).contains(x));
    if let (Some((x, _)), Some(span)) = (outside, section.key_span("points")) {
        let message =
            format!("the points of a profile with a period must lie from 0 to {period}, not at {x}");
        section.complain(ConfigError::new(span, message));
    }
}

fn read_points(entry: Entry<'_>, section: &mut Section<'_, '_>) -> Option<Vec<(f64, f64)>> {
    let DeValue::Array(list) = entry.get_ref() else {
        section.complain(section::wrong_type("points", "a list of points, [[x, torque_nm], ...]", entry));
        return None;
    };
    if list.is_empty() || list.len() > MAX_POINTS {
        let message = format!("points must be 1 to {MAX_POINTS} points, not {}", list.len());
        section.complain(ConfigError::new(entry.span(), message));
        return None;
    }
    let mut points: Vec<(f64, f64)> = Vec::new();
    for entry in list {
        match read_point(entry, points.last().copied()) {
            Ok(point) => points.push(point),
            Err(error) => section.complain(error),
        }
    }
    (points.len() == list.len()).then_some(points)
}

fn read_point(entry: Entry<'_>, before: Option<(f64, f64)>) -> Result<(f64, f64), ConfigError> {
    let pair = entry.get_ref().as_array().and_then(|pair| Some((pair.first()?, pair.get(1)?, pair.len())));
    let Some((x_entry, torque_entry, 2)) = pair else {
        return Err(ConfigError::new(entry.span(), "a point must be a pair [x, torque_nm]"));
    };
    let check = |name, quantity: &quantity::Quantity, entry: Entry<'_>| {
        let value = section::number(name, entry)?;
        quantity.check(name, value).map_err(|message| ConfigError::new(entry.span(), message))
    };
    let x = check("x", &quantity::PROFILE_X, x_entry)?;
    let torque_nm = check("torque_nm", &quantity::TORQUE, torque_entry)?;
    if let Some((before, _)) = before.filter(|(before, _)| *before >= x) {
        let message = format!("the x of points must ascend, but {x} follows {before}");
        return Err(ConfigError::new(x_entry.span(), message)
            .with_help("a jump is two points close to each other, or an [[event]]"));
    }
    Ok((x, torque_nm))
}

fn read_hard_stops(mut section: Section<'_, '_>) -> HardStops {
    let low_turns = section.number("low_turns", &quantity::TURNS_TO_START);
    let high_turns = section.number("high_turns", &quantity::TURNS_FROM_START);
    let restitution = section.number("restitution", &quantity::RESTITUTION);
    if section.key_span("low_turns").is_none() && section.key_span("high_turns").is_none() {
        let message = format!("{} lacks low_turns, high_turns", section.title());
        section.complain_here(message, Some("one of them or both; the shaft starts at 0 turns".to_owned()));
    }
    section.finish();
    HardStops {
        low_turns: low_turns.unwrap_or(f64::NEG_INFINITY),
        high_turns: high_turns.unwrap_or(f64::INFINITY),
        restitution: restitution.unwrap_or(DEFAULT_RESTITUTION),
    }
}
