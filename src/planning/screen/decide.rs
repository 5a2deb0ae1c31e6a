//! Sixteen configurations through all bounds.

use super::apart::are_apart;
use super::blocks::Radii16;
use super::bodies::LaneBody;
use super::chain::{LaneFrame, OneFrame};
use super::grid::ClearanceGrid;
use super::lanes::{LANES, Point16, mask};
use super::whole::{BodyPair, Screen, SeenBody};
use crate::isa::{Isa, on_isa};
use crate::kernel::Kernel;
use crate::scene::BodyId;
use alloc::vec;
use alloc::vec::Vec;

/// A body in doubt, and against what.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Doubt {
    /// Against all bodies of a field that stand still.
    Field { field: usize, body: usize },
    /// Two bodies of the robot.
    Pair { pair: usize },
    /// A pair with a table.
    Table { pair: usize },
}

/// Memory for sixteen configurations, and what the bounds leave open.
#[derive(Clone, Debug)]
pub(in crate::planning) struct Doubts {
    frames: Vec<LaneFrame>,
    /// The centres of the spheres around whole bodies.
    wholes: Vec<Point16>,
    doubts: Vec<(Doubt, u16)>,
    /// Values of each variable.
    pub(in crate::planning) values: Vec<[f64; LANES]>,
}

/// Lanes in which the robot is free for certain, and those in which it meets something.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::planning) struct LaneVerdicts {
    pub(in crate::planning) free: u16,
    pub(in crate::planning) hit: u16,
}

/// Bodies of the robot, by index, that the scene must decide.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(in crate::planning) enum OpenPair<'s> {
    /// One, and what stands still.
    Standing(usize, &'s [BodyId]),
    /// Two.
    Own([usize; 2]),
}

impl Screen {
    pub(in crate::planning) fn doubts(&self, variables: usize) -> Doubts {
        let fields: usize = self.fields.iter().map(|field| field.asked.len()).sum();
        Doubts {
            frames: vec![LaneFrame::NOWHERE; self.chain.links()],
            wholes: vec![[[0.0; LANES]; 3]; self.bodies.len()],
            doubts: Vec::with_capacity(fields + self.pairs.len() + self.tabled.len()),
            values: vec![[0.0; LANES]; variables],
        }
    }

    /// Decides the configurations in the lanes of a mask, whose values are in `doubts`.
    pub(in crate::planning) fn decide(&self, isa: Isa, lanes: u16, doubts: &mut Doubts) -> LaneVerdicts {
        if self.is_blocked {
            return LaneVerdicts { free: 0, hit: lanes };
        }
        let open = on_isa!(isa, token => token.run(
            #[inline(always)]
            || self.decide_lanes(lanes, doubts),
        ));
        let asked = doubts.doubts.iter().fold(0, |mask, (_, lanes)| mask | lanes);
        LaneVerdicts { free: open & !asked, hit: lanes & !open }
    }

