//! `tmcl.toml`: where it lies. What it says, `tmcl_config::connection` reads.

use std::path::{Path, PathBuf};

use tmcl_config::connection;
use tmcl_config::file::Finding;
use virtual_bench::config::ConfigError;

use super::ConnectionOptions;
use super::place::{self, VIRTUAL};
use crate::exit::{Code, Failure};

/// What the file is called.
const NAME: &str = "tmcl.toml";

/// The file that is nearest: in `folder`, or in one above it.
pub(super) fn find(folder: &Path) -> Option<PathBuf> {
    folder.ancestors().map(|folder| folder.join(NAME)).find(|path| path.is_file())
}

/// What the file says. A bench file that it names is looked for beside it.
pub(super) fn read(path: &Path) -> Result<ConnectionOptions, Failure> {
    let name = path.display().to_string();
    let usage = |message: String| Failure::new(Code::Usage, message);
    let text =
        std::fs::read_to_string(path).map_err(|error| usage(format!("cannot read {name}: {error}")))?;
    let mut options =
        parse(&text).map_err(|error| usage(error.report(&name, &text).trim_end().to_owned()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    options.port = options.port.map(|port| beside(folder, port));
    Ok(options)
}

/// `virtual:bench.toml` with the folder of the file that says so.
fn beside(folder: &Path, port: String) -> String {
    match port.strip_prefix(VIRTUAL) {
        Some(bench) if place::is_bench(bench) => format!("{VIRTUAL}{}", folder.join(bench).display()),
        _ => port,
    }
}

fn parse(text: &str) -> Result<ConnectionOptions, ConfigError> {
    let in_form = |Finding { message, span, help }| ConfigError { message, span, help };
    connection::parse(text).map(ConnectionOptions::from).map_err(in_form)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_line() {
        let error = |text: &str| parse(text).expect_err("something is wrong").report("tmcl.toml", text);
        let texts = [
            "[connection]\nprot = \"COM3\"\n",
            "port = \"COM3\"\n",
            "connection = 3\n",
            "[connection]\ntimeout = 5\n",
            "[connection]\naddress = 2048\n",
            "[connection]\nretries = [1]\n",
            "[connection\n",
        ];
        insta::assert_snapshot!(texts.map(error).join("\n"));
    }

    #[test]
    fn a_bench_stands_beside_the_file() {
        let beside = |port: &str| beside(Path::new("/home/me/axis"), port.to_owned());
        assert_eq!(beside("virtual:lift.toml"), "virtual:/home/me/axis/lift.toml");
        assert_eq!(beside("virtual:lift.toml#m2"), "virtual:/home/me/axis/lift.toml#m2");
        assert_eq!(beside("virtual:/lift.toml"), "virtual:/lift.toml");
        assert_eq!(beside("virtual:tmcm-1311"), "virtual:tmcm-1311");
        assert_eq!(beside("./ttyTMCL"), "./ttyTMCL");
    }
}
