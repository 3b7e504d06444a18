//! What only people read: there with the feature `texts`, empty without.

/// A name, summary, unit, note or section.
pub(crate) const fn text(text: &'static str) -> &'static str {
    if cfg!(feature = "texts") { text } else { "" }
}

/// Values or bits with names.
pub(crate) const fn list<T>(list: &'static [T]) -> &'static [T] {
    if cfg!(feature = "texts") { list } else { &[] }
}
