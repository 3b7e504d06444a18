//! What a panel of a plot shows, as `--panel` says it: a title, perhaps a unit, and the names of the curves.
//!
//! ```text
//! [xy] [TITLE [UNIT]:] [dashed|band] NAME [as LABEL], …
//! ```
//!
//! Only the text is understood here; whether a name means anything on a bench is not known.

/// A panel as it was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PanelText {
    /// Stands above it; may be empty.
    pub(crate) title: String,
    /// The unit all of it is shown in, where one was named.
    pub(crate) unit: Option<String>,
    /// The curves, one at least.
    pub(crate) curves: Vec<CurveText>,
    /// Whether the second curve is drawn over the first, and not both over time. There are two then.
    pub(crate) xy: bool,
}

/// A curve as it was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CurveText {
    /// What a trace calls it.
    pub(crate) name: String,
    /// What the legend calls it.
    pub(crate) label: String,
    /// How it is drawn.
    pub(crate) look: Look,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// A line.
    Solid,
    /// A dashed line.
    Dashed,
    /// No line: the panel is shaded while the value is not 0.
    Band,
}

/// There are so many colours.
const MOST_CURVES: usize = 6;

/// Reads a panel.
pub(crate) fn parse(text: &str) -> Result<PanelText, String> {
    let (xy, rest) = match text.trim().strip_prefix("xy") {
        Some(rest) if rest.starts_with([' ', ':', '[']) => (true, rest),
        _ => (false, text),
    };
    let (head, names) = rest.split_once(':').unwrap_or(("", rest));
    let (title, unit) = titled(head.trim())?;
    let curves = names.split(',').map(|item| curve(item.trim())).collect::<Result<Vec<_>, _>>()?;
    if curves.len() > MOST_CURVES {
        return Err(format!(
            "a panel shows {MOST_CURVES} curves at most; --panel may be given several times"
        ));
    }
    if xy && (curves.len() != 2 || curves.iter().any(|curve| curve.look != Look::Solid)) {
        return Err("an xy panel takes two names: what is drawn to the right, and what upwards".to_owned());
    }
    let title = match curves.as_slice() {
        [only] if title.is_empty() => only.label.clone(),
        _ => title,
    };
    Ok(PanelText { title, unit, curves, xy })
}

/// `TITLE [UNIT]`.
fn titled(head: &str) -> Result<(String, Option<String>), String> {
    let Some((title, unit)) = head.strip_suffix(']').and_then(|head| head.rsplit_once('[')) else {
        return Ok((head.to_owned(), None));
    };
    // Few keyboards have a µ.
    let unit = match unit.trim() {
        "" => return Err("there is no unit between `[` and `]`".to_owned()),
        "ustep" => "µstep",
        unit => unit,
    };
    Ok((title.trim().to_owned(), Some(unit.to_owned())))
}

/// `[dashed|band] NAME [as LABEL]`.
fn curve(item: &str) -> Result<CurveText, String> {
    let (item, label) = match item.split_once(" as ") {
        Some((item, label)) => (item.trim(), Some(label.trim())),
        None => (item, None),
    };
    let (look, name) = match item.split_once(' ') {
        Some(("dashed", name)) => (Look::Dashed, name.trim()),
        Some(("band", name)) => (Look::Band, name.trim()),
        Some((name, _)) => {
            return Err(format!(
                "`{name}` is followed by neither `,` nor `as LABEL`; only `dashed` and `band` stand before a name"
            ));
        }
        None => (Look::Solid, item),
    };
    if ["", "dashed", "band"].contains(&name) || label == Some("") {
        return Err("a name is missing: write `TITLE: NAME, NAME as LABEL`".to_owned());
    }
    if name.contains(' ') {
        return Err(format!("`{name}` is no name"));
    }
    Ok(CurveText { name: name.to_owned(), label: label.unwrap_or(name).to_owned(), look })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn curve(name: &str, label: &str, look: Look) -> CurveText {
        CurveText { name: name.to_owned(), label: label.to_owned(), look }
    }

    #[test]
    fn everything_at_once() {
        let panel = parse(
            "Way there [turn]: physical.rotor_turns as shaft, dashed actual_position, band home_switch as home",
        );
        let curves = vec![
            curve("physical.rotor_turns", "shaft", Look::Solid),
            curve("actual_position", "actual_position", Look::Dashed),
            curve("home_switch", "home", Look::Band),
        ];
        let unit = Some("turn".to_owned());
        assert_eq!(panel, Ok(PanelText { title: "Way there".to_owned(), unit, curves, xy: false }));
    }

    #[test]
    fn one_name_is_enough() {
        let panel = parse("supply_voltage").unwrap();
        assert_eq!((panel.title.as_str(), panel.unit, panel.curves.len()), ("supply_voltage", None, 1));
        assert_eq!(parse("a, b").unwrap().title, "");
        assert_eq!(parse("[ustep]: a").unwrap().unit.as_deref(), Some("µstep"));
    }

    #[test]
    fn one_over_the_other() {
        let panel = parse("xy Phase currents [A]: phase_a_current as A, phase_b_current as B").unwrap();
        assert_eq!((panel.xy, panel.title.as_str()), (true, "Phase currents"));
        assert_eq!(panel.curves[1], curve("phase_b_current", "B", Look::Solid));
        assert!(parse("xy: a, b").unwrap().xy);
        assert!(!parse("xylophone: a, b").unwrap().xy);
        for wrong in ["xy: a", "xy: a, b, c", "xy: a, band b"] {
            assert!(parse(wrong).unwrap_err().contains("takes two names"), "{wrong}");
        }
    }

    #[test]
    fn what_is_no_panel() {
        for wrong in
            ["", " ", "a:", "a: b,", "a: ,b", "a: b as ", "a: dashed ", "[]: a", "a b", "a: band b c"]
        {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
        assert!(parse("a, b, c, d, e, f, g").unwrap_err().contains("6 curves at most"));
    }

    proptest! {
        #[test]
        fn whatever_the_text(text in ".{0,80}") {
            if let Ok(panel) = parse(&text) {
                prop_assert!((1..=MOST_CURVES).contains(&panel.curves.len()));
                prop_assert!(panel.curves.iter().all(|curve| !curve.name.is_empty() && !curve.label.is_empty()));
            }
        }

        #[test]
        fn whatever_is_nearly_a_panel(
            text in "(xy )?[a-c]{0,2} ?(\\[[a-z]{0,2}\\])?:? ?((dashed|band|as)? ?[a-c]{0,2}( as [a-c]{0,2})?,? ?){0,4}",
        ) {
            if let Ok(panel) = parse(&text) {
                prop_assert!(!panel.xy || panel.curves.len() == 2);
                prop_assert!(panel.curves.iter().all(|curve| !curve.name.contains([' ', ',', ':'])));
            }
        }
    }
}
