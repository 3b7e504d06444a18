//! Near misses.

use strsim::{damerau_levenshtein, jaro_winkler};

/// Finds the name that was meant. How much it compares is bounded, so that a text full of mistakes takes no longer than
/// it has to.
pub(super) struct NearMisses {
    comparisons_left: u32,
}

impl Default for NearMisses {
    fn default() -> Self {
        Self { comparisons_left: 50_000 }
    }
}

impl NearMisses {
    /// Nobody means a name of this many letters by another.
    const LONGEST: usize = 64;

    /// The choice that `word` is a slip of: about one letter in three may differ. Names are the same in any case.
    pub(super) fn nearest<'c>(
        &mut self,
        word: &str,
        choices: impl IntoIterator<Item = &'c str>,
    ) -> Option<&'c str> {
        if word.len() > Self::LONGEST {
            return None;
        }
        let word = word.to_ascii_lowercase();
        let mut best: Option<(usize, f64, &str)> = None;
        for choice in choices {
            self.comparisons_left = self.comparisons_left.checked_sub(1)?;
            let allowed = (word.len().max(choice.len()) + 1) / 3;
            if choice.len() > Self::LONGEST || word.len().abs_diff(choice.len()) > allowed {
                continue;
            }
            let folded = choice.to_ascii_lowercase();
            let distance = damerau_levenshtein(&word, &folded);
            if distance > allowed || distance >= word.len().min(choice.len()) {
                continue;
            }
            let likeness = jaro_winkler(&word, &folded);
            if best.is_none_or(|(least, most, _)| distance < least || distance == least && likeness > most) {
                best = Some((distance, likeness, choice));
            }
        }
        best.map(|(_, _, choice)| choice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nearest(word: &str, choices: &[&'static str]) -> Option<&'static str> {
        NearMisses::default().nearest(word, choices.iter().copied())
    }

    #[test]
    fn slips_are_recognised_and_strangers_are_not() {
        let mnemonics = ["SAP", "GAP", "STAP", "MVP", "WAIT", "STOP"];
        assert_eq!(nearest("spa", &mnemonics), Some("SAP"));
        assert_eq!(nearest("wiat", &mnemonics), Some("WAIT"));
        assert_eq!(nearest("MVPP", &mnemonics), Some("MVP"));
        assert_eq!(nearest("HALT", &mnemonics), None);
        assert_eq!(nearest("", &mnemonics), None);
        assert_eq!(nearest("X", &["Y"]), None);
        assert_eq!(nearest("MaxSped", &["MinSpeed", "MaxSpeed"]), Some("MaxSpeed"));
    }

    #[test]
    fn the_work_is_bounded() {
        let mut near = NearMisses::default();
        let many = vec!["loop"; 60_000];
        assert_eq!(near.nearest("lop", many.iter().copied()), None);
        assert_eq!(near.nearest("lop", ["loop"]), None);
        assert_eq!(nearest(&"a".repeat(1_000_000), &["a"]), None);
    }
}
