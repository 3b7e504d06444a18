//! `cargo xtask figures`: the figures of the documentation, each a run of `tmcl` on a bench, by the list in
//! `examples/figures/figures.toml`.
//!
//! A run is a pure function of its inputs, so a figure that stands can be compared with a fresh one, byte for byte.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::codegen::Mode;
use crate::{program, workspace_root};

/// Where the list is, and what its paths start from.
const FOLDER: &str = "examples/figures";
/// Where the figures are drawn to.
const DRAWN: &str = "docs/img/figures";
/// Where the pages are that show them.
const PAGES: &str = "docs";
/// What a figure may weigh, so that a page of them loads at once.
const MOST_BYTES: usize = 60_000;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    figure: Vec<Figure>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Figure {
    /// Of the file, without its ending.
    name: String,
    title: String,
    /// Without one the bench runs by itself.
    program: Option<PathBuf>,
    bench: PathBuf,
    /// The options of `tmcl run` of the same names.
    #[serde(rename = "for")]
    duration: String,
    every: String,
    plot_from: Option<String>,
    #[serde(rename = "panels")]
    panel: Vec<String>,
    #[serde(default)]
    exec: Vec<String>,
    #[serde(default)]
    expect: Vec<String>,
}

/// Draws them all, or compares them with those that stand.
pub(crate) fn run(mode: Mode) -> Result<()> {
    let root = workspace_root();
    let list = list(&root.join(FOLDER).join("figures.toml"))?;
    let tmcl = program::built()?;
    let fresh = root.join("target/figures");
    std::fs::create_dir_all(&fresh)?;
    let drawn = root.join(DRAWN);
    std::fs::create_dir_all(&drawn)?;
    let mut stale = Vec::new();
    for figure in &list {
        let file = format!("{}.svg", figure.name);
        draw(&tmcl, figure, &fresh.join(&file)).with_context(|| format!("drawing {file}"))?;
        if settle(&fresh.join(&file), &drawn.join(&file), mode)? {
            eprintln!("{DRAWN}/{file}");
            stale.push(file);
        }
    }
    let strangers = strangers(&drawn, &list)?;
    if mode == Mode::Check && !(stale.is_empty() && strangers.is_empty()) {
        let files: String =
            stale.iter().chain(&strangers).map(|file| format!("\n  {DRAWN}/{file}")).collect();
        bail!("these figures are not what {FOLDER}/figures.toml says; run `cargo xtask figures`:{files}");
    }
    for file in strangers {
        std::fs::remove_file(drawn.join(file))?;
    }
    shown(&root.join(PAGES), &list)
}

fn list(path: &Path) -> Result<Vec<Figure>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    let list = parsed(&text).with_context(|| format!("in {}", path.display()))?;
    Ok(list)
}

fn parsed(text: &str) -> Result<Vec<Figure>> {
    let list: List = toml::from_str(text)?;
    let mut names = BTreeSet::new();
    for Figure { name, .. } in &list.figure {
        let is_plain = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-';
        if name.is_empty() || !name.chars().all(is_plain) {
            bail!("{name:?} is no name for a figure: lower-case letters, digits and -");
        }
        if !names.insert(name) {
            bail!("there are two figures called {name}");
        }
    }
    Ok(list.figure)
}

fn draw(tmcl: &Path, figure: &Figure, to: &Path) -> Result<()> {
    let output = Command::new(tmcl)
        .args(arguments(figure))
        .arg("--plot")
        .arg(to)
        .current_dir(workspace_root().join(FOLDER))
        .stdin(Stdio::null())
        .output()
        .context("starting tmcl")?;
    if !output.status.success() {
        let said = [output.stdout, output.stderr].concat();
        bail!("tmcl run ended with {}:\n{}", output.status, String::from_utf8_lossy(&said));
    }
    let bytes = std::fs::metadata(to)?.len();
    if bytes > MOST_BYTES as u64 {
        bail!("it has {bytes} bytes, more than {MOST_BYTES}: take fewer samples (`every`)");
    }
    Ok(())
}

