//! A curve in a line of text.

const HEIGHTS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// A character for each value, the lowest at the bottom and the highest at the top.
pub(crate) fn spark(values: impl Iterator<Item = i64> + Clone) -> String {
    let (low, high) = (values.clone().min().unwrap_or(0), values.clone().max().unwrap_or(0));
    let height = |value: i64| {
        // Values have 32 bits, so that nothing overflows.
        let place = (value - low) * (HEIGHTS.len() as i64 - 1) / (high - low).max(1);
        HEIGHTS.get(usize::try_from(place).unwrap_or(0)).copied().unwrap_or('█')
    };
    values.map(height).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_the_lowest_to_the_highest() {
        assert_eq!(spark([0, 1, 2, 3, 4, 5, 6, 7].into_iter()), "▁▂▃▄▅▆▇█");
        assert_eq!(spark([5, 5].into_iter()), "▁▁");
        assert_eq!(spark([i64::from(i32::MIN), i64::from(u32::MAX)].into_iter()), "▁█");
        assert_eq!(spark([].into_iter()), "");
    }
}
