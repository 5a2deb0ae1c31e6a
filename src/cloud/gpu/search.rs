//! Searches on a device.

use super::super::packet::Asking;
use super::super::store::is_finite;
use super::super::{CloudRef, List, Queries, Radii, RangeSearch, SearchError, Seat};
use super::memory::{CloudBinding, DeviceMemory, SearchData};
use super::shader::{CloudShader, ENDLESS, NO_BUCKET, UNSURE, WORKGROUP};
use super::{Clock, DeviceCloud, DeviceCloudError, DeviceTimes, LEAST_SQUARE, is_in_range};
use crate::device::DeviceError;
use crate::isa::{Isa, Scalar};
use crate::node::Bucket;
use alloc::vec;
use alloc::vec::Vec;
use std::time::Instant;

/// Maximum number of packets per submission: the system may stop a device that works too long on one.
const PACKETS_AT_ONCE: usize = 1 << 16;

/// The queries of a search, in the device's memory.
pub(super) struct Asked {
    data: SearchData,
    pub(super) packets: usize,
    /// Indices of the sixteen queries of each packet; [`Bucket::UNUSED`] for none.
    pub(super) queries: Vec<[u32; 16]>,
}

/// Splits seats into packets of up to sixteen queries that share a bucket: first seat and count.
fn packets_of(seats: &[Seat]) -> Vec<[u32; 2]> {
    let mut packets = Vec::new();
    for (first, shared) in runs(seats) {
        for start in (0..shared).step_by(16) {
            packets.push([(first + start) as u32, (shared - start).min(16) as u32]);
        }
    }
    packets
}

/// The start and length of each run of seats with the same bucket.
fn runs(seats: &[Seat]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let mut first = 0;
    seats.chunk_by(|a, b| a.bucket == b.bucket).map(move |run| {
        first += run.len();
        (first - run.len(), run.len())
    })
}

fn ask_of(point: [f32; 3], query: u32) -> [u32; 4] {
    let [x, y, z] = point.map(f32::to_bits);
    [x, y, z, query]
}

