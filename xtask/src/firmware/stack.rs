//! How deep the stack of an image can get: the frames along the deepest chain of calls.

use std::collections::BTreeMap;

use anyhow::{Result, bail};

use super::code::{Code, Function};

/// The deepest chain of calls.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Depth {
    pub(super) bytes: u64,
    /// Names of functions, the outermost first, each with its frame.
    pub(super) chain: Vec<(String, u64)>,
}

/// Looks through everything that can be called from the image's first instruction on. No interrupt is enabled in them.
pub(super) fn depth(code: &Code) -> Result<Depth> {
    let mut search = Search { code, known: BTreeMap::new(), open: Vec::new() };
    search.below(code.named("Reset")?)
}

struct Search<'a> {
    code: &'a Code,
    known: BTreeMap<u32, Depth>,
    /// The chain that is looked at.
    open: Vec<u32>,
}

impl Search<'_> {
    fn below(&mut self, address: u32) -> Result<Depth> {
        let (start, function) = self.code.around(address)?;
        if let Some(depth) = self.known.get(&start) {
            return Ok(depth.clone());
        }
        if let Some(first) = self.open.iter().position(|open| *open == start) {
            let circle =
                self.open[first..].iter().filter_map(|open| Some(&self.code.around(*open).ok()?.1.name));
            let circle: Vec<_> = circle.map(String::as_str).collect();
            bail!("the stack has no bound, this calls itself:\n  {}", circle.join("\n  "));
        }
        self.open.push(start);
        let mut deepest = Depth::default();
        for callee in callees(self.code, function)? {
            let depth = self.below(callee)?;
            if depth.bytes > deepest.bytes {
                deepest = depth;
            }
        }
        self.open.pop();
        deepest.bytes += function.frame;
        deepest.chain.insert(0, (function.name.clone(), function.frame));
        self.known.insert(start, deepest.clone());
        Ok(deepest)
    }
}

fn callees(code: &Code, function: &Function) -> Result<Vec<u32>> {
    let mut callees: Vec<_> = function.calls.iter().map(|(_, target)| *target).collect();
    if function.looks_up {
        let Some(looked_up) = looked_up(&function.name) else {
            bail!(
                "{} calls an address that it has looked up: what that can be is not known here",
                function.name
            )
        };
        let named = code
            .functions()
            .filter(|(_, function)| looked_up.iter().any(|part| function.name.contains(part)));
        let before = callees.len();
        callees.extend(named.map(|(address, _)| address));
        if callees.len() == before {
            bail!(
                "{} calls an address that it has looked up, and nothing it could be is in the image",
                function.name
            )
        }
    }
    Ok(callees)
}

/// What the functions that a function finds in a table are called, in part. Tables belong to traits.
fn looked_up(function: &str) -> Option<&'static [&'static str]> {
    const WRITE: &[&str] = &[" as core::fmt::Write>::write_str", " as core::fmt::Write>::write_char"];
    const DISPLAY_OR_WRITE: &[&str] = &[" as core::fmt::Display>::fmt", " as core::fmt::Write>::write_str"];
    if function == "core::fmt::write" {
        Some(DISPLAY_OR_WRITE)
    } else if function.contains("core::fmt::Formatter>") || function.ends_with(" as core::fmt::Display>::fmt")
    {
        Some(WRITE)
    } else if function.contains("dyn sequential_storage::map::Value") {
        Some(&[" as sequential_storage::map::Value>::"])
    } else {
        None
    }
}
