//! Clusters get subtrees, trees are what an [`Assignment`] has to be, and no deeper than a tree may be.

use super::*;
use core::ops::ControlFlow;

/// Items cut at equal parts, in the order in which they come.
fn in_order(items: &Items, arity: usize) -> Assignment {
    let mut shape = Assignment { order: (0..items.boxes.len() as u32).collect(), ends: Vec::new() };
    let mut waiting = VecDeque::new();
    waiting.push_back(0..items.boxes.len());
    while let Some(range) = waiting.pop_front() {
        let mut start = range.start;
        for lane in 1..=arity {
            let end = range.start + range.len() * lane / arity;
            shape.ends.push(end as u32);
            if end - start > 1 {
                waiting.push_back(start..end);
            }
            start = end;
        }
    }
    shape
}

fn grid(boxes: &mut Vec<Aabb>, corner: f64, step: f64, side: u32) {
    for i in 0..side * side {
        let low = [corner + step * f64::from(i % side), corner + step * f64::from(i / side), corner];
        boxes.push(Aabb::of((low, low.map(|x| x + step))));
    }
}

/// Each twenty times narrower than the last, and inside of it.
fn nested(levels: i32) -> Vec<Aabb> {
    let mut boxes = Vec::new();
    for level in 0..levels {
        grid(&mut boxes, 0.0, 0.1 * 0.05_f64.powi(level), 10);
    }
    boxes
}

fn graft_of(boxes: Vec<Aabb>, arity: usize) -> (Items, Option<Assignment>) {
    let items = Items { boxes, weights: None };
    let (mut last, total) = (0, items.boxes.len());
    let mut observer = |progress: Progress| {
        assert!(progress.total == total && (last..=total).contains(&progress.placed), "{progress:?}");
        last = progress.placed;
        ControlFlow::Continue(())
    };
    let mut split = |items: &Items, observer: &mut Observer<'_>| {
        let total = items.boxes.len();
        (0..=total).step_by(50).for_each(|placed| {
            let _ = observer(Progress { placed, total });
        });
        Ok::<_, BuildError>(in_order(items, arity))
    };
    let whole = assign(&items, arity, true, &mut observer, &mut split).unwrap();
    let shape = graft(&items, arity, NESTED, &mut |_| ControlFlow::Continue(()), &mut split).unwrap();
    assert_eq!(whole, shape.clone().unwrap_or_else(|| in_order(&items, arity)));
    (items, shape)
}

#[test]
fn clusters_get_subtrees() {
    for arity in [4, 16] {
        let mut boxes = Vec::new();
        grid(&mut boxes, 0.0, 0.1, 10);
        grid(&mut boxes, 0.3, 1e-6, 12);
        grid(&mut boxes, 0.7, 1e-7, 9);
        let details = details_of(&boxes);
        let first: Vec<u32> = (100..244).collect();
        let second: Vec<u32> = (244..325).collect();
        assert_eq!(details, [first.clone(), second.clone()]);
        let (items, shape) = graft_of(boxes, arity);
        let shape = shape.unwrap();
        shape.check(items.boxes.len(), arity, 1).unwrap();
        // One node for each holds nothing else.
        for detail in [first, second] {
            let at = shape.order.iter().position(|item| *item == detail[0]).unwrap();
            let mut run = shape.order[at..at + detail.len()].to_vec();
            run.sort_unstable();
            assert_eq!(run, detail);
        }
    }
}

#[test]
fn what_is_no_cluster_stays() {
    for boxes in [Vec::new(), nested(1), alloc::vec![Aabb::of(([1.0; 3], [1.0; 3])); 500]] {
        assert!(details_of(&boxes).is_empty() && graft_of(boxes, 16).1.is_none());
    }
    // Too few, too wide for how many there are, and all of the body.
    for (step, side) in [(1e-6, 7), (1e-4, 12), (1e-2, 100)] {
        let mut boxes = nested(1);
        grid(&mut boxes, 0.5, step, side);
        assert!(details_of(&boxes).is_empty(), "{step:e}");
    }
}

/// Clusters in clusters, until a tree of them would be too deep.
#[test]
fn trees_are_no_deeper_than_the_limit() {
    let (mut grafted, mut refused) = (0, 0);
    for levels in [2, 4, 6, 8, 12, 20] {
        let mut boxes = Vec::new();
        for level in 0..levels {
            grid(&mut boxes, 0.0, 0.1 * 0.0005_f64.powi(level), 10);
        }
        let (items, shape) = graft_of(boxes, 4);
        match shape {
            Some(shape) => {
                shape.check(items.boxes.len(), 4, 1).unwrap();
                grafted += 1;
            }
            None => refused += 1,
        }
    }
    assert!(grafted > 1 && refused > 0, "{grafted} {refused}");
}