    /// The pairs of bodies that a lane leaves open.
    pub(in crate::planning) fn open_pairs<'s>(
        &'s self,
        lane: usize,
        doubts: &'s Doubts,
    ) -> impl Iterator<Item = OpenPair<'s>> + 's {
        let of_lane = move |(_, lanes): &&(Doubt, u16)| lanes >> lane & 1 != 0;
        doubts.doubts.iter().filter(of_lane).map(|(doubt, _)| match *doubt {
            Doubt::Field { field, body } => OpenPair::Standing(body, &self.fields[field].standing),
            Doubt::Pair { pair } => OpenPair::Own(self.pairs[pair].bodies),
            Doubt::Table { pair } => OpenPair::Own(self.tabled[pair].pair.bodies),
        })
    }

    /// The lanes in which nothing meets for certain.
    #[inline(always)]
    fn decide_lanes(&self, lanes: u16, doubts: &mut Doubts) -> u16 {
        self.chain.go_to(&doubts.values, &mut doubts.frames);
        doubts.doubts.clear();
        for (i, body) in self.bodies.iter().enumerate() {
            doubts.wholes[i] = doubts.frames[body.link].apply(&body.whole.centre);
        }
        let mut open = lanes;
        self.decide_tables(&mut open, doubts);
        self.decide_fields(&mut open, doubts);
        self.decide_pairs(&mut open, doubts);
        for (_, lanes) in &mut doubts.doubts {
            *lanes &= open;
        }
        open
    }

    #[inline(always)]
    fn decide_tables(&self, open: &mut u16, doubts: &mut Doubts) {
        for (i, pair) in self.tabled.iter().enumerate() {
            let Some(table) = self.bounds.tables.get(pair.table) else { continue };
            let [free, meet] = table.look_up(&doubts.values);
            *open &= !meet;
            let mut unsure = *open & !free;
            if unsure != 0 {
                unsure = self.decide_pair(&pair.pair, unsure, open, doubts);
            }
            if unsure != 0 {
                doubts.doubts.push((Doubt::Table { pair: i }, unsure));
            }
        }
    }

    #[inline(always)]
    fn decide_fields(&self, open: &mut u16, doubts: &mut Doubts) {
        for (f, field) in self.fields.iter().enumerate() {
            for asked in &field.asked {
                if let Some(table) = &asked.table {
                    let [free, meet] = table.look_up(&doubts.values);
                    *open &= !meet;
                    if *open & !free != 0 {
                        let doubt = Doubt::Field { field: f, body: asked.body };
                        doubts.doubts.push((doubt, *open & !free));
                    }
                    continue;
                }
                let body = &self.bodies[asked.body];
                let [far, _] = field.grid.look_up(&doubts.wholes[asked.body], &asked.whole);
                let (near, mut unsure) = (*open & !mask(&far), 0);
                for lane in lanes_of(near) {
                    let frame = doubts.frames[body.link].in_lane(lane);
                    match look_up(&field.grid, &frame, body, (&asked.coarse, &asked.fine)) {
                        Some(false) => {}
                        Some(true) => *open &= !(1 << lane),
                        None => unsure |= 1 << lane,
                    }
                }
                if unsure != 0 {
                    doubts.doubts.push((Doubt::Field { field: f, body: asked.body }, unsure));
                }
            }
        }
    }

    #[inline(always)]
    fn decide_pairs(&self, open: &mut u16, doubts: &mut Doubts) {
        for (i, pair) in self.pairs.iter().enumerate() {
            let unsure = self.decide_pair(pair, *open, open, doubts);
            if unsure != 0 {
                doubts.doubts.push((Doubt::Pair { pair: i }, unsure));
            }
        }
    }

    /// Removes lanes from `open` in which two bodies of the robot meet. Returns those of `asked` that are not certain.
    #[inline(always)]
    fn decide_pair(&self, pair: &BodyPair, asked: u16, open: &mut u16, doubts: &Doubts) -> u16 {
        let [a, b] = pair.bodies;
        let radii = [a, b].map(|body| &self.bodies[body].whole_radius);
        let far = are_apart((&doubts.wholes[a], radii[0]), (&doubts.wholes[b], radii[1]));
        let mut unsure = asked & !mask(&far);
        for SeenBody { bodies, coarse, fine } in &pair.seen {
            let [p, q] = bodies.map(|body| &self.bodies[body]);
            let Some((grid, _)) = &self.bounds.grids[bodies[0]] else { continue };
            for lane in lanes_of(unsure) {
                let [of_p, of_q] = [p, q].map(
                    #[inline(always)]
                    |body| doubts.frames[body.link].in_lane(lane),
                );
                match look_up(grid, &of_q.seen_from(&of_p), q, (coarse, fine)) {
                    Some(false) => unsure &= !(1 << lane),
                    Some(true) => {
                        unsure &= !(1 << lane);
                        *open &= !(1 << lane);
                    }
                    None => {}
                }
            }
        }
        unsure
    }
}

#[inline(always)]
fn lanes_of(mut lanes: u16) -> impl Iterator<Item = usize> {
    core::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = lanes.trailing_zeros() as usize;
            (lanes != 0).then(|| {
                lanes &= lanes - 1;
                lane
            })
        },
    )
}

/// Whether a body meets what a grid is around, if its spheres say so for certain. A part of the body that is in a coarse
/// sphere that is free needs no fine one.
#[inline(always)]
fn look_up(
    grid: &ClearanceGrid,
    frame: &OneFrame,
    body: &LaneBody,
    (coarse, fine): (&Radii16, &[Radii16]),
) -> Option<bool> {
    let [free, hit] = grid.look_up(&frame.apply(&body.coarse_centres), coarse);
    if mask(&hit) != 0 {
        return Some(true);
    }
    let mut needed = lanes_of(!mask(&free)).fold(0, |needed, sphere| needed | body.below[sphere]);
    let mut is_free = true;
    for (centres, radii) in body.fine_centres.iter().zip(fine) {
        let now = needed as u16;
        needed >>= LANES;
        if now == 0 {
            continue;
        }
        let [free, hit] = grid.look_up(&frame.apply(centres), radii);
        if mask(&hit) != 0 {
            return Some(true);
        }
        is_free &= now & !mask(&free) == 0;
    }
    is_free.then_some(false)
}
