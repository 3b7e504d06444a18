//! `tmcl asm` beside GNU `as` on programs of the same number of lines, both as processes, from file to file.
//!
//! The first program has 2000 instructions, which fills a module's memory; the second as many after 98 000 lines of
//! constants (`.set` for `as`). Needs binutils; without `as` only `tmcl asm` is measured.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]
#![allow(clippy::disallowed_methods, reason = "a benchmark of processes writes files")]

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};

const INSTRUCTIONS: usize = 2000;

fn tmcl_text(lines: usize) -> String {
    let mut text = String::from("//! module: tmcm-1311\n");
    let constants = (lines - INSTRUCTIONS).saturating_sub(2);
    if constants > 0 {
        text.push_str("Name0 = 1000  // what all the others are\n");
    }
    for line in 1..constants {
        let _ = writeln!(text, "Name{line} = Name{}  // a constant", line - 1);
    }
    text.push_str(if constants > 0 { "Last = Name0\n" } else { "Last = 1000\n" });
    for index in 0..INSTRUCTIONS {
        let _ = match index % 4 {
            0 => writeln!(text, "Label{index}: SAP 4, 0, Last"),
            1 => writeln!(text, "    MVP ABS, 0, {}  // a comment", index * 10),
            2 => writeln!(text, "    COMP {index}"),
            _ => writeln!(text, "    JC GT, Label{}", index - 3),
        };
    }
    text
}

fn as_text(lines: usize) -> String {
    let mut text = String::from("# x86-64\n");
    let constants = (lines - INSTRUCTIONS).saturating_sub(2);
    if constants > 0 {
        text.push_str(".set Name0, 1000  # what all the others are\n");
    }
    for line in 1..constants {
        let _ = writeln!(text, ".set Name{line}, Name{}  # a constant", line - 1);
    }
    text.push_str(if constants > 0 { ".set Last, Name0\n" } else { ".set Last, 1000\n" });
    for index in 0..INSTRUCTIONS {
        let _ = match index % 4 {
            0 => writeln!(text, "Label{index}: movl $Last, %eax"),
            1 => writeln!(text, "    addl ${}, %ebx  # a comment", index * 10),
            2 => writeln!(text, "    cmpl ${index}, %eax"),
            _ => writeln!(text, "    jg Label{}", index - 3),
        };
    }
    text
}

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assembler");
    std::fs::create_dir_all(&folder).expect("a folder under target/");
    folder
}

fn measure(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, program: &str, arguments: &[&str]) {
    let run = || Command::new(program).args(arguments).stderr(Stdio::null()).status();
    if !run().is_ok_and(|status| status.success()) {
        eprintln!("{program} does not run; not measured");
        return;
    }
    group.bench_function(name, |bencher| bencher.iter(|| run().expect("it ran before")));
}

fn assemblers(criterion: &mut Criterion) {
    for lines in [INSTRUCTIONS + 2, 100_000] {
        let folder = folder();
        let path = |name: String| folder.join(name).display().to_string();
        let (tmcl, gas) = (path(format!("{lines}.tmc")), path(format!("{lines}.s")));
        std::fs::write(&tmcl, tmcl_text(lines)).expect("target/ can be written to");
        std::fs::write(&gas, as_text(lines)).expect("target/ can be written to");
        let mut group = criterion.benchmark_group(format!("{lines} lines"));
        group.throughput(Throughput::Elements(lines as u64));
        let (bin, object) = (path("out.bin".to_owned()), path("out.o".to_owned()));
        measure(&mut group, "tmcl asm", env!("CARGO_BIN_EXE_tmcl"), &["asm", &tmcl, "-o", &bin]);
        measure(&mut group, "GNU as", "as", &[&gas, "-o", &object]);
        group.finish();
    }
}

criterion_group!(benches, assemblers);
criterion_main!(benches);
