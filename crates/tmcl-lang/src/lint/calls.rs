//! How many calls can be open, and which subroutines call themselves.

use super::backward::{Passes, can_return};
use super::components::Components;
use super::flow::{Graph, Step};
use super::forward::{Context, Forward};

/// Calls that the module keeps the way back of (TMCM-1311 §11.5).
pub(super) const STACK: usize = 8;

/// The calls of a program.
pub(super) struct Calls {
    /// What each instruction leads to, calls included, returns left out.
    successors: Vec<Vec<usize>>,
    components: Components,
    /// In the program itself, how many calls can be open at each instruction.
    main: Vec<Option<Depth>>,
    /// The same in interrupt routines, counting those of the program that an interrupt may find open.
    interrupt: Vec<Option<Depth>>,
}

/// The most calls that can be open at an instruction.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Depth {
    /// How many.
    pub(super) open: usize,
    /// The last of them; none where no call of this context is open.
    pub(super) call: Option<usize>,
}

impl Calls {
    /// Looks at what `meant` reaches.
    pub(super) fn new(graph: &Graph, meant: &Forward) -> Self {
        let returns = can_return(graph, Passes::NOTHING);
        let reached = |address: &usize| meant.reaches_at_all(*address);
        let mut successors = vec![Vec::new(); graph.len()];
        for (address, successors) in successors.iter_mut().enumerate().filter(|(address, _)| reached(address))
        {
            let next = (address + 1 < graph.len()).then_some(address + 1);
            match graph.step(address) {
                Step::Next => successors.extend(next),
                Step::Jump(target) => successors.push(target),
                Step::Branch(target) => successors.extend([Some(target), next].into_iter().flatten()),
                Step::Call(target) => {
                    successors.push(target);
                    successors.extend(next.filter(|_| returns.get(target) == Some(&true)));
                }
                Step::SubroutineReturn | Step::InterruptReturn | Step::Stop | Step::Leave => {}
            }
        }
        let components = Components::new(&successors);
        let mut calls = Self { successors, components, main: Vec::new(), interrupt: Vec::new() };
        calls.main = calls.depths(graph, &graph.entries, 0);
        let starts: Vec<_> = graph.routines.iter().map(|routine| routine.start).collect();
        calls.interrupt = calls.depths(graph, &starts, calls.most_open().min(STACK));
        calls
    }

    /// The most calls that the program itself can have open.
    pub(super) fn most_open(&self) -> usize {
        self.main.iter().flatten().map(|depth| depth.open).max().unwrap_or(0)
    }

    /// How many calls can be open at an instruction.
    pub(super) fn depth(&self, address: usize, context: Context) -> Option<Depth> {
        let depths = if context.in_interrupt() { &self.interrupt } else { &self.main };
        depths.get(address).copied().flatten()
    }

    /// The CSUB at `address` can be executed again before its subroutine returned.
    pub(super) fn is_recursive(&self, graph: &Graph, address: usize) -> bool {
        match graph.step(address) {
            Step::Call(target) => {
                self.component(address) == self.component(target) && !self.successors[address].is_empty()
            }
            _ => false,
        }
    }

    /// A number that instructions share which lead to one another.
    pub(super) fn component(&self, address: usize) -> Option<usize> {
        self.components.of.get(address).copied()
    }

    /// For each CSUB, whether it can find the stack full; all of them can where the depth has no bound.
    pub(super) fn ignorable(&self, graph: &Graph) -> Vec<bool> {
        let unbounded = (0..graph.len()).any(|address| self.is_recursive(graph, address));
        let is_full =
            |address, context| self.depth(address, context).is_some_and(|depth| depth.open >= STACK);
        let can_be_full = |address| Context::ALL.iter().any(|context| is_full(address, *context));
        let is_call = |address| matches!(graph.step(address), Step::Call(_));
        (0..graph.len()).map(|address| is_call(address) && (unbounded || can_be_full(address))).collect()
    }

    /// The calls on a shortest way from the subroutine that a recursive CSUB calls back to that CSUB, which comes last.
    pub(super) fn cycle(&self, graph: &Graph, call: usize) -> Vec<usize> {
        let Step::Call(start) = graph.step(call) else { return Vec::new() };
        let mut from = vec![None; graph.len()];
        let mut to_do = std::collections::VecDeque::from([start]);
        while let Some(address) = to_do.pop_front() {
            for next in &self.successors[address] {
                if *next != start && from[*next].is_none() && self.component(*next) == self.component(start) {
                    from[*next] = Some(address);
                    to_do.push_back(*next);
                }
            }
        }
        let way = core::iter::successors(Some(call), |address| from[*address]);
        // An instruction whose call was passed over leads to the next one; one whose call was taken, to the target.
        let mut calls = vec![call];
        let mut after = call;
        for address in way.skip(1) {
            if matches!(graph.step(address), Step::Call(target) if target == after) {
                calls.push(address);
            }
            after = address;
        }
        calls.reverse();
        calls
    }

    /// The longest chain of open calls at each instruction that is reached from `starts`; recursive calls do not count.
    fn depths(&self, graph: &Graph, starts: &[usize], open: usize) -> Vec<Option<Depth>> {
        let mut depths: Vec<Option<Depth>> = vec![None; graph.len()];
        let deepen = |depths: &mut Vec<Option<Depth>>, address: usize, new: Depth| {
            if let Some(depth) = depths.get_mut(address)
                && depth.is_none_or(|depth| depth.open < new.open)
            {
                *depth = Some(new);
            }
        };
        for start in starts {
            deepen(&mut depths, *start, Depth { open, call: None });
        }
        // Components in the order of the flow; within one, all instructions have the depth of the deepest.
        let order: Vec<_> = self.components.order.iter().rev().copied().collect();
        for members in order.chunk_by(|a, b| self.component(*a) == self.component(*b)) {
            let deepest = members.iter().filter_map(|member| depths[*member]).max_by_key(|depth| depth.open);
            let Some(here) = deepest else { continue };
            for member in members {
                depths[*member] = Some(here);
                for next in self.successors[*member]
                    .iter()
                    .filter(|next| self.component(**next) != self.component(*member))
                {
                    let is_call = matches!(graph.step(*member), Step::Call(target) if target == *next);
                    let called = Depth { open: here.open + 1, call: Some(*member) };
                    deepen(&mut depths, *next, if is_call { called } else { here });
                }
            }
        }
        depths
    }
}
