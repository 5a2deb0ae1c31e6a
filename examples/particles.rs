//! Particles of mixed sizes, much denser in some places than in others: finds all contacts in every frame.
//!
//! ```sh
//! cargo run --release --example particles
//! ```
//!
//! Xing, Wang, Hui, *Coherent Spherical Range-Search for Dynamic Points on GPUs*, CAD 2017, section 5.2, figures 18 and
//! 19, with radii that differ by a factor of 50. No cell size of a grid suits them all; here each particle searches
//! with its own radius. The tree is refitted in each frame, and rebuilt when that pays (section 4.4).

mod points;

use core::ops::ControlFlow;
use glam::Vec3;
use points::Random;
use simdop::cloud::{
    CloudRef, PointCloud, Policy, Queries, Radii, RangeSearch, RangeStats, SearchError, Upkeep,
};
use simdop::isa::Isa;

const FRAMES: usize = 300;
/// Time step in seconds.
const STEP: f32 = 0.01;

/// Acceleration towards the centre, relative to the distance from it.
const PULL: f32 = 4.0;

struct Particles {
    positions: Vec<[f32; 3]>,
    velocities: Vec<Vec3>,
    radii: Vec<f32>,
    /// Twice the radius: the search radius for contacts with particles that are no larger.
    reaches: Vec<f32>,
}

impl Particles {
    /// Half of them lie in an 800th of the volume, where they barely fit.
    fn new(count: usize) -> Self {
        let (random, reach) = (&mut Random(4), 0.3 * (count as f32).cbrt());
        let positions: Vec<[f32; 3]> = (0..count)
            .map(|_| (random.direction() * (reach * (0.05 + random.unit().powi(4)))).to_array())
            .collect();
        // Each moves on its own circle around the centre, so that the density stays constant, and particles meet.
        let circle = |p: &[f32; 3]| {
            let p = Vec3::from(*p);
            p.cross(random.direction()).normalize_or_zero() * p.length() * PULL.sqrt()
        };
        let velocities = positions.iter().map(circle).collect();
        // As many radii from 0.0005 to 0.001 as from 0.0125 to 0.025.
        let radii: Vec<f32> = (0..count).map(|_| 0.025 * 50.0_f32.powf(-random.unit())).collect();
        let reaches = radii.iter().map(|r| r + r).collect();
        Self { positions, velocities, radii, reaches }
    }

    /// Whether the spheres of two particles meet.
    fn touch(&self, i: u32, j: u32) -> bool {
        let ([i, j], reach) = ([i as usize, j as usize], self.radii[i as usize] + self.radii[j as usize]);
        let [x, y, z] = [0, 1, 2].map(|k| self.positions[i][k] - self.positions[j][k]);
        // As the search computes it, so that it finds every contact.
        (x * x + y * y) + z * z <= reach * reach
    }

    /// Whether particle i is the one to report its contact with j: the larger one, whose search radius suffices. For
    /// equal sizes, the one with the lower index.
    fn finds(&self, i: u32, j: u32) -> bool {
        let (of_i, of_j) = (self.radii[i as usize], self.radii[j as usize]);
        of_i > of_j || of_i == of_j && i < j
    }

    /// All pairs that touch, each once.
    fn contacts(
        &self,
        search: &RangeSearch,
        cloud: &CloudRef<'_>,
        pairs: &mut Vec<[u32; 2]>,
    ) -> Result<RangeStats, SearchError> {
        pairs.clear();
        search.visit(cloud, &Queries::own(), Radii::Each(&self.reaches), |i, j| {
            if self.finds(i, j) && self.touch(i, j) {
                pairs.push([i, j]);
            }
            ControlFlow::Continue(())
        })
    }

    /// A frame: pushes touching particles apart, and pulls all towards the centre.
    fn step(&mut self, pairs: &[[u32; 2]]) {
        let count = self.positions.len();
        let (mut pushes, mut contacts) = (vec![Vec3::ZERO; count], vec![0.0_f32; count]);
        for &[i, j] in pairs {
            let [i, j] = [i as usize, j as usize];
            let apart = Vec3::from(self.positions[i]) - Vec3::from(self.positions[j]);
            let overlap = self.radii[i] + self.radii[j] - apart.length();
            let push = apart.try_normalize().unwrap_or(Vec3::X) * overlap;
            // The heavier one moves less, by volume.
            let share = self.radii[j].powi(3) / (self.radii[i].powi(3) + self.radii[j].powi(3));
            pushes[i] += push * share;
            pushes[j] -= push * (1.0 - share);
            contacts[i] += 1.0;
            contacts[j] += 1.0;
        }
        for i in 0..count {
            let push = pushes[i] / contacts[i].max(1.0);
            let before = Vec3::from(self.positions[i]);
            let velocity = &mut self.velocities[i];
            *velocity -= before * (PULL * STEP);
            let after = before + *velocity * STEP + push;
            // A pushed particle keeps moving in that direction, damped.
            *velocity += push * (0.2 / STEP);
            *velocity *= 0.995;
            self.positions[i] = after.to_array();
        }
    }

    /// Runs the simulation, and passes each frame's contacts to `show`. Returns the number of rebuilds.
    fn run(
        &mut self,
        frames: usize,
        mut show: impl FnMut(usize, &Self, &[[u32; 2]]),
    ) -> Result<usize, Box<dyn core::error::Error>> {
        let search = RangeSearch::new(Isa::detect());
        let mut cloud = PointCloud::new(&self.positions)?;
        let mut upkeep = Upkeep::new(Policy::Work);
        let (mut pairs, mut rebuilds) = (Vec::new(), 0);
        for frame in 0..frames {
            let ratio = cloud.refit(&self.positions)?;
            let work = self.contacts(&search, &cloud.view(), &mut pairs)?;
            show(frame, self, &pairs);
            if upkeep.is_due(&cloud.view(), ratio, &work) {
                cloud.rebuild()?;
                rebuilds += 1;
            }
            self.step(&pairs);
        }
        Ok(rebuilds)
    }
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let mut particles = Particles::new(20_000);
    let (mut contacts, mut most) = (0, 0);
    let rebuilds = particles.run(FRAMES, |_, _, pairs| {
        contacts += pairs.len();
        most = most.max(pairs.len());
    })?;
    println!(
        "20000 particles, {FRAMES} frames: {} contacts a frame in the mean, {most} at most",
        contacts / FRAMES
    );
    println!("the tree was built anew {rebuilds} times, and refitted in the other frames");
    Ok(())
}

/// The contacts equal those of a loop over all pairs, in frames before and after rebuilds.
#[test]
fn contacts_are_those_of_a_loop() {
    let mut particles = Particles::new(2_500);
    let mut checked = 0;
    let rebuilds = particles.run(FRAMES, |frame, particles, pairs| {
        if frame % 15 != 0 {
            return;
        }
        let mut found: Vec<[u32; 2]> = pairs.iter().map(|&[i, j]| [i.min(j), i.max(j)]).collect();
        found.sort_unstable();
        let count = particles.positions.len() as u32;
        let all = (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j]));
        let want: Vec<[u32; 2]> = all.filter(|&[i, j]| particles.touch(i, j)).collect();
        assert_eq!(found, want, "frame {frame}");
        checked += want.len();
    });
    let rebuilds = rebuilds.unwrap();
    assert!(checked > 5_000, "{checked} contacts");
    assert!(0 < rebuilds && rebuilds < FRAMES / 4, "{rebuilds} rebuilds");
}

#[test]
fn it_runs() {
    main().unwrap();
}
