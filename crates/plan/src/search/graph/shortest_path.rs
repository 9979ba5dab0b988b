use std::cmp::Reverse;
use std::collections::BinaryHeap;

use cranny_robot::distance;

/// Node that the search has reached.
#[derive(Clone, Debug)]
struct Visit {
    /// Length of the path to the node.
    cost: f64,
    /// Lower bound of the length from the node to a goal.
    bound: f64,
    before: Option<usize>,
    is_closed: bool,
}

/// Returns the nodes of the shortest path (L2) in a graph from a node to any of `goals`: A* (Hart, Nilsson & Raphael 1968, §II)
/// with the distance to the nearest goal as bound. `beside` gives the nodes that an edge joins with a node.
pub(crate) fn shortest_path<I: Iterator<Item = usize>>(
    nodes: &[Vec<f64>],
    beside: impl Fn(usize) -> I,
    from: usize,
    goals: &[usize],
) -> Option<Vec<usize>> {
    let bound_at = |node: usize| {
        let distances = goals.iter().map(|goal| distance(&nodes[node], &nodes[*goal]));
        distances.fold(f64::INFINITY, f64::min)
    };
    let mut visits: Vec<Option<Visit>> = vec![None; nodes.len()];
    visits[from] = Some(Visit { cost: 0.0, bound: bound_at(from), before: None, is_closed: false });
    // Costs are not negative, so their bit patterns sort in the same order.
    let mut open = BinaryHeap::from([(Reverse(0.0_f64.to_bits()), from)]);
    while let Some((_, node)) = open.pop() {
        let Some(visit) = visits[node].as_mut() else { continue };
        if std::mem::replace(&mut visit.is_closed, true) {
            continue;
        }
        let to_here = visit.cost;
        if goals.contains(&node) {
            let before = |node: &usize| visits[*node].as_ref().and_then(|visit| visit.before);
            let mut way: Vec<usize> = std::iter::successors(Some(node), before).collect();
            way.reverse();
            return Some(way);
        }
        for next in beside(node) {
            let cost = to_here + distance(&nodes[node], &nodes[next]);
            let bound = match &visits[next] {
                // With this bound a closed node has its least cost, except for rounding.
                Some(visit) if visit.is_closed || cost >= visit.cost => continue,
                Some(visit) => visit.bound,
                None => bound_at(next),
            };
            visits[next] = Some(Visit { cost, bound, before: Some(node), is_closed: false });
            open.push((Reverse((cost + bound).to_bits()), next));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Stream;

    use super::*;

    fn length(nodes: &[Vec<f64>], way: &[usize]) -> f64 {
        way.windows(2).map(|edge| distance(&nodes[edge[0]], &nodes[edge[1]])).sum()
    }

    /// Returns the least length from each node to a goal, by repeated relaxation of all edges.
    fn least_lengths(nodes: &[Vec<f64>], edges: &[[usize; 2]], goals: &[usize]) -> Vec<f64> {
        let mut least = vec![f64::INFINITY; nodes.len()];
        for goal in goals {
            least[*goal] = 0.0;
        }
        for _ in nodes {
            for &[a, b] in edges {
                let by = distance(&nodes[a], &nodes[b]);
                least[a] = least[a].min(least[b] + by);
                least[b] = least[b].min(least[a] + by);
            }
        }
        least
    }

    #[test]
    fn no_path_is_shorter_than_that_of_repeated_relaxation() {
        let mut random = Stream::new(5, 0);
        let mut found = 0;
        for _ in 0..50 {
            let nodes: Vec<Vec<f64>> =
                (0..30).map(|_| (0..3).map(|_| random.uniform_between(-1.0, 1.0)).collect()).collect();
            let edges: Vec<[usize; 2]> = (0..35).map(|_| [random.index(30), random.index(30)]).collect();
            let goals = [28, 29];
            let beside = |node: usize| {
                let both = edges.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
                both.filter(move |edge| edge[0] == node).map(|edge| edge[1])
            };
            let expected = least_lengths(&nodes, &edges, &goals)[0];
            match shortest_path(&nodes, beside, 0, &goals) {
                None => assert!(expected.is_infinite()),
                Some(way) => {
                    found += 1;
                    let is_edge = |edge: &[usize]| {
                        edges.contains(&[edge[0], edge[1]]) || edges.contains(&[edge[1], edge[0]])
                    };
                    assert!(way[0] == 0 && way.last().is_some_and(|last| goals.contains(last)));
                    assert!(way.windows(2).all(is_edge));
                    assert!((length(&nodes, &way) - expected).abs() < 1e-12);
                }
            }
        }
        assert!((10..50).contains(&found), "both cases must occur: {found}");
    }
}
