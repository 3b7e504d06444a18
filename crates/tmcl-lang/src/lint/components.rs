//! Strongly connected components, by Tarjan's algorithm with a stack of its own.

/// The component of each node and, component by component, the nodes; a component comes after all that it leads to.
pub(super) struct Components {
    /// The component of each node.
    pub(super) of: Vec<usize>,
    /// The nodes, those of a component together.
    pub(super) order: Vec<usize>,
}

const NONE: usize = usize::MAX;

struct Search<'a> {
    successors: &'a [Vec<usize>],
    /// When each node was found.
    index: Vec<usize>,
    /// The earliest node that each leads back to.
    low: Vec<usize>,
    /// Nodes that belong to no component yet.
    open: Vec<usize>,
    found: usize,
    count: usize,
    components: Components,
}

impl Components {
    /// The components of the graph in which node n leads to `successors[n]`.
    pub(super) fn new(successors: &[Vec<usize>]) -> Self {
        let len = successors.len();
        let components = Self { of: vec![NONE; len], order: Vec::with_capacity(len) };
        let (index, low) = (vec![NONE; len], vec![NONE; len]);
        let mut search = Search { successors, index, low, open: Vec::new(), found: 0, count: 0, components };
        for node in 0..len {
            if search.index[node] == NONE {
                search.from(node);
            }
        }
        search.components
    }
}

impl Search<'_> {
    fn from(&mut self, root: usize) {
        // A node and how many of its successors were looked at.
        let mut path = vec![(root, 0)];
        self.find(root);
        while let Some((node, looked_at)) = path.last_mut() {
            let node = *node;
            let Some(next) = self.successors[node].get(*looked_at).copied() else {
                path.pop();
                self.close(node);
                if let Some((before, _)) = path.last() {
                    self.low[*before] = self.low[*before].min(self.low[node]);
                }
                continue;
            };
            *looked_at += 1;
            if self.index[next] == NONE {
                self.find(next);
                path.push((next, 0));
            } else if self.components.of[next] == NONE {
                self.low[node] = self.low[node].min(self.index[next]);
            }
        }
    }

    fn find(&mut self, node: usize) {
        self.index[node] = self.found;
        self.low[node] = self.found;
        self.found += 1;
        self.open.push(node);
    }

    /// Cuts a component off where `node` leads back to nothing before it.
    fn close(&mut self, node: usize) {
        if self.low[node] != self.index[node] {
            return;
        }
        while let Some(member) = self.open.pop() {
            self.components.of[member] = self.count;
            self.components.order.push(member);
            if member == node {
                break;
            }
        }
        self.count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_circles_and_a_bridge() {
        let successors = [vec![1], vec![0, 2], vec![3], vec![2], vec![]];
        let Components { of, order } = Components::new(&successors);
        assert_eq!(of[0], of[1]);
        assert_eq!(of[2], of[3]);
        assert!(of[2] < of[0], "what is led to comes first");
        assert_eq!(order.len(), 5);
        assert_ne!(of[4], of[0]);
    }

    #[test]
    fn a_long_chain_needs_no_native_stack() {
        let successors: Vec<_> = (1..=1_000_000_usize).map(|next| vec![next % 1_000_000]).collect();
        let Components { of, .. } = Components::new(&successors);
        assert!(of.iter().all(|component| *component == 0));
    }
}
