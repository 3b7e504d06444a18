//! The command line, from which completions and man pages are made too.

mod values;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use tmcl_tables::ModuleSpec;

use crate::commands::download::Download;
use crate::commands::exec::Exec;
use crate::commands::factory_reset::FactoryReset;
use crate::commands::info::Info;
use crate::commands::ports::Ports;
use crate::commands::scan::Scan;
use crate::commands::shell::Shell;
use crate::commands::upload::Upload;
use crate::commands::{application, apply, diff, dump, get, restore, set, store, watch};
use crate::module_name;
use crate::panel::{self, PanelText};
use crate::program::lints::LintOptions;
pub(crate) use values::{Baud, duration, interval};
use values::{baud, code, rpm, speed, tcp_address, turns};

#[derive(Parser)]
#[command(
    name = "tmcl",
    version,
    about = "The open implementation of TMCL, the Trinamic Motion Control Language"
)]
#[command(
    after_help = "Exit codes: 0 ok, 1 findings or failed expectation, 2 usage, 3 connection, 4 TMCL error status, \
    42 timeout.\n\nThe options of a connection are looked up in the environment (TMCL_PORT, TMCL_BAUD, TMCL_ADDRESS, \
    TMCL_HOST_ADDRESS, TMCL_TIMEOUT, TMCL_RETRIES) and in tmcl.toml where the command line does not give them: docs/host-tools.md."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Run a program, or a bench alone, in virtual time and check what you expect of it
    Run(Run),
    /// Check a program for errors, and for what is hardly meant
    Check(Check),
    /// Explain the code of an error or warning
    Explain(Explain),
    /// Lay program text out
    Fmt(Fmt),
    /// Assemble a program to a compiled file
    Asm(Asm),
    /// Turn a compiled file back into text
    Disasm(Disasm),
    /// Move a virtual motor and show what happens
    Demo(Demo),
    /// Run virtual modules on TCP ports, pseudo terminals and CAN
    Serve(Serve),
    /// Send commands to a module, and print what it answers
    Exec(Exec),
    /// Talk to a module, line by line
    Shell(Shell),
    /// List the ports that a module may be behind
    Ports(Ports),
    /// Look who is on a bus
    Scan(Scan),
    /// Say which module this is, and how it is
    Info(Info),
    /// Store a program in a module
    Download(Download),
    /// Read a module's program back, as text
    Upload(Upload),
    /// Start the program that a module stores
    Start(application::Start),
    /// Stop the program; the motor moves on
    Stop(application::Options),
    /// Execute the program's next instruction
    Step(application::Options),
    /// Stop the program and set it back to its beginning
    Reset(application::Options),
    /// Say what the program does
    Status(application::Options),
    /// Set a module back to what it was when it came
    FactoryReset(FactoryReset),
    /// Show what virtual modules keep in a --state folder
    State(State),
    /// List the modules
    Modules(Modules),
    /// List a module's axis and global parameters
    Params(Params),
    /// List a module's commands
    Commands(Commands),
    /// Read parameters of a module
    Get(get::Get),
    /// Write parameters of a module
    Set(set::Set),
    /// Store parameters in the module's EEPROM as they are
    Store(store::Store),
    /// Bring parameters back to what the module's EEPROM holds
    Restore(restore::Restore),
    /// Watch parameters of a module
    Watch(watch::Watch),
    /// Print the configuration of a module as a text
    Dump(dump::Dump),
    /// Compare a configuration file with a module, or with another file
    Diff(diff::Diff),
    /// Bring a configuration file into a module
    Apply(apply::Apply),
    /// Print a shell's completion script
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the man page, or write all of them to a folder
    Man {
        /// The folder to write `tmcl.1`, `tmcl-serve.1`, … to
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// `tmcl run`.
#[derive(Args)]
#[command(
    after_help = "The run ends when every expectation is decided; when the program has stopped, all stands still and nothing \
    is left that may still come true; or when the time is up. Without expectations and recordings it ends when the program stops. \
    Without a program it ends when every expectation is decided, or when the time is up. Expectations (docs/expectations.md): \"actual_position == 10000 within 2s\", \
    \"output.3 rises\", \"never status_word & 0x200\", \"physical.rotor_turns > 4.9 at end\". Exits with 1 if one failed \
    or the module refused an instruction, with 42 if one is undecided when the run ends, with 4 if the module refused an --exec."
)]
pub(crate) struct Run {
    /// The program; - is stdin; may be left out with --bench or --module: then the bench runs by itself
    pub(crate) file: Option<PathBuf>,
    /// The module; without it, what a first line `//! module: …` says, or the bench's first, or tmcm-1311
    #[arg(long, value_parser = module_name::spec)]
    pub(crate) module: Option<&'static ModuleSpec>,
    /// The bench the module stands on (docs/bench-file.md); of several modules the first runs the program
    #[arg(long, value_name = "FILE")]
    pub(crate) bench: Option<PathBuf>,
    /// Send this command to the first module before anything else, as `tmcl exec` does, such as 'SAP 140, 0, 8'; may be given
    /// several times
    #[arg(long, value_name = "COMMAND")]
    pub(crate) exec: Vec<String>,
    /// How much virtual time may pass: 500ms, 10s, 1h
    #[arg(long = "for", value_name = "TIME", default_value = "10s", value_parser = duration)]
    pub(crate) duration: u64,
    /// Expect this of the run; may be given several times
    #[arg(long, value_name = "EXPECTATION")]
    pub(crate) expect: Vec<String>,
    /// Keep what the modules store in this folder, in a file NAME.eeprom each, and begin with what is there (docs/state.md)
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) recording: Recording,
    #[command(flatten)]
    pub(crate) lints: LintOptions,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// `tmcl asm`.
