//! An image's machine code, as `objdump` lists it: its functions, what each takes of the stack, and whom it calls.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result, bail};

use super::output;

/// A function of the image.
#[derive(Debug, Default)]
pub(super) struct Function {
    pub(super) name: String,
    /// Bytes of stack that it takes for itself, at most.
    pub(super) frame: u64,
    /// Calls, and jumps that end it: where they are, and the address that they go to.
    pub(super) calls: BTreeSet<(u32, u32)>,
    /// Whether it calls an address that it has looked up.
    pub(super) looks_up: bool,
}

/// Functions by their addresses.
#[derive(Debug)]
pub(super) struct Code(BTreeMap<u32, Function>);

impl Code {
    /// Reads an image.
    pub(super) fn of(image: &Path) -> Result<Self> {
        let arguments = ["--disassemble", "--demangle", "--no-show-raw-insn"];
        Self::parse(&output("arm-none-eabi-objdump", &arguments, image)?)
    }

    fn parse(listing: &str) -> Result<Self> {
        let mut functions = BTreeMap::new();
        let mut current = None;
        for line in listing.lines() {
            if let Some((address, name)) = line.strip_suffix(">:").and_then(|line| line.split_once(" <")) {
                let address = hex(address)?;
                functions.insert(address, Function { name: name.to_owned(), ..Function::default() });
                current = Some(address);
            } else if let Some((address, instruction)) = line.split_once(":\t")
                && let Some(function) = current.and_then(|start| functions.get_mut(&start))
            {
                let address = hex(address)?;
                function.note(address, instruction).with_context(|| format!("{}: {line}", function.name))?;
            }
        }
        Ok(Self(functions))
    }

    pub(super) fn functions(&self) -> impl Iterator<Item = (u32, &Function)> {
        self.0.iter().map(|(address, function)| (*address, function))
    }

    /// The address of the function that has this name.
    pub(super) fn named(&self, name: &str) -> Result<u32> {
        let found = self.functions().find(|(_, function)| function.name == name);
        found.map(|(address, _)| address).with_context(|| format!("the image has no function {name}"))
    }

    /// The function that an address lies in, with its own address.
    pub(super) fn around(&self, address: u32) -> Result<(u32, &Function)> {
        let found = self.0.range(..=address).next_back();
        found.map(|(start, function)| (*start, function)).with_context(|| format!("no code at {address:#x}"))
    }
}

impl Function {
    fn note(&mut self, address: u32, instruction: &str) -> Result<()> {
        let (operation, operands) = instruction.split_once('\t').unwrap_or((instruction, ""));
        let operands = operands.split_once('@').map_or(operands, |(operands, _)| operands).trim();
        self.frame += taken(operation, operands)?;
        match operation {
            "blx" => self.looks_up = true,
            "bx" => self.looks_up |= operands != "lr",
            _ if operation.starts_with('b') || operation.starts_with("cb") => {
                // Jumps within the function have an offset behind its name.
                if let Some((target, name)) = operands.split_once(" <")
                    && let Ok(target) = hex(target.rsplit(", ").next().unwrap_or_default())
                    && (operation.starts_with("bl") && operation.len() == 2 || !self.is_within(name))
                {
                    self.calls.insert((address, target));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn is_within(&self, place: &str) -> bool {
        place.strip_prefix(&self.name).is_some_and(|rest| rest.starts_with("+0x") || rest == ">")
    }
}

/// Bytes by which an instruction makes the stack deeper.
fn taken(operation: &str, operands: &str) -> Result<u64> {
    let number = |after: &str| {
        let digits = operands.split_once(after).map(|(_, rest)| rest);
        digits.and_then(|rest| rest.trim_end_matches(['!', ']']).parse().ok())
    };
    let amount =
        if operation.starts_with("push") || (operation.starts_with("stmdb") && operands.starts_with("sp!")) {
            Some(4 * operands.split(", ").filter(|operand| *operand != "sp!").count() as u64)
        } else if operation.starts_with("sub") && operands.starts_with("sp,") {
            number("#")
        } else if operation.starts_with("str") && operands.contains("[sp, #-") && operands.ends_with('!') {
            number("#-")
        } else {
            Some(0)
        };
    match amount {
        Some(amount) => Ok(amount),
        None => bail!("an instruction takes an amount of stack that is not constant"),
    }
}

fn hex(text: &str) -> Result<u32> {
    u32::from_str_radix(text.trim(), 16).with_context(|| format!("\"{text}\" is no address"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LISTING: &str = "\
00000400 <Reset>:
     400:\tpush\t{r7, lr}
     402:\tsub\tsp, #132\t@ 0x84
     404:\tcbz\tr0, 408 <Reset+0x8>
     406:\tbl\t410 <<a::B<c, d>>::e>
     408:\tblx\tr4

00000410 <<a::B<c, d>>::e>:
     410:\tstmdb\tsp!, {r4, r5, r6, r7, r8, lr}
     414:\tsubw\tsp, sp, #2388\t@ 0x954
     418:\tstr.w\tfp, [sp, #-4]!
     41a:\tpop\t{pc}
     41c:\tb.w\t400 <Reset>
";

    #[test]
    fn functions_have_frames_and_calls() {
        let code = Code::parse(LISTING).unwrap();
        let reset = code.named("Reset").unwrap();
        let (address, first) = code.around(reset + 7).unwrap();
        assert_eq!((address, first.frame, first.looks_up), (0x400, 8 + 132, true));
        assert_eq!(first.calls, BTreeSet::from([(0x406, 0x410)]));
        let (_, second) = code.around(0x410).unwrap();
        assert_eq!((second.name.as_str(), second.frame), ("<a::B<c, d>>::e", 24 + 2388 + 4));
        assert_eq!(second.calls, BTreeSet::from([(0x41C, 0x400)]));
    }

    #[test]
    fn a_frame_that_is_not_constant_is_an_error() {
        let error = Code::parse("00000000 <f>:\n       0:\tsub.w\tsp, sp, r4\n").unwrap_err();
        assert!(format!("{error:#}").contains("not constant"), "{error:#}");
    }
}
