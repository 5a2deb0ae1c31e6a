//! The BNG paper's control group. Both choose four spheres and give each of the others to the one whose
//! centre is nearest. (The paper says "closest"; with the nearest surface instead, big spheres draw in their
//! whole surroundings, trees inside meshes get over 100 levels, and the four biggest cost ten times as many
//! tests, which is not what the paper found.)

use super::packing::Sphere;

/// The four biggest.
pub(crate) fn biggest(spheres: &[Sphere], items: &[u32]) -> Vec<Vec<u32>> {
    let mut by_size = items.to_vec();
    by_size.sort_by(|&a, &b| {
        let radius = |i: u32| spheres[i as usize].radius;
        radius(b).total_cmp(&radius(a)).then(a.cmp(&b))
    });
    by_size.truncate(4);
    nearest(spheres, items, &by_size)
}

/// First and last along each of the two axes with the largest extent: four, or fewer where one is both.
pub(crate) fn extremes(spheres: &[Sphere], items: &[u32]) -> Vec<Vec<u32>> {
    let ends = |axis: usize| {
        let along = |&a: &u32, &b: &u32| {
            let place = |i: u32| spheres[i as usize].centre[axis];
            place(a).total_cmp(&place(b)).then(a.cmp(&b))
        };
        let end = |found: Option<u32>| found.expect("a node has spheres");
        [end(items.iter().copied().min_by(along)), end(items.iter().copied().max_by(along))]
    };
    let mut axes = [0, 1, 2].map(|axis| {
        let [first, last] = ends(axis).map(|i| spheres[i as usize].centre[axis]);
        (last - first, axis)
    });
    axes.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut chosen: Vec<u32> = axes[..2].iter().flat_map(|&(_, axis)| ends(axis)).collect();
    chosen.sort_unstable();
    chosen.dedup();
    nearest(spheres, items, &chosen)
}

/// A part for each of the `chosen`, which holds it and the others that are nearest to it; the first of
/// equals.
fn nearest(spheres: &[Sphere], items: &[u32], chosen: &[u32]) -> Vec<Vec<u32>> {
    let mut parts: Vec<Vec<u32>> = chosen.iter().map(|&c| vec![c]).collect();
    for &item in items.iter().filter(|item| !chosen.contains(item)) {
        let distance = |&part: &usize| spheres[item as usize].distance(spheres[chosen[part] as usize].centre);
        let part = (0..chosen.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let part = part.expect("one is chosen");
        parts[part].push(item);
    }
    parts
}
