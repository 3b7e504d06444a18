mod errors;
mod grammar;
mod properties;

use crate::{Bench, BenchConfig, ModuleKind, config};

/// The default bench.
fn one() -> Bench {
    Bench::new(&BenchConfig::default_for(ModuleKind::Tmcm1311))
}

/// Two modules, one of them with a hyphen in its name.
fn two() -> Bench {
    let text = "[[module]]\nkind = \"tmcm-1311\"\nname = \"lift-1\"\n[[module]]\nkind = \"tmcm-1311\"\nname = \"door\"\n";
    Bench::new(&config::parse(text).expect("a valid bench file"))
}
