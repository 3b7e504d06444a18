//! `tmcl man`: the man pages.

use std::path::Path;

use clap::CommandFactory;

use crate::arguments::Arguments;
use crate::exit::{Code, Failure, Outcome};
use crate::print;

/// Prints the main page, or writes one per command to `folder`.
pub(crate) fn run(folder: Option<&Path>) -> Outcome {
    let Some(folder) = folder else {
        let mut page = Vec::new();
        clap_mangen::Man::new(Arguments::command()).render(&mut page)?;
        return Ok(print::text(&String::from_utf8_lossy(&page))?);
    };
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), folder))
        .map_err(|error| {
            Failure::new(Code::Usage, format!("cannot write to {}: {error}", folder.display()))
        })?;
    Ok(())
}