#[derive(Args)]
#[command(after_help = "The compiled file has 8 bytes an instruction, as the vendor's tools write it.")]
pub(crate) struct Asm {
    /// The program; - is stdin
    pub(crate) file: PathBuf,
    /// The compiled file; without it, FILE with the ending .bin, or stdout if FILE is -; - is stdout
    #[arg(short, long, value_name = "OUT.bin")]
    pub(crate) out: Option<PathBuf>,
    /// Write a symbol file: address to line, labels, constants (JSON)
    #[arg(long, value_name = "FILE")]
    pub(crate) symbols: Option<PathBuf>,
    /// Write a listing: addresses and bytes beside the lines
    #[arg(long, value_name = "FILE")]
    pub(crate) listing: Option<PathBuf>,
    /// The module to assemble for; without it, what a first line `//! module: …` says, or tmcm-1311
    #[arg(long, value_parser = module_name::spec)]
    pub(crate) module: Option<&'static ModuleSpec>,
    #[command(flatten)]
    pub(crate) lints: LintOptions,
    /// Print errors and warnings as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// `tmcl disasm`.
#[derive(Args)]
pub(crate) struct Disasm {
    /// The compiled file; - is stdin
    pub(crate) file: PathBuf,
    /// The module it is for
    #[arg(long, default_value = "tmcm-1311", value_parser = module_name::spec)]
    pub(crate) module: &'static ModuleSpec,
}

/// `tmcl fmt`.
#[derive(Args)]
pub(crate) struct Fmt {
    /// The programs, formatted in place; - is stdin to stdout
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Change nothing; print the names of those that would change, and exit with 1 if there are any
    #[arg(long)]
    pub(crate) check: bool,
}

/// `tmcl check`.
#[derive(Args)]
#[command(
    after_help = "Exits with 1 if there is an error or a warning. `tmcl explain CODE` says what it means."
)]
pub(crate) struct Check {
    /// The programs; - is stdin
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// The module to check for; without it, what a first line `//! module: …` says, or tmcm-1311
    #[arg(long, value_parser = module_name::spec)]
    pub(crate) module: Option<&'static ModuleSpec>,
    #[command(flatten)]
    pub(crate) lints: LintOptions,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// `tmcl explain`.
#[derive(Args)]
pub(crate) struct Explain {
    /// The code, such as E0104; without it, all are listed
    #[arg(value_parser = code)]
    pub(crate) code: Option<tmcl_lang::Code>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// `tmcl demo`.
#[derive(Args)]
#[command(
    after_help = "Moves the motor there and back in virtual time. On the default bench a load pulls at the shaft in \
    between; with --bench the file's events happen instead."
)]
pub(crate) struct Demo {
    /// The module
    #[arg(value_name = "MODULE[@ADDRESS]", value_parser = module_name::setup)]
    pub(crate) module: Option<module_name::VirtualModule>,
    /// The bench the module stands on (docs/bench-file.md)
    #[arg(long, value_name = "FILE")]
    pub(crate) bench: Option<PathBuf>,
    /// How far to turn; a stepper 0.5 if nothing is said, a brushless motor 10
    #[arg(long, value_name = "TURNS", allow_negative_numbers = true, value_parser = turns)]
    pub(crate) turns: Option<f64>,
    /// How fast; a stepper 60 if nothing is said, a brushless motor 1000
    #[arg(long, value_name = "RPM", allow_negative_numbers = true, value_parser = rpm)]
    pub(crate) rpm: Option<f64>,
    #[command(flatten)]
    pub(crate) recording: Recording,
    /// Print JSON instead of the table and the plot
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is recorded of a run.
#[derive(Args)]
pub(crate) struct Recording {
    /// Write a sample every so often to a CSV file
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) trace: Option<PathBuf>,
    /// Draw position, velocity, load and currents, or the panels you name, as an SVG file
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) plot: Option<PathBuf>,
    /// Draw this instead, such as "Speed [rpm]: actual_velocity, physical.velocity_rpm as shaft"
    /// (docs/plots.md); may be given several times
    #[arg(long, value_name = "PANEL", value_parser = panel::parse)]
    pub(crate) panel: Vec<PanelText>,
    /// What stands above the plot
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Option<String>,
    /// Draw only what is from then on: 1.5s, 200ms
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub(crate) plot_from: Option<u64>,
    /// Time between samples: 500us, 1ms, 0.5s
    #[arg(long, value_name = "TIME", value_parser = interval)]
    pub(crate) every: Option<u64>,
    /// Record this too, such as supply_voltage or output.3; may be given several times
    #[arg(long, value_name = "NAME")]
    pub(crate) column: Vec<String>,
}

