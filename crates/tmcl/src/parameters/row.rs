//! A parameter as JSON has it, wherever it comes up.

use serde::Serialize;
use tmcl_config::{Item, Name};

/// A parameter and what it holds.
#[derive(Serialize)]
pub(crate) struct Row {
    name: String,
    number: String,
    value: i64,
    unit: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    named: Option<&'static str>,
    #[serde(skip_serializing_if = "serde_json::Map::is_empty")]
    fields: serde_json::Map<String, serde_json::Value>,
}

impl Row {
    /// Of a parameter, or some bits of it.
    pub(crate) fn new(name: &Name, value: i64, closed_loop: bool) -> Self {
        let whole = name.field.is_none();
        let named = name.item.values().iter().find(|named| named.value == value).map(|named| named.id);
        let fields = if whole { name.item.fields() } else { &[] };
        Self {
            name: name.to_string(),
            number: name.item.number(),
            value,
            unit: unit(name, closed_loop),
            named: named.filter(|_| whole),
            fields: fields.iter().map(|field| (field.id.to_owned(), field.extract(value).into())).collect(),
        }
    }
}

/// Which parameter it is.
#[derive(Serialize)]
pub(crate) struct Which {
    name: String,
    number: String,
}

impl Which {
    pub(crate) fn of(item: Item) -> Self {
        Self { name: item.name(), number: item.number() }
    }
}

/// The unit of a whole parameter; some bits have none.
pub(crate) fn unit(name: &Name, closed_loop: bool) -> &'static str {
    if name.field.is_some() { "" } else { name.item.unit(closed_loop) }
}
