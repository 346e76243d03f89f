//! The shortest way along which a run takes one step, with internal steps around it.

use std::collections::{HashMap, VecDeque};

use crate::model::State;

/// A state on the way, with whether the step itself has been taken.
pub(crate) type Node = (State, bool);

/// A shortest way from a node to a state behind the step, among at most so many nodes; none where there is none, or what
/// comes next at a node is not known.
pub(crate) fn shortest<C: Clone>(
    start: Node,
    to: &State,
    most: usize,
    mut nexts: impl FnMut(&Node) -> Option<Vec<(Node, C)>>,
) -> Option<Vec<C>> {
    let mut came: HashMap<Node, Option<(Node, C)>> = HashMap::from([(start.clone(), None)]);
    let mut open = VecDeque::from([start]);
    while let Some(node) = open.pop_front() {
        if node.1 && node.0 == *to {
            let mut way = Vec::new();
            let mut at = node;
            while let Some(Some((before, choice))) = came.get(&at) {
                way.push(choice.clone());
                at = before.clone();
            }
            way.reverse();
            return Some(way);
        }
        if came.len() > most {
            return None;
        }
        for (next, choice) in nexts(&node)? {
            if !came.contains_key(&next) {
                came.insert(next.clone(), Some((node.clone(), choice)));
                open.push_back(next);
            }
        }
    }
    None
}
