//! The figure the tests draw: a move of a stepper motor with a load step, as its controller and its shaft see it.

use std::f64::consts::TAU;

use super::{Figure, Panel, Series, Style};

fn series(name: &str, values: Vec<f64>, style: Style) -> Series {
    Series { name: name.to_owned(), values, style }
}

fn panel(title: &str, unit: &str, series: Vec<Series>) -> Panel {
    Panel { title: title.to_owned(), unit: unit.to_owned(), across: None, series }
}

/// Two seconds in so many samples: half a second up to 60 rpm, one second there, half a second down.
pub(super) fn movement(samples: usize) -> Figure {
    let time_s: Vec<f64> = (0..samples).map(|index| 2.0 * index as f64 / (samples - 1) as f64).collect();
    let at = |value: fn(f64) -> f64| time_s.iter().map(|&time_s| value(time_s)).collect::<Vec<f64>>();
    let solid = Style::Solid;
    let panels = vec![
        panel(
            "position",
            "turns",
            vec![
                series("commanded", at(turns), solid),
                series("physical", at(physical_turns), Style::Dashed),
            ],
        ),
        panel("velocity", "rpm", vec![series("velocity", at(rpm), solid)]),
        panel(
            "coil currents",
            "A",
            vec![
                series("coil A", at(|time_s| 1.4 * (4.0 * TAU * turns(time_s)).cos()), solid),
                series("coil B", at(|time_s| 1.4 * (4.0 * TAU * turns(time_s)).sin()), solid),
            ],
        ),
        panel("load torque", "N·m", vec![series("load torque", at(load_nm), solid)]),
    ];
    Figure { title: "MVP ABS, 76800 microsteps".to_owned(), time_s, panels }
}

fn rpm(time_s: f64) -> f64 {
    (120.0 * time_s).min(60.0).min(120.0 * (2.0 - time_s))
}

fn turns(time_s: f64) -> f64 {
    if time_s < 0.5 {
        time_s * time_s
    } else if time_s < 1.5 {
        time_s - 0.25
    } else {
        1.5 - (2.0 - time_s) * (2.0 - time_s)
    }
}

/// Stalls at the load step and then stands.
fn physical_turns(time_s: f64) -> f64 {
    turns(time_s.min(1.1)) - 0.01 * rpm(time_s.min(1.1)) / 60.0
}

fn load_nm(time_s: f64) -> f64 {
    if time_s < 1.1 { 0.02 } else { 0.12 }
}
