//! Lint against a machine that tries everything: both sides of every JC, and every interrupt at every instruction.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::builder::program;
use crate::code::Code;
use crate::lint::flow::{Graph, Step};
use crate::lint::lint;
use crate::program::Program;

/// Programs with more states than this are left aside.
const MOST_STATES: usize = 20_000;

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct State {
    address: usize,
    stack: Vec<usize>,
    /// Where RETI goes, and how many calls were open when the interrupt came.
    interrupted: Option<(usize, usize)>,
}

/// What happens, by the code that speaks of it.
#[derive(Default)]
struct Happened {
    executed: BTreeSet<usize>,
    /// Strange things, with the instruction; only those that no other strange thing led to.
    events: BTreeSet<(Code, usize)>,
}

impl Happened {
    /// None where there is too much to try. With `goes_on`, strange things do not end the run.
    fn when_run(graph: &Graph, goes_on: bool) -> Option<Self> {
        let mut happened = Self::default();
        let start = |address: &usize| State { address: *address, stack: Vec::new(), interrupted: None };
        let mut to_do: Vec<_> = graph.entries.iter().map(start).collect();
        let mut seen: BTreeSet<_> = to_do.iter().cloned().collect();
        while let Some(state) = to_do.pop() {
            happened.executed.insert(state.address);
            for next in happened.after(graph, &state, goes_on) {
                if next.address < graph.len() && seen.insert(next.clone()) {
                    to_do.push(next);
                }
            }
            if seen.len() > MOST_STATES {
                return None;
            }
        }
        Some(happened)
    }

    fn after(&mut self, graph: &Graph, state: &State, goes_on: bool) -> Vec<State> {
        let mut after = Vec::new();
        if state.interrupted.is_none() {
            after.extend(graph.routines.iter().map(|routine| State {
                address: routine.start,
                stack: state.stack.clone(),
                interrupted: Some((state.address, state.stack.len())),
            }));
        }
        let at = |address| State { address, ..state.clone() };
        let next = at(state.address + 1);
        let mut strange = |code, next: State| {
            self.events.insert((code, state.address));
            goes_on.then_some(next)
        };
        match graph.step(state.address) {
            Step::Next => after.push(next),
            Step::Jump(target) => after.push(at(target)),
            Step::Branch(target) => after.extend([at(target), next]),
            Step::Call(_) if state.stack.len() == 8 => after.extend(strange(Code::NestingTooDeep, next)),
            Step::Call(target) => {
                let mut called = at(target);
                called.stack.push(state.address + 1);
                after.push(called);
            }
            Step::SubroutineReturn => {
                let mut stack = state.stack.clone();
                let depth = state.interrupted.map_or(0, |(_, depth)| depth);
                let is_own = stack.len() > depth;
                let back = match stack.pop() {
                    Some(address) => State { address, stack, interrupted: state.interrupted },
                    None => next,
                };
                match state.interrupted {
                    _ if is_own => after.push(back),
                    Some(_) => after.extend(strange(Code::SubroutineReturnInInterrupt, back)),
                    None => after.extend(strange(Code::StraySubroutineReturn, back)),
                }
            }
            Step::InterruptReturn => match state.interrupted {
                Some((address, depth)) => {
                    let back = State { interrupted: None, ..at(address) };
                    if state.stack.len() > depth {
                        after.extend(strange(Code::SubroutineReturnInInterrupt, back));
                    } else {
                        after.push(back);
                    }
                }
                None => after.extend(strange(Code::StrayInterruptReturn, next)),
            },
            Step::Stop if state.interrupted.is_some() => {
                strange(Code::SubroutineReturnInInterrupt, next);
            }
            Step::Stop | Step::Leave => {}
        }
        after
    }
}

/// The addresses that findings of a code are at.
fn addresses(program: &Program, found: &[crate::Diagnostic], code: Code) -> BTreeSet<usize> {
    let of_code = found.iter().filter(|it| it.code == code).map(|it| it.primary.span);
    let address = |span| program.origins.iter().position(|origin| *origin == span);
    of_code.filter_map(address).collect()
}

/// What findings of W0001 cover.
fn unreached(program: &Program, found: &[crate::Diagnostic]) -> BTreeSet<usize> {
    let runs = found.iter().filter(|it| it.code == Code::Unreachable);
    let at = |span| program.origins.iter().position(|origin| *origin == span).unwrap();
    runs.flat_map(|run| {
        let first = at(run.primary.span);
        let last =
            run.secondary.iter().find(|label| label.text == "to here").map_or(first, |last| at(last.span));
        first..=last
    })
    .collect()
}

fn any_line(len: usize, interrupts: bool) -> impl Strategy<Value = String> {
    let plain = prop::sample::select(vec!["MST 0", "STOP", "RSUB", "RSUB", "RETI"]);
    let mnemonics = if interrupts {
        vec!["JA", "JC ZE,", "CSUB", "CSUB", "VECT 0,"]
    } else {
        vec!["JA", "JC ZE,", "CSUB", "CSUB"]
    };
    let jump =
        (prop::sample::select(mnemonics), 0..len).prop_map(|(mnemonic, to)| format!("{mnemonic} {to}"));
    prop_oneof![2 => plain.prop_map(str::to_owned), 3 => jump]
}

fn any_text(interrupts: bool) -> impl Strategy<Value = String> {
    (2..14_usize).prop_flat_map(move |len| {
        prop::collection::vec(any_line(len, interrupts), len).prop_map(|lines| lines.join("\n"))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn whatever_happens_was_warned_of(text in any_text(true)) {
        let (program, sources) = program(&text);
        let found = lint(&program, &sources);
        let graph = Graph::new(&program);
        let Some(happened) = Happened::when_run(&graph, false) else { return Ok(()) };
        let is_found = |code| found.iter().any(|it| it.code == code);
        for (code, address) in &happened.events {
            let other = if *code == Code::NestingTooDeep { Code::Recursion } else { *code };
            prop_assert!(is_found(*code) || is_found(other), "{code} at {address}\n{text}\n{found:#?}");
        }
    }

    #[test]
    fn what_is_executed_is_not_called_unreachable(text in any_text(true)) {
        let (program, sources) = program(&text);
        let graph = Graph::new(&program);
        let Some(happened) = Happened::when_run(&graph, true) else { return Ok(()) };
        let unreached = unreached(&program, &lint(&program, &sources));
        let both: Vec<_> = happened.executed.intersection(&unreached).collect();
        prop_assert!(both.is_empty(), "{both:?}\n{text}");
    }

    #[test]
    fn without_interrupts_and_recursion_nothing_is_said_that_does_not_happen(text in any_text(false)) {
        let (program, sources) = program(&text);
        let found = lint(&program, &sources);
        if found.iter().any(|it| it.code == Code::Recursion) {
            return Ok(());
        }
        let graph = Graph::new(&program);
        let Some(happened) = Happened::when_run(&graph, false) else { return Ok(()) };
        for code in [Code::StraySubroutineReturn, Code::StrayInterruptReturn] {
            let said = addresses(&program, &found, code);
            let happens = happened.events.iter().filter(|(event, _)| *event == code);
            prop_assert_eq!(said, happens.map(|(_, address)| *address).collect(), "{}\n{}", code, text);
        }
        if !happened.events.is_empty() {
            return Ok(());
        }
        let mut left: BTreeSet<_> = (0..graph.len()).filter(|address| !happened.executed.contains(address)).collect();
        if left.contains(&(graph.len() - 1)) && program.appended_stop {
            left.remove(&(graph.len() - 1));
        }
        prop_assert_eq!(unreached(&program, &found), left, "{}", text);
    }
}
