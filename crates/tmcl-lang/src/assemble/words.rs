//! Lists and names in messages.

/// `a`, `a and b`, `a, b and c`.
pub(super) fn list<T: AsRef<str>>(items: &[T], conjunction: &str) -> String {
    let Some((last, others)) = items.split_last() else { return String::new() };
    let last = last.as_ref();
    if others.is_empty() {
        return last.to_owned();
    }
    let others: Vec<&str> = others.iter().map(AsRef::as_ref).collect();
    format!("{} {conjunction} {last}", others.join(", "))
}

/// Ascending numbers, runs of them shortened: `0…7, 9 and 11`.
pub(super) fn numbers(numbers: impl IntoIterator<Item = u8>) -> String {
    let mut runs: Vec<(u8, u8)> = Vec::new();
    for number in numbers {
        match runs.last_mut() {
            Some((_, last)) if last.checked_add(1) == Some(number) => *last = number,
            Some((_, last)) if *last == number => {}
            _ => runs.push((number, number)),
        }
    }
    let run = |(first, last): (u8, u8)| match last - first {
        0 => vec![first.to_string()],
        1 => vec![first.to_string(), last.to_string()],
        _ => vec![format!("{first}…{last}")],
    };
    list(&runs.into_iter().flat_map(run).collect::<Vec<_>>(), "and")
}

/// A name from the text, cut short where it would drown the message.
pub(super) fn shortened(name: &str) -> String {
    const LONGEST: usize = 60;
    match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", name.get(..end).unwrap_or_default()),
        None => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_read_like_english() {
        assert_eq!(list::<&str>(&[], "and"), "");
        assert_eq!(list(&["a"], "and"), "a");
        assert_eq!(list(&["a", "b", "c"], "or"), "a, b or c");
    }

    #[test]
    fn runs_of_numbers_are_shortened() {
        assert_eq!(numbers([0, 1, 2, 3, 9, 11, 12, 255]), "0…3, 9, 11, 12 and 255");
        assert_eq!(numbers([0, 0, 2, 2]), "0 and 2");
    }

    #[test]
    fn long_names_are_cut_between_characters() {
        assert_eq!(shortened("Größe"), "Größe");
        assert_eq!(shortened(&"ß".repeat(100)).chars().count(), 61);
    }
}