/// Of `tmcl`, but for where to draw to.
fn arguments(figure: &Figure) -> Vec<String> {
    let mut arguments = vec!["run".to_owned()];
    arguments.extend(figure.program.as_ref().map(|program| program.display().to_string()));
    let mut option = |name: &str, value: &str| {
        arguments.extend([format!("--{name}"), value.to_owned()]);
    };
    option("bench", &figure.bench.display().to_string());
    option("title", &figure.title);
    option("for", &figure.duration);
    option("every", &figure.every);
    if let Some(time) = &figure.plot_from {
        option("plot-from", time);
    }
    for command in &figure.exec {
        option("exec", command);
    }
    for panel in &figure.panel {
        option("panel", panel);
    }
    for expectation in &figure.expect {
        option("expect", expectation);
    }
    arguments
}

/// Whether the figure that stands differs from the fresh one, which is then written in its place unless it is only checked.
fn settle(fresh: &Path, standing: &Path, mode: Mode) -> Result<bool> {
    let bytes = std::fs::read(fresh)?;
    if std::fs::read(standing).is_ok_and(|old| old == bytes) {
        return Ok(false);
    }
    if mode == Mode::Write {
        std::fs::write(standing, bytes).with_context(|| format!("writing {}", standing.display()))?;
    }
    Ok(true)
}

/// Files beside the figures that are none of them.
fn strangers(drawn: &Path, list: &[Figure]) -> Result<Vec<String>> {
    let mut strangers = Vec::new();
    for entry in std::fs::read_dir(drawn)? {
        let file = entry?.file_name().to_string_lossy().into_owned();
        if !list.iter().any(|figure| file == format!("{}.svg", figure.name)) {
            strangers.push(file);
        }
    }
    strangers.sort();
    Ok(strangers)
}

/// A figure that no page shows is drawn for nobody.
fn shown(pages: &Path, list: &[Figure]) -> Result<()> {
    let mut text = String::new();
    for entry in std::fs::read_dir(pages)? {
        let path = entry?.path();
        if path.extension().is_some_and(|ending| ending == "md") {
            text += &std::fs::read_to_string(path)?;
        }
    }
    let unseen: Vec<&str> = unseen(&text, list).collect();
    if !unseen.is_empty() {
        bail!("no page in {PAGES}/ shows {}", unseen.join(", "));
    }
    Ok(())
}

fn unseen<'a>(text: &str, list: &'a [Figure]) -> impl Iterator<Item = &'a str> {
    let names = list.iter().map(|figure| figure.name.as_str());
    names.filter(move |name| !text.contains(&format!("(img/figures/{name}.svg)")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = r#"
        [[figure]]
        name = "a-1"
        title = "A"
        program = "a.tmc"
        bench = "a.toml"
        for = "2s"
        every = "1ms"
        plot_from = "1s"
        panels = ["x: y"]
        expect = ["y > 0 at end"]

        [[figure]]
        name = "b"
        title = "B"
        exec = ["SAP 6, 0, 1", "SAP 7, 0, 1"]
        bench = "b.toml"
        for = "2s"
        every = "1ms"
        panels = []
    "#;

    #[test]
    fn a_figure_is_a_run() {
        let list = parsed(TWO).unwrap();
        let expected = "run a.tmc --bench a.toml --title A --for 2s --every 1ms --plot-from 1s --panel x: y \
                        --expect y > 0 at end";
        assert_eq!(arguments(&list[0]).join(" "), expected);
        let expected =
            "run --bench b.toml --title B --for 2s --every 1ms --exec SAP 6, 0, 1 --exec SAP 7, 0, 1";
        assert_eq!(arguments(&list[1]).join(" "), expected);
    }

    #[test]
    fn the_list_is_checked() {
        for (from, to) in [("\"b\"", "\"a-1\""), ("a-1", "../a"), ("every", "evry"), ("name = \"b\"", "")] {
            assert!(parsed(&TWO.replace(from, to)).is_err(), "{to}");
        }
    }

    #[test]
    fn pages_show_figures() {
        let list = parsed(TWO).unwrap();
        assert_eq!(unseen("![A](img/figures/a-1.svg)", &list).collect::<Vec<_>>(), ["b"]);
    }
}
