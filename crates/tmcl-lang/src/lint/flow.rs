//! The control-flow graph: what each instruction does to the flow, and where flow begins.

use tmcl_tables::{Command, ModuleSpec};

use crate::instruction::Instruction;
use crate::program::Program;

/// What an instruction does to the flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Goes on with the next instruction.
    Next,
    /// Goes on at an address (JA).
    Jump(usize),
    /// Goes on at an address or with the next instruction (JC).
    Branch(usize),
    /// Goes on at an address, and with the next instruction after the RSUB (CSUB).
    Call(usize),
    /// RSUB.
    SubroutineReturn,
    /// RETI.
    InterruptReturn,
    /// STOP.
    Stop,
    /// Leaves the program for erased memory, which reads as STOP; another lint speaks of it.
    Leave,
}

/// An interrupt routine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Routine {
    /// Its first instruction.
    pub(super) start: usize,
    /// The first VECT that names it.
    pub(super) vector: usize,
}

/// The graph of a program.
pub(super) struct Graph<'p> {
    /// The instructions.
    pub(super) instructions: &'p [Instruction],
    /// The module.
    pub(super) module: &'static ModuleSpec,
    /// The command of each, where the module executes it in programs.
    commands: Vec<Option<Command>>,
    /// What each does.
    pub(super) steps: Vec<Step>,
    /// Where a host begins: address 0, and each JA of a jump table at the top (TMCM-1311 §11.6).
    pub(super) entries: Vec<usize>,
    /// Where the module begins when an interrupt comes.
    pub(super) routines: Vec<Routine>,
    /// The STOP that the assembler appended.
    pub(super) appended_stop: Option<usize>,
}

impl<'p> Graph<'p> {
    /// The graph of `program`.
    pub(super) fn new(program: &'p Program) -> Self {
        let instructions = program.instructions.as_slice();
        let module = program.module;
        let steps: Vec<_> = instructions.iter().map(|it| step(*it, instructions.len(), module)).collect();
        Self {
            entries: entries(instructions, module),
            routines: routines(instructions, module),
            appended_stop: program.appended_stop.then(|| instructions.len().checked_sub(1)).flatten(),
            commands: instructions.iter().map(|it| command(*it, module)).collect(),
            instructions,
            module,
            steps,
        }
    }

    /// How many instructions there are.
    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    /// What the instruction at an address does; past the end, memory is erased.
    pub(super) fn step(&self, address: usize) -> Step {
        self.steps.get(address).copied().unwrap_or(Step::Leave)
    }

    /// Every instruction with its address and command, those left out that the module would skip.
    pub(super) fn commands(&self) -> impl Iterator<Item = (usize, Command, Instruction)> + '_ {
        let with_commands = self.instructions.iter().zip(&self.commands).enumerate();
        with_commands.filter_map(|(address, (it, command))| Some((address, (*command)?, *it)))
    }

    /// Whether an instruction belongs to the jump table at the top, whose labels are for a host.
    pub(super) fn is_in_jump_table(&self, address: usize) -> bool {
        self.entries.contains(&address) && matches!(self.step(address), Step::Jump(_))
    }
}

/// The command of an instruction, if the module executes it in programs; others are skipped (decision).
pub(super) fn command(instruction: Instruction, module: &ModuleSpec) -> Option<Command> {
    module.command(instruction.command).filter(|entry| entry.modes.program).map(|entry| entry.spec.command)
}

/// Where an address field leads.
pub(super) enum Target {
    /// An instruction of the program.
    Inside(usize),
    /// Program memory behind the program.
    Behind,
    /// No program memory; the instruction fails and is skipped (decision).
    Outside,
}

/// Where `value` leads.
pub(super) fn target(value: i32, len: usize, module: &ModuleSpec) -> Target {
    match usize::try_from(value) {
        Ok(address) if address < len => Target::Inside(address),
        Ok(address) if address < usize::from(module.program_memory) => Target::Behind,
        _ => Target::Outside,
    }
}

fn step(instruction: Instruction, len: usize, module: &ModuleSpec) -> Step {
    let leads = |inside: fn(usize) -> Step, behind: Step| match target(instruction.value, len, module) {
        Target::Inside(address) => inside(address),
        Target::Behind => behind,
        Target::Outside => Step::Next,
    };
    match command(instruction, module) {
        Some(Command::Jump) => leads(Step::Jump, Step::Leave),
        Some(Command::JumpConditional) if has_type(instruction, module) => leads(Step::Branch, Step::Next),
        Some(Command::CallSubroutine) => leads(Step::Call, Step::Leave),
        Some(Command::ReturnFromSubroutine) => Step::SubroutineReturn,
        Some(Command::ReturnFromInterrupt) => Step::InterruptReturn,
        Some(Command::Stop) => Step::Stop,
        _ => Step::Next,
    }
}

/// Whether the type byte is one that the module's command has a name for.
fn has_type(instruction: Instruction, module: &ModuleSpec) -> bool {
    module.command(instruction.command).is_some_and(|entry| entry.types.contains(&instruction.kind))
}

fn entries(instructions: &[Instruction], module: &ModuleSpec) -> Vec<usize> {
    let is_jump = |it: &&Instruction| command(**it, module) == Some(Command::Jump);
    let table = instructions.iter().take_while(is_jump).count();
    (0..table.max(1).min(instructions.len())).collect()
}

fn routines(instructions: &[Instruction], module: &ModuleSpec) -> Vec<Routine> {
    let mut routines: Vec<Routine> = Vec::new();
    let mut seen = vec![false; instructions.len()];
    for (vector, it) in instructions.iter().enumerate() {
        if command(*it, module) != Some(Command::SetInterruptVector) {
            continue;
        }
        if let Target::Inside(start) = target(it.value, instructions.len(), module)
            && let Some(seen) = seen.get_mut(start)
            && !core::mem::replace(seen, true)
        {
            routines.push(Routine { start, vector });
        }
    }
    routines
}
