//! Binary trees, split by the library's measures in a full sweep over all positions along three axes, without bins.

use super::tree::{Shape, inner, leaf};
use crate::data::MeshData;
use core::array::from_fn;
use simdop::node::Child;

/// Measure that selects the split.
#[derive(Copy, Clone, PartialEq, Eq)]
pub(crate) enum Measure {
    /// At the middle of the longest axis of the centroids' box.
    LongestAxis,
    /// Smallest sum of box area times triangles.
    Area,
    /// Smallest sum of the cubed mean width of the box times triangles: the library's default.
    MeanWidth,
}

#[derive(Copy, Clone)]
struct Bounds([f64; 3], [f64; 3]);

impl Bounds {
    const EMPTY: Self = Self([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);

    fn join(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i].min(other.0[i])), from_fn(|i| self.1[i].max(other.1[i])))
    }

    fn centre(self) -> [f64; 3] {
        from_fn(|i| 0.5 * (self.0[i] + self.1[i]))
    }

    fn widths(self) -> [f64; 3] {
        from_fn(|i| self.1[i] - self.0[i])
    }
}

impl Measure {
    fn of(self, bounds: Bounds) -> f64 {
        let [x, y, z] = bounds.widths();
        match self {
            Self::LongestAxis => 0.0,
            Self::Area => x * y + y * z + z * x,
            Self::MeanWidth => (x + y + z).powi(3),
        }
    }
}

struct Splitter {
    measure: Measure,
    boxes: Vec<Bounds>,
    centroids: Vec<[f64; 3]>,
    nodes: Vec<[Child; 2]>,
}

/// The binary tree of a mesh, one triangle per leaf, nodes in depth-first order.
pub(crate) fn split(mesh: &MeshData, measure: Measure) -> Shape<2> {
    let boxes: Vec<_> = mesh
        .corners()
        .iter()
        .map(|corners| corners.iter().fold(Bounds::EMPTY, |b, &p| b.join(Bounds(p, p))))
        .collect();
    let centroids = boxes.iter().map(|b| b.centre()).collect();
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut splitter = Splitter { measure, boxes, centroids, nodes: Vec::new() };
    splitter.node(&mut order, 0);
    Shape { nodes: splitter.nodes, order }
}

impl Splitter {
    /// The tree of `items`, the first of which is leaf `start`.
    fn node(&mut self, items: &mut [u32], start: usize) -> Child {
        if let [_] = items {
            return leaf(start);
        }
        let node = self.nodes.len();
        self.nodes.push([Child::EMPTY; 2]);
        let mut count = self.cut(items);
        // As in the library: the outermost child is searched for a hit first.
        let whole = self.bounds(items).centre();
        let distance = |items: &[u32]| -> f64 {
            let centre = self.bounds(items).centre();
            (0..3).map(|i| (centre[i] - whole[i]).powi(2)).sum()
        };
        if distance(&items[..count]) < distance(&items[count..]) {
            items.rotate_left(count);
            count = items.len() - count;
        }
        let (first, second) = items.split_at_mut(count);
        self.nodes[node] = [self.node(first, start), self.node(second, start + count)];
        inner(node)
    }

    fn bounds(&self, items: &[u32]) -> Bounds {
        items.iter().fold(Bounds::EMPTY, |b, &i| b.join(self.boxes[i as usize]))
    }

    /// Sorts `items` along an axis, and returns how many go to the first child.
    fn cut(&self, items: &mut [u32]) -> usize {
        let sort = |items: &mut [u32], axis: usize| {
            let at = |i: u32| self.centroids[i as usize][axis];
            items.sort_unstable_by(|&i, &j| at(i).total_cmp(&at(j)).then(i.cmp(&j)));
        };
        if self.measure == Measure::LongestAxis {
            let point = |&i: &u32| Bounds(self.centroids[i as usize], self.centroids[i as usize]);
            let widths = items.iter().map(point).fold(Bounds::EMPTY, Bounds::join).widths();
            sort(items, (0..3).fold(0, |longest, i| if widths[i] > widths[longest] { i } else { longest }));
            return items.len() / 2;
        }
        let mut best = (f64::INFINITY, 0, items.len() / 2);
        for axis in 0..3 {
            sort(items, axis);
            let (count, cost) = self.sweep(items);
            if cost < best.0 {
                best = (cost, axis, count);
            }
        }
        sort(items, best.1);
        best.2
    }

    /// The cheapest cut of sorted items, and its cost.
    fn sweep(&self, items: &[u32]) -> (usize, f64) {
        let cost = |bounds, count: usize| self.measure.of(bounds) * count as f64;
        let grow = |bounds: &mut Bounds, &i: &u32| {
            *bounds = bounds.join(self.boxes[i as usize]);
            Some(*bounds)
        };
        let behind: Vec<Bounds> = items.iter().rev().scan(Bounds::EMPTY, grow).collect();
        let before = items.iter().scan(Bounds::EMPTY, grow).enumerate().take(items.len() - 1);
        let costs = before.map(|(i, bounds)| {
            let (count, rest) = (i + 1, items.len() - i - 1);
            (count, cost(bounds, count) + cost(behind[rest - 1], rest))
        });
        costs.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((items.len() / 2, f64::INFINITY))
    }
}
