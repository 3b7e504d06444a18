//! What can be reached from an instruction, by walking the graph backwards.

use super::flow::{Graph, Step};

/// How calls and returns count.
#[derive(Clone, Copy)]
pub(super) struct Passes<'a> {
    /// RETI is passed over: the walk is outside interrupt routines, where it is ignored.
    pub(super) interrupt_return: bool,
    /// CSUBs that may find the stack full and be passed over; an empty slice for none.
    pub(super) calls: &'a [bool],
}

impl Passes<'_> {
    /// Nothing is passed over.
    pub(super) const NOTHING: Self = Self { interrupt_return: false, calls: &[] };

    /// Whether the CSUB at `address` may be passed over.
    pub(super) fn call(&self, address: usize) -> bool {
        self.calls.get(address).copied().unwrap_or(false)
    }
}

/// For each instruction, whether its subroutine can return from there: an RSUB is reached with no call open that the
/// walk itself made.
pub(super) fn can_return(graph: &Graph, passes: Passes) -> Vec<bool> {
    Walk::new(graph, passes).run(|step| step == Step::SubroutineReturn, |target, next, _| target && next, &[])
}

/// For each instruction, whether the flow can end from there other than with an RSUB: STOP, RETI, or out of the program.
pub(super) fn can_end(graph: &Graph, returns: &[bool]) -> Vec<bool> {
    let ends = |step| matches!(step, Step::Stop | Step::InterruptReturn | Step::Leave);
    let through_call = |target, next, returns| target || (next && returns);
    Walk::new(graph, Passes::NOTHING).run(ends, through_call, returns)
}

struct Walk<'a> {
    graph: &'a Graph<'a>,
    passes: Passes<'a>,
    /// The JAs, JCs and CSUBs that name each address.
    sources: Vec<Vec<usize>>,
    known: Vec<bool>,
    to_do: Vec<usize>,
}

impl<'a> Walk<'a> {
    fn new(graph: &'a Graph, passes: Passes<'a>) -> Self {
        // One more than there are instructions: what lies behind the program.
        let mut sources = vec![Vec::new(); graph.len() + 1];
        for (address, step) in graph.steps.iter().enumerate() {
            if let Step::Jump(target) | Step::Branch(target) | Step::Call(target) = step
                && let Some(sources) = sources.get_mut(*target)
            {
                sources.push(address);
            }
        }
        Self { graph, passes, sources, known: vec![false; graph.len() + 1], to_do: Vec::new() }
    }

    /// The least set that holds the seeds and everything that leads to it; `through_call` says when a CSUB does, from
    /// whether its target and its next instruction are in the set and whether the target can return.
    fn run(
        mut self,
        is_seed: impl Fn(Step) -> bool,
        through_call: impl Fn(bool, bool, bool) -> bool,
        returns: &[bool],
    ) -> Vec<bool> {
        for address in 0..=self.graph.len() {
            if is_seed(self.graph.step(address)) {
                self.add(address);
            }
        }
        while let Some(address) = self.to_do.pop() {
            let mut before = self.sources.get(address).cloned().unwrap_or_default();
            before.extend(address.checked_sub(1));
            for candidate in before {
                if self.leads(candidate, address, &through_call, returns) {
                    self.add(candidate);
                }
            }
        }
        self.known
    }

    fn add(&mut self, address: usize) {
        if let Some(known) = self.known.get_mut(address)
            && !core::mem::replace(known, true)
        {
            self.to_do.push(address);
        }
    }

    fn is_known(&self, address: usize) -> bool {
        self.known.get(address).copied().unwrap_or(false)
    }

    /// Whether `from` leads into the set, now that `address` is in it.
    fn leads(
        &self,
        from: usize,
        address: usize,
        through_call: impl Fn(bool, bool, bool) -> bool,
        returns: &[bool],
    ) -> bool {
        let is_next = from + 1 == address;
        match self.graph.step(from) {
            Step::Next => is_next,
            Step::Jump(target) => target == address,
            Step::Branch(target) => target == address || is_next,
            Step::Call(target) => {
                let target_returns = returns.get(target).copied().unwrap_or(false);
                (is_next && self.passes.call(from))
                    || through_call(self.is_known(target), self.is_known(from + 1), target_returns)
            }
            Step::InterruptReturn => is_next && self.passes.interrupt_return,
            Step::SubroutineReturn | Step::Stop | Step::Leave => false,
        }
    }
}