impl DeviceCloud<'_> {
    /// Packs queries that are not points of the cloud, as [`RangeSearch::seat`], finding the buckets on the device.
    /// The seats are the same, so the result can also be searched on the CPU.
    ///
    /// # Errors
    /// [`DeviceCloudError::Search`] as there, [`DeviceCloudError::Range`], [`DeviceCloudError::Device`].
    pub fn seat<'a>(
        &mut self,
        points: &'a [[f32; 3]],
        seats: &'a mut [Seat],
    ) -> Result<(Queries<'a>, DeviceTimes), DeviceCloudError> {
        let have = seats.len();
        let Some(seats) = seats.get_mut(..points.len()) else {
            return Err(SearchError::Length { what: "seats", have, need: points.len() }.into());
        };
        if let Some(query) = points.iter().position(|point| !is_finite(*point)) {
            return Err(SearchError::Query { query: query as u32 }.into());
        }
        check_range(points)?;
        let mut clock = Clock(Instant::now());
        let asks: Vec<[u32; 4]> =
            points.iter().zip(0..).map(|(point, query)| ask_of(*point, query)).collect();
        let data = SearchData { count: asks.len() as u32, ..SearchData::default() };
        self.memory.write(self.gpu, CloudBinding::Asks, &asks)?;
        self.memory.write(self.gpu, CloudBinding::Search, &[data])?;
        self.memory.make_room(self.gpu, CloudBinding::Seats, asks.len())?;
        self.arrive()?;
        let upload = clock.lap();
        self.submit(&[(CloudShader::Seat, 0, asks.len().div_ceil(WORKGROUP as usize))])?;
        let device = clock.lap();
        let mut buckets = vec![0; asks.len()];
        self.memory.read(self.gpu, CloudBinding::Seats, 0, &mut buckets)?;
        for ((seat, bucket), query) in seats.iter_mut().zip(buckets).zip(0..) {
            *seat = Seat { bucket, query };
        }
        self.find_unsure(points, seats)?;
        seats.sort_unstable();
        let times = DeviceTimes { upload, device, download: clock.lap() };
        Ok((Queries(Asking::Others { points, seats }), times))
    }

    /// Finds the seats that the device left [`UNSURE`].
    fn find_unsure(&mut self, points: &[[f32; 3]], seats: &mut [Seat]) -> Result<(), DeviceCloudError> {
        if seats.iter().all(|seat| seat.bucket != UNSURE) {
            return Ok(());
        }
        let nodes = self.nodes()?;
        let cloud = CloudRef { nodes: &nodes, buckets: &[], points: 0, capacity: 0, bucket_size: 0 };
        let search = RangeSearch::new(Isa::Scalar(Scalar::new()));
        for seat in seats.iter_mut().filter(|seat| seat.bucket == UNSURE) {
            let (query, point) = (seat.query, points[seat.query as usize]);
            search.find_buckets(&cloud, &[point], core::slice::from_mut(seat));
            seat.query = query;
        }
        Ok(())
    }

    /// Counts the neighbours of each query: [`RangeSearch::count`].
    ///
    /// # Errors
    /// [`DeviceCloudError`].
    pub fn count(
        &mut self,
        queries: &Queries<'_>,
        radii: Radii<'_>,
        counts: &mut [u32],
    ) -> Result<DeviceTimes, DeviceCloudError> {
        self.check(queries, &radii, "counts", counts.len())?;
        let mut clock = Clock(Instant::now());
        let asked = self.ask(queries, &radii)?;
        let upload = clock.lap();
        self.run_packets(CloudShader::Count, &asked, 0..asked.packets, 0)?;
        let device = clock.lap();
        let mut found = vec![[0_u32; 16]; asked.packets];
        self.memory.read(self.gpu, CloudBinding::Counts, 0, &mut found)?;
        for (&query, &count) in asked.queries.as_flattened().iter().zip(found.as_flattened()) {
            if count == ENDLESS {
                return Err(DeviceCloudError::Endless { query });
            }
            if query != Bucket::UNUSED {
                counts[query as usize] = count;
            }
        }
        Ok(DeviceTimes { upload, device, download: clock.lap() })
    }

    /// The neighbours of each query: [`RangeSearch::fill`], with the same lists and indices.
    ///
    /// # Errors
    /// [`DeviceCloudError`]. As there, [`SearchError::Buffer`] gives the required size, and all lists have their
    /// lengths.
    pub fn fill(
        &mut self,
        queries: &Queries<'_>,
        radii: Radii<'_>,
        lists: &mut [List],
        indices: &mut [u32],
    ) -> Result<DeviceTimes, DeviceCloudError> {
        self.check(queries, &radii, "lists", lists.len())?;
        let mut clock = Clock(Instant::now());
        let asked = self.ask(queries, &radii)?;
        let mut times = DeviceTimes { upload: clock.lap(), ..DeviceTimes::default() };
        self.run_packets(CloudShader::Count, &asked, 0..asked.packets, 0)?;
        let groups = asked.packets.div_ceil(WORKGROUP as usize);
        self.submit(&[
            (CloudShader::Scan, 0, groups),
            (CloudShader::ScanTotals, 0, groups.min(1)),
            (CloudShader::WriteLists, 0, (16 * asked.packets).div_ceil(WORKGROUP as usize)),
        ])?;
        times.device = clock.lap();
        let total = self.read_lists(&asked, lists)?;
        times.download = clock.lap();
        let have = indices.len();
        if total > have as u64 || total > u64::from(u32::MAX) {
            return Err(SearchError::Buffer { have, need: total }.into());
        }
        for (packets, start, count) in self.batches(&asked, total as usize)? {
            self.memory.make_room(self.gpu, CloudBinding::Indices, count)?;
            times.download += clock.lap();
            self.run_packets(CloudShader::Fill, &asked, packets, start)?;
            times.device += clock.lap();
            self.memory.read(self.gpu, CloudBinding::Indices, 0, &mut indices[start..start + count])?;
            times.download += clock.lap();
        }
        Ok(times)
    }

    fn check(
        &self,
        queries: &Queries<'_>,
        radii: &Radii<'_>,
        what: &'static str,
        have: usize,
    ) -> Result<(), DeviceCloudError> {
        let need = self.room(queries);
        if have < need {
            return Err(SearchError::Length { what, have, need }.into());
        }
        radii.check(need)?;
        Ok(())
    }

    /// The required length of the results.
    fn room(&self, queries: &Queries<'_>) -> usize {
        match &queries.0 {
            Asking::Own(_) => self.capacity,
            Asking::Others { points, .. } => points.len(),
        }
    }

    /// Writes the queries to the device, and allocates the counts.
    pub(super) fn ask(
        &mut self,
        queries: &Queries<'_>,
        radii: &Radii<'_>,
    ) -> Result<Asked, DeviceCloudError> {
        let gpu = self.gpu;
        let mut data = SearchData { own: NO_BUCKET, ..SearchData::default() };
        let members = match &queries.0 {
            Asking::Own(range) => {
                let end = range.end.min(self.members.len());
                data.own = range.start.min(end) as u32;
                self.members[range.start.min(end)..end].to_vec()
            }
            Asking::Others { points, seats } => {
                check_range(points)?;
                let ask = |seat: &Seat| ask_of(points[seat.query as usize], seat.query);
                let packets = packets_of(seats);
                self.memory.write(gpu, CloudBinding::Asks, &seats.iter().map(ask).collect::<Vec<_>>())?;
                self.memory.write(gpu, CloudBinding::Packets, &packets)?;
                let members = |[first, count]: &[u32; 2]| {
                    let own = &seats[*first as usize..(first + count) as usize];
                    core::array::from_fn(|slot| own.get(slot).map_or(Bucket::UNUSED, |seat| seat.query))
                };
                packets.iter().map(members).collect()
            }
        };
        data.count = members.len() as u32;
        data.each = u32::from(matches!(radii, Radii::Each(_)));
        let queries_asked = members.as_flattened().iter().copied().filter(|query| *query != Bucket::UNUSED);
        let is_small = |query: &u32| radii.square(*query) < LEAST_SQUARE;
        if let Some(query) = queries_asked.filter(is_small).min() {
            return Err(DeviceCloudError::Radius { query });
        }
        let squares: Vec<f32> = match radii {
            Radii::Same(_) => vec![radii.square(0)],
            Radii::Each(_) => (0..self.room(queries) as u32).map(|query| radii.square(query)).collect(),
        };
        self.memory.write(gpu, CloudBinding::Squares, &squares)?;
        for binding in [CloudBinding::Counts, CloudBinding::Starts] {
            self.memory.make_room(gpu, binding, members.len())?;
        }
        self.memory.make_room(gpu, CloudBinding::Totals, members.len().div_ceil(WORKGROUP as usize))?;
        self.memory.make_room(gpu, CloudBinding::Lists, self.room(queries))?;
        self.memory.write(gpu, CloudBinding::Search, &[data])?;
        self.arrive()?;
        Ok(Asked { data, packets: members.len(), queries: members })
    }

    /// Runs a kernel over some packets, in several submissions. `start` is where the lists of the first packet begin.
    pub(super) fn run_packets(
        &mut self,
        kernel: CloudShader,
        asked: &Asked,
        packets: core::ops::Range<usize>,
        start: usize,
    ) -> Result<(), DeviceError> {
        for first in packets.clone().step_by(PACKETS_AT_ONCE) {
            let count = (packets.end - first).min(PACKETS_AT_ONCE);
            let data = SearchData {
                first_packet: first as u32,
                packets: count as u32,
                start: start as u32,
                ..asked.data
            };
            self.memory.write(self.gpu, CloudBinding::Search, &[data])?;
            self.submit(&[(kernel, 0, count)])?;
        }
        Ok(())
    }

    /// Reads the lists of all queries. Returns the total number of neighbours.
    fn read_lists(&mut self, asked: &Asked, lists: &mut [List]) -> Result<u64, DeviceCloudError> {
        let queries = asked.queries.as_flattened();
        let room = queries.iter().filter(|query| **query != Bucket::UNUSED).max();
        let mut found = vec![[0_u32; 2]; room.map_or(0, |last| *last as usize + 1)];
        self.memory.read(self.gpu, CloudBinding::Lists, 0, &mut found)?;
        let mut total = 0;
        for &query in queries.iter().filter(|query| **query != Bucket::UNUSED) {
            let [start, count] = found[query as usize];
            if count == ENDLESS {
                return Err(DeviceCloudError::Endless { query });
            }
            lists[query as usize] = List { start, count };
            total += u64::from(count);
        }
        Ok(total)
    }

    /// Splits the packets into batches whose neighbours fit into one buffer: packets, start of the lists of the
    /// first, and number of neighbours.
    fn batches(
        &mut self,
        asked: &Asked,
        total: usize,
    ) -> Result<Vec<(core::ops::Range<usize>, usize, usize)>, DeviceCloudError> {
        let most = DeviceMemory::most(self.gpu, CloudBinding::Indices);
        if total == 0 {
            return Ok(Vec::new());
        }
        if total <= most {
            return Ok(vec![(0..asked.packets, 0, total)]);
        }
        let mut starts = vec![[0_u32; 16]; asked.packets];
        self.memory.read(self.gpu, CloudBinding::Starts, 0, &mut starts)?;
        let start = |packet: usize| starts.get(packet).map_or(total, |starts| starts[0] as usize);
        let (mut batches, mut first) = (Vec::new(), 0);
        while first < asked.packets {
            let mut end = first + 1;
            while end < asked.packets && start(end + 1) - start(first) <= most {
                end += 1;
            }
            // If one packet alone exceeds the buffer, its allocation fails with the right error.
            batches.push((first..end, start(first), start(end) - start(first)));
            first = end;
        }
        Ok(batches)
    }
}

fn check_range(points: &[[f32; 3]]) -> Result<(), DeviceCloudError> {
    match points.iter().position(|point| !is_in_range(*point)) {
        Some(index) => Err(DeviceCloudError::Range { what: "query", index: index as u32 }),
        None => Ok(()),
    }
}
