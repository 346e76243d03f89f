//! The parts of a graph that are never left.

/// The sets of places that all reach each other and nothing else; an edge to nowhere leaves its part.
pub(super) fn final_parts(edges: &[Vec<Option<usize>>]) -> Vec<Vec<usize>> {
    let count = edges.len();
    let mut backwards: Vec<Vec<usize>> = vec![Vec::new(); count];
    for (from, edges) in edges.iter().enumerate() {
        for to in edges.iter().flatten() {
            backwards[*to].push(from);
        }
    }
    let forwards = |place: usize| edges[place].iter().flatten().copied().collect::<Vec<_>>();
    let mut seen = vec![false; count];
    let mut order = Vec::with_capacity(count);
    for start in 0..count {
        let mut stack = vec![(start, false)];
        while let Some((place, done)) = stack.pop() {
            if done {
                order.push(place);
            } else if !std::mem::replace(&mut seen[place], true) {
                stack.push((place, true));
                stack.extend(forwards(place).into_iter().map(|next| (next, false)));
            }
        }
    }
    let mut part = vec![usize::MAX; count];
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for start in order.into_iter().rev().filter(|_| count > 0) {
        let mut stack = vec![start];
        let mut members = Vec::new();
        while let Some(place) = stack.pop() {
            if part[place] == usize::MAX {
                part[place] = parts.len();
                members.push(place);
                stack.extend(backwards[place].iter().copied());
            }
        }
        if !members.is_empty() {
            parts.push(members);
        }
    }
    let stays = |place: &usize| edges[*place].iter().all(|to| to.is_some_and(|to| part[to] == part[*place]));
    parts.into_iter().filter(|members| members.iter().all(stays)).collect()
}
