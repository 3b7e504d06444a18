//! Which bench a command runs on: a file's, or the default one of a module.

use std::path::Path;

use virtual_bench::{BenchConfig, config};

use crate::exit::{Code, Failure};
use crate::module_name::VirtualModule;

/// The bench of `file`, or the default one of `module`. The address on the command line beats the file's.
pub(crate) fn load(module: Option<VirtualModule>, file: Option<&Path>) -> Result<BenchConfig, Failure> {
    let mut config = match (file, module) {
        (Some(file), module) => agreeing(read(file)?, file, module)?,
        (None, Some(module)) => BenchConfig::default_for(module.kind),
        (None, None) => {
            return Err(Failure::new(Code::Usage, "name a module, such as tmcm-1311, or a --bench file"));
        }
    };
    let address = module.and_then(|module| module.address);
    if let (Some(first), Some(address)) = (config.modules.first_mut(), address) {
        first.address = Some(address);
    }
    Ok(config)
}

fn read(file: &Path) -> Result<BenchConfig, Failure> {
    let name = file.display().to_string();
    let text = std::fs::read_to_string(file)
        .map_err(|error| Failure::new(Code::Usage, format!("cannot read the bench file {name}: {error}")))?;
    config::parse(&text).map_err(|errors| {
        let reports: Vec<_> = errors.iter().map(|error| error.report(&name, &text)).collect();
        let count = match reports.len() {
            1 => "an error".to_owned(),
            count => format!("{count} errors"),
        };
        Failure::new(Code::Usage, format!("{count} in the bench file\n\n{}", reports.join("\n")))
    })
}

/// A module that is named beside a file has to be the file's first.
fn agreeing(config: BenchConfig, file: &Path, module: Option<VirtualModule>) -> Result<BenchConfig, Failure> {
    let (Some(first), Some(module)) = (config.modules.first(), module) else { return Ok(config) };
    if first.kind == module.kind {
        return Ok(config);
    }
    let (named, found) = (module.kind.spec().id, first.kind.spec().id);
    let message = format!("the first module in {} is a {found}, not a {named}", file.display());
    Err(Failure::new(Code::Usage, message))
}
