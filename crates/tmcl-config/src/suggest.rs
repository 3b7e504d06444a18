//! Near misses.

/// How alike two words must be, from 0 to 1, for one to be taken for a slip of the other.
const ALIKE: f64 = 0.75;

/// The choice that `word` is a slip of.
pub(crate) fn nearest<'c>(word: &str, choices: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let word = word.to_lowercase();
    let scored = choices
        .into_iter()
        .map(|choice| (strsim::normalized_damerau_levenshtein(&word, &choice.to_lowercase()), choice));
    scored.filter(|(score, _)| *score >= ALIKE).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, choice)| choice)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_recognised_and_strangers_are_not() {
        let choices = ["max_velocity", "max_acceleration", "max_current"];
        assert_eq!(nearest("max_velocty", choices), Some("max_velocity"));
        assert_eq!(nearest("Max_Curent", choices), Some("max_current"));
        assert_eq!(nearest("colour", choices), None);
        assert_eq!(nearest("", choices), None);
    }
}
