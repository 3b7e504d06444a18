//! Near misses.

/// How alike two words must be, from 0 to 1, for one to be taken for a slip of the other.
const ALIKE: f64 = 0.75;

/// The choices, and the nearest one first if `word` looks like a slip of it.
pub(super) fn help(word: &str, choices: &[&str]) -> String {
    let allowed = format!("allowed here: {}", choices.join(", "));
    match nearest(word, choices) {
        Some(choice) => format!("did you mean \"{choice}\"? {}", capitalised(&allowed)),
        None => allowed,
    }
}

/// The choice that `word` is a slip of. Leaving out a unit ("voltage" for "voltage_v") is one too.
pub(crate) fn nearest<'c>(word: &str, choices: &[&'c str]) -> Option<&'c str> {
    let word = word.to_lowercase();
    let likeness = |choice: &str| {
        let choice = choice.to_lowercase();
        let unit_left_out = choice.strip_prefix(&word).is_some_and(|rest| rest.starts_with('_'));
        if unit_left_out { 1.0 } else { strsim::normalized_damerau_levenshtein(&word, &choice) }
    };
    let scored = choices.iter().map(|choice| (likeness(choice), *choice));
    scored.filter(|(score, _)| *score >= ALIKE).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, choice)| choice)
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognised_and_strangers_are_not() {
        let choices = ["torque_nm", "friction_nm", "inertia_kgm2"];
        assert_eq!(nearest("torqe_nm", &choices), Some("torque_nm"));
        assert_eq!(nearest("Torque", &choices), Some("torque_nm"));
        assert_eq!(nearest("inertia_kg", &choices), Some("inertia_kgm2"));
        assert_eq!(nearest("colour", &choices), None);
        assert_eq!(nearest("", &choices), None);
    }

    #[test]
    fn help_names_the_nearest_and_all() {
        assert_eq!(help("lo", &["low", "high"]), "allowed here: low, high");
        assert_eq!(help("hihg", &["low", "high"]), "did you mean \"high\"? Allowed here: low, high");
    }
}
