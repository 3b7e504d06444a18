//! `--state DIR`: modules that keep their EEPROMs in a folder, and what a user hears of it.

use std::path::Path;

use tmcl_server::state::{SetAside, State, StateError, Wear};
use virtual_bench::eeprom::ENDURANCE;
use virtual_bench::{Bench, BenchConfig};

use crate::exit::{Code, Failure};
use crate::print;

/// The bench of `config`, with what the modules keep in `folder`, where one is named.
pub(crate) fn bench(config: &BenchConfig, folder: Option<&Path>) -> Result<(Bench, Option<State>), Failure> {
    let Some(folder) = folder else { return Ok((Bench::new(config), None)) };
    let (mut state, eeproms, set_aside) = State::open(folder, config).map_err(failure)?;
    set_aside.iter().for_each(report);
    let mut eeproms = eeproms.into_iter();
    let mut bench = Bench::with_eeproms(config, |_| eeproms.next());
    state.save(&mut bench).map_err(failure)?;
    Ok((bench, Some(state)))
}

/// How a command ends when modules cannot keep their EEPROMs.
#[expect(clippy::needless_pass_by_value, reason = "it is what map_err passes")]
pub(crate) fn failure(error: StateError) -> Failure {
    let code = match error {
        StateError::InUse(_) => Code::Connection,
        StateError::Folder(..)
        | StateError::File(..)
        | StateError::Foreign(..)
        | StateError::OtherModule { .. } => Code::Usage,
    };
    Failure::new(code, error.to_string())
}

fn report(SetAside { name, from, to, error }: &SetAside) {
    print::note(&format!(
        "{} is damaged: {error}; it is {} now, and {name} starts with factory settings",
        from.display(),
        to.display()
    ));
}

/// What the modules' EEPROMs went through, said at the end.
pub(crate) fn report_wear(wear: &[Wear], folder: &Path) {
    for Wear { name, writes_now, writes, most_worn } in wear {
        print::note(&format!(
            "{name} is kept in {}: {writes_now} bytes written, {writes} since its EEPROM was new; its most worn page was \
             written {most_worn} times of {ENDURANCE}",
            folder.display()
        ));
    }
}
