//! Which instructions are reached, and in which context.

use super::backward::{Passes, can_return};
use super::flow::{Graph, Step};

/// In which context an instruction is executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Context {
    /// The program itself, no call open.
    Main,
    /// A subroutine.
    Subroutine,
    /// An interrupt routine, no call of its own open.
    Interrupt,
    /// A subroutine that an interrupt routine called.
    InterruptSubroutine,
}

impl Context {
    /// Every one.
    pub(super) const ALL: [Self; 4] =
        [Self::Main, Self::Subroutine, Self::Interrupt, Self::InterruptSubroutine];

    /// Whether an interrupt is being handled.
    pub(super) fn in_interrupt(self) -> bool {
        matches!(self, Self::Interrupt | Self::InterruptSubroutine)
    }

    /// Whether a call is open that RSUB may return from.
    fn in_subroutine(self) -> bool {
        matches!(self, Self::Subroutine | Self::InterruptSubroutine)
    }

    /// Where a CSUB leads.
    fn called(self) -> Self {
        if self.in_interrupt() { Self::InterruptSubroutine } else { Self::Subroutine }
    }
}

/// What is taken for flow.
#[derive(Clone, Copy)]
pub(super) enum Rules<'a> {
    /// What the author meant: RSUB, RETI end their routine, wherever they stand.
    Meant,
    /// What the module does: RSUB and RETI are passed over where they mean nothing, and so are these CSUBs.
    Actual {
        /// CSUBs that can find the stack full.
        ignored: &'a [bool],
    },
    /// Whatever may follow: the stack does not match the calls, so that RSUB, RETI and CSUB can lead to what is behind any
    /// CSUB, and be ignored.
    Anything,
}

impl<'a> Rules<'a> {
    fn pass_strays(self) -> bool {
        !matches!(self, Self::Meant)
    }

    fn ignored(self) -> &'a [bool] {
        match self {
            Self::Actual { ignored } => ignored,
            Self::Meant | Self::Anything => &[],
        }
    }
}

/// An instruction in a context.
pub(super) type Place = (usize, Context);

/// What was reached.
#[derive(Clone)]
pub(super) struct Forward {
    /// For each instruction and context: where it was first reached from.
    from: Vec<[Option<From>; 4]>,
    /// RSUBs and RETIs that mean nothing where they were reached.
    pub(super) strays: Vec<Place>,
    /// Instructions behind which the program ends without an instruction that ends it.
    pub(super) leaving: Vec<Place>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum From {
    Host,
    Vector(usize),
    Instruction(Place),
}

impl Forward {
    /// Walks the graph from every entry and interrupt routine.
    pub(super) fn new(graph: &Graph, rules: Rules) -> Self {
        let mut walk = Walk::new(graph, rules);
        for entry in &graph.entries {
            walk.reach((*entry, Context::Main), From::Host);
        }
        for routine in &graph.routines {
            walk.reach((routine.start, Context::Interrupt), From::Vector(routine.vector));
        }
        while let Some(place) = walk.to_do.pop_front() {
            walk.leave(place);
        }
        walk.forward
    }

    /// Whether an instruction is reached in a context.
    pub(super) fn reaches(&self, address: usize, context: Context) -> bool {
        self.from.get(address).is_some_and(|from| from[context as usize].is_some())
    }

    /// Whether an instruction is reached at all.
    pub(super) fn reaches_at_all(&self, address: usize) -> bool {
        Context::ALL.iter().any(|context| self.reaches(address, *context))
    }

    /// Whether RSUB or RETI is reached where it is ignored, takes another routine's return address, or leaves one behind.
    pub(super) fn goes_astray(&self, graph: &Graph) -> bool {
        let leaves_address_behind = |address: usize| {
            graph.step(address) == Step::InterruptReturn
                && self.reaches(address, Context::InterruptSubroutine)
        };
        !self.strays.is_empty() || (0..graph.len()).any(leaves_address_behind)
    }

    /// From where a place was first reached: another place, in the same or the calling routine.
    pub(super) fn before(&self, (address, context): Place) -> Option<Place> {
        match self.from.get(address)?[context as usize]? {
            From::Instruction(place) => Some(place),
            From::Host | From::Vector(_) => None,
        }
    }

    /// The VECT whose routine first led to a place.
    pub(super) fn vector(&self, place: Place) -> Option<usize> {
        let mut place = place;
        loop {
            match self.from.get(place.0)?[place.1 as usize]? {
                From::Instruction(before) => place = before,
                From::Vector(vector) => return Some(vector),
                From::Host => return None,
            }
        }
    }
}

struct Walk<'a> {
    graph: &'a Graph<'a>,
    rules: Rules<'a>,
    /// Whether a subroutine can return, outside and inside interrupt routines.
    returns: [Vec<bool>; 2],
    forward: Forward,
    to_do: std::collections::VecDeque<Place>,
}

impl<'a> Walk<'a> {
    fn new(graph: &'a Graph, rules: Rules<'a>) -> Self {
        let (passes_strays, calls) = (rules.pass_strays(), rules.ignored());
        let outside = can_return(graph, Passes { interrupt_return: passes_strays, calls });
        let inside = can_return(graph, Passes { interrupt_return: false, calls });
        let forward = Forward { from: vec![[None; 4]; graph.len()], strays: Vec::new(), leaving: Vec::new() };
        let to_do = std::collections::VecDeque::new();
        Self { graph, rules, returns: [outside, inside], forward, to_do }
    }

    fn reach(&mut self, place: Place, by: From) {
        let (address, context) = place;
        match self.forward.from.get_mut(address).map(|from| &mut from[context as usize]) {
            Some(from @ None) => {
                *from = Some(by);
                self.to_do.push_back(place);
            }
            Some(_) => {}
            None => {
                if let From::Instruction(last) = by {
                    self.forward.leaving.push(last);
                }
            }
        }
    }

    fn leave(&mut self, place: Place) {
        let (address, context) = place;
        let by = From::Instruction(place);
        let next = (address + 1, context);
        match self.graph.step(address) {
            Step::Next => self.reach(next, by),
            Step::Jump(target) => self.reach((target, context), by),
            Step::Branch(target) => {
                self.reach(next, by);
                self.reach((target, context), by);
            }
            Step::Call(target) => {
                let passes = Passes { interrupt_return: false, calls: self.rules.ignored() };
                let is_passed = passes.call(address) || matches!(self.rules, Rules::Anything);
                if is_passed || self.can_return(target, context) {
                    self.reach(next, by);
                }
                self.reach((target, context.called()), by);
            }
            Step::SubroutineReturn => self.return_from(place, context.in_subroutine()),
            Step::InterruptReturn => self.return_from(place, context.in_interrupt()),
            Step::Stop | Step::Leave => {}
        }
    }

    fn return_from(&mut self, place: Place, means_something: bool) {
        if means_something && !matches!(self.rules, Rules::Anything) {
            return;
        }
        self.forward.strays.push(place);
        if self.rules.pass_strays() {
            self.reach((place.0 + 1, place.1), From::Instruction(place));
        }
    }

    fn can_return(&self, target: usize, context: Context) -> bool {
        let [outside, inside] = &self.returns;
        let returns = if context.in_interrupt() { inside } else { outside };
        returns.get(target).copied().unwrap_or(false)
    }
}