/// `tmcl serve`.
#[derive(Args)]
#[command(
    after_help = "Without --tcp, --pty, --slcan and --can it listens at 127.0.0.1:5311. Several modules share one bus \
    (docs/buses.md): RS485 by --tcp and --pty, CAN by --slcan and --can. A module has four ports: each pseudo terminal and \
    CAN bus holds one, each TCP client holds one while it stays. SIGINT and SIGTERM end it."
)]
pub(crate) struct Serve {
    /// The modules, each with its address where it is not to be 1; may be left out with --bench
    #[arg(value_name = "MODULE[@ADDRESS]", value_parser = module_name::setup, required_unless_present = "bench")]
    pub(crate) modules: Vec<module_name::VirtualModule>,
    /// The bench the modules stand on (docs/bench-file.md)
    #[arg(long, value_name = "FILE")]
    pub(crate) bench: Option<PathBuf>,
    /// Listen here; port 0 picks a free one, no host means 127.0.0.1; may be given several times
    #[arg(long, value_name = "HOST:PORT", value_parser = tcp_address)]
    pub(crate) tcp: Vec<String>,
    /// Open a pseudo terminal and link PATH to it; may be given several times
    #[arg(long, value_name = "PATH")]
    pub(crate) pty: Vec<PathBuf>,
    /// Open a pseudo terminal that is a serial CAN adapter (slcan), and link PATH to it; may be given several times
    #[arg(long, value_name = "PATH")]
    pub(crate) slcan: Vec<PathBuf>,
    /// Take part in a CAN bus of this system (SocketCAN), such as can0; may be given several times
    #[arg(long, value_name = "INTERFACE")]
    pub(crate) can: Vec<String>,
    /// Let bytes take their time on RS485 at so many bits a second; auto: at what the program at a --pty has set
    #[arg(long, value_name = "BITS/S", value_parser = baud)]
    pub(crate) baud: Option<Baud>,
    /// How fast virtual time runs, 1 being real time
    #[arg(long, value_name = "FACTOR", default_value = "1", allow_negative_numbers = true, value_parser = speed)]
    pub(crate) speed: f64,
    /// Keep what the modules store in this folder, in a file NAME.eeprom each, and begin with what is there (docs/state.md)
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) recording: Recording,
}

/// `tmcl state`.
#[derive(Args)]
#[command(after_help = "Exits with 1 if an image is damaged. What stands where: docs/state.md.")]
pub(crate) struct State {
    /// The folder that --state named, or one image in it
    #[arg(value_name = "DIR")]
    pub(crate) path: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// `tmcl modules`.
#[derive(Args)]
pub(crate) struct Modules {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// `tmcl params`.
#[derive(Args)]
pub(crate) struct Params {
    /// The module
    #[arg(value_parser = module_name::spec)]
    pub(crate) module: &'static ModuleSpec,
    /// Only the axis parameters
    #[arg(long, conflicts_with = "bank")]
    pub(crate) axis: bool,
    /// Only the global parameters of this bank
    #[arg(long, value_name = "N")]
    pub(crate) bank: Option<u8>,
    #[command(flatten)]
    pub(crate) format: Format,
}

/// `tmcl commands`.
#[derive(Args)]
pub(crate) struct Commands {
    /// The module
    #[arg(value_parser = module_name::spec)]
    pub(crate) module: &'static ModuleSpec,
    #[command(flatten)]
    pub(crate) format: Format,
}

/// How tables are printed; as columns when nothing is said.
#[derive(Args)]
#[group(multiple = false)]
pub(crate) struct Format {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print Markdown, with everything the tables say
    #[arg(long)]
    pub(crate) markdown: bool,
}
