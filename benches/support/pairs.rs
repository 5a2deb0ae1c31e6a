//! The pairs of `benches/peers` with poses of A, for benches of variants, and how their ratios spread.

use crate::data::{MeshData, directory};
use crate::meshes::SCENES;
use crate::shapes;
use crate::short::count;
use crate::suites::{Approaching, DISTANCES, Method, Rows};

/// Lines of approach per pair.
const LINES: usize = 200;

/// Names and meshes of the pairs; without their files, a torus against itself.
pub(crate) fn pairs() -> Vec<(&'static str, MeshData, MeshData)> {
    let Some(data) = directory() else {
        let torus = shapes::wavy_torus(count(20_000, 1000) as u32);
        return vec![("torus", torus.clone(), torus)];
    };
    let pair = |scene: &crate::meshes::Scene| {
        let mut meshes = scene.meshes(&data);
        let b = meshes.pop().expect("a scene has a mesh");
        (scene.name, meshes.pop().unwrap_or_else(|| b.clone()), b)
    };
    SCENES[..count(SCENES.len(), 1)].iter().map(pair).collect()
}

/// Poses of lines found in both ways, one at each of [`DISTANCES`].
pub(crate) fn lines(pair: &Approaching<'_>) -> Vec<[Rows; 4]> {
    Method::ALL
        .into_iter()
        .flat_map(|method| pair.poses(&DISTANCES, method, count(LINES, 8) / 2, 1))
        .collect()
}

/// Least, greatest and middle of ratios, and their geometric mean.
pub(crate) fn spread(mut ratios: Vec<f64>) -> String {
    let mean = (ratios.iter().map(|x| x.ln()).sum::<f64>() / ratios.len() as f64).exp();
    ratios.sort_by(f64::total_cmp);
    let [least, middle, greatest] = [0, ratios.len() / 2, ratios.len() - 1].map(|i| ratios[i]);
    format!("{least:.3} to {greatest:.3}, median {middle:.3}, geometric mean {mean:.3}")
}
