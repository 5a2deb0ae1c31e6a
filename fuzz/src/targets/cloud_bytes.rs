//! Bytes that `from_bytes` accepts as a cloud are safe to search, and the cloud is what they say; bytes that it rejects
//! have the error that it reports. Clouds whose points are moved, inserted and removed hold the right points. Searches
//! find the same points as a loop over all points.
//!
//! An input that begins like a cloud is used as one. Of the others some are lists of changes to the bytes of a valid
//! cloud, and some are points and operations on them.

use crate::baked::{Buffer, change, copied, cut};
use crate::clouds::{
    clouds, held, is_safe_to_search, is_true, is_what_the_bytes_say, nodes_end, point, put, searches_agree,
};
use crate::{Input, Mode};
use simdop::cloud::{CLOUD_MAGIC, CloudError, CloudRef, PointCloud, buckets_for, nodes_for};
use simdop::construct::{Magnification, Splitter};
use simdop::hierarchy::{Aligned, FormatError};

/// One run.
pub fn run(data: &[u8]) {
    let mut buffer: Buffer = Aligned([0; _]);
    let mut input = Input::new(data);
    if data.starts_with(&CLOUD_MAGIC[..4]) {
        examine(copied(&mut buffer, data), &mut input);
    } else if input.one_in(2) {
        changed(&mut buffer, &mut input);
    } else {
        moved(&mut input);
    }
}

/// Makes up to four changes to a valid cloud.
fn changed(buffer: &mut Buffer, input: &mut Input) {
    let bytes = input.pick(clouds()).view().to_bytes();
    let (len, nodes_end) = (copied(buffer, &bytes).len(), nodes_end(&bytes));
    let bytes = &mut buffer.0[..len];
    for _ in 0..input.below(5) {
        let region = match input.u8() {
            0..32 => 0..64,
            32..128 => 64..nodes_end,
            _ => nodes_end..len,
        };
        change(bytes, &region, input, |bytes, at, input| put(bytes, at, nodes_end, input));
    }
    let size = cut(len, input);
    examine(&buffer.0[..size], input);
}

fn examine(bytes: &[u8], input: &mut Input) {
    match CloudRef::from_bytes(bytes) {
        Ok(view) => {
            is_what_the_bytes_say(&view, bytes);
            is_safe_to_search(&view, false);
            searches_agree(&view, input, Mode::Real);
            // The capacity of a cloud may exceed the available memory.
            if view.capacity() <= 4096 {
                may_be_owned(&view, bytes);
            }
        }
        Err(error) => {
            assert!(is_true(error, bytes), "{error:?}");
            assert!(!error.to_string().is_empty());
            assert_eq!(PointCloud::from_bytes(bytes).err(), Some(error));
        }
    }
}

/// Checks that it can be copied and then changed, unless two points have the same index.
fn may_be_owned(view: &CloudRef<'_>, bytes: &[u8]) {
    let all = held(view);
    let mut indices: Vec<_> = all.iter().map(|(index, _)| *index).collect();
    indices.sort_unstable();
    let twice = indices.windows(2).any(|pair| pair[0] == pair[1]);
    let mut cloud = match PointCloud::from_bytes(bytes) {
        Ok(cloud) => cloud,
        Err(error) => return assert!(twice && matches!(error, FormatError::Source { .. }), "{error:?}"),
    };
    assert!(!twice && cloud.view().to_bytes() == bytes);
    let mut model = vec![None; view.capacity()];
    all.iter().for_each(|&(index, p)| model[index as usize] = Some(p));
    let positions: Vec<_> = model.iter().map(|p| p.unwrap_or([f32::NAN; 3])).collect();
    assert!(cloud.refit(&positions).unwrap() >= 1.0);
    is_the_model(&cloud, &model, true);
    cloud.rebuild().unwrap();
    is_the_model(&cloud, &model, true);
}

/// Checks that the cloud holds the points of the model, which has one entry for each index.
fn is_the_model(cloud: &PointCloud, model: &[Option<[f32; 3]>], tight: bool) {
    let view = cloud.view();
    view.validate().unwrap();
    is_safe_to_search(&view, tight);
    let mut found = vec![None; view.capacity()];
    for (index, p) in held(&view) {
        assert!(found[index as usize].replace(p.map(f32::to_bits)).is_none(), "{index} twice");
    }
    assert!(
        found.iter().copied().eq(model.iter().map(|p| p.map(|p| p.map(f32::to_bits)))),
        "{found:?} {model:?}"
    );
    assert_eq!(view.len(), model.iter().flatten().count());
}

/// Builds a cloud and applies operations to it.
fn moved(input: &mut Input) {
    let mode = input.mode();
    let (n, room) = (input.below(160), input.below(20));
    let points: Vec<_> = (0..n).map(|_| point(input, mode)).collect();
    let bucket_size = 1 + input.below(16) as u32;
    let splitter = match input.below(16) {
        0 => Some(Splitter::LongestAxis),
        1 => Some(Splitter::SurfaceArea),
        2 => Some(Splitter::BatchNeuralGas { magnification: Magnification::None, seed: 1 }),
        _ => None,
    };
    let made = match splitter {
        Some(splitter) => PointCloud::split_by(&points, splitter, bucket_size),
        None => PointCloud::with_room(&points, bucket_size, n + room),
    };
    // Coincident points and numbers of very different size are split in halves: so few points never get too deep.
    let mut cloud = made.unwrap();
    let mut model: Vec<_> = points.into_iter().map(Some).collect();
    model.resize(cloud.view().capacity(), None);
    is_the_model(&cloud, &model, true);
    if splitter.is_none() {
        is_full(&cloud);
    }
    for _ in 0..input.below(12) {
        let tight = happen(&mut cloud, &mut model, input, mode);
        is_the_model(&cloud, &model, tight);
    }
    searches_agree(&cloud.view(), input, mode);
    let bytes = cloud.view().to_bytes();
    assert!(PointCloud::from_bytes(&bytes).unwrap().view().to_bytes() == bytes);
}

/// Applies one operation. Returns whether all boxes are tight afterwards.
fn happen(cloud: &mut PointCloud, model: &mut [Option<[f32; 3]>], input: &mut Input, mode: Mode) -> bool {
    let positions =
        |model: &[Option<[f32; 3]>]| -> Vec<_> { model.iter().map(|p| p.unwrap_or([f32::NAN; 3])).collect() };
    match input.below(8) {
        0 => {
            cloud.rebuild().unwrap();
            is_full(cloud);
            assert_eq!(cloud.refit(&positions(model)), Ok(1.0), "nothing moved");
            return true;
        }
        1 => {
            let all = 1 + input.below(4);
            for p in model.iter_mut().flatten() {
                if input.one_in(all) {
                    *p = point(input, mode);
                }
            }
            assert!(cloud.refit(&positions(model)).unwrap() >= 1.0);
            return true;
        }
        2 => {
            // Invalid input changes nothing.
            let mut wrong = positions(model);
            if let Some(at) = model.iter().position(Option::is_some) {
                wrong[at][1] = f32::INFINITY;
                assert_eq!(cloud.refit(&wrong), Err(CloudError::Point { index: at as u32 }));
            }
        }
        3..=5 => {
            for _ in 0..=input.below(8) {
                let index = input.below(model.len().clamp(1, 256));
                let had = model.get(index).copied().flatten();
                let removed = cloud.remove(index as u32);
                assert_eq!(removed.is_ok(), had.is_some(), "{removed:?}");
                if had.is_some() {
                    model[index] = None;
                }
            }
        }
        _ => {
            for _ in 0..=input.below(8) {
                let index = input.below(model.len().clamp(1, 256));
                let p = point(input, mode);
                match (cloud.insert(index as u32, p), model.get(index)) {
                    (Ok(()), Some(None)) => model[index] = Some(p),
                    (Err(CloudError::Full), Some(None))
                    | (Err(CloudError::Index { .. }), Some(Some(_)) | None) => {}
                    (result, had) => panic!("{result:?} of {had:?}"),
                }
            }
        }
    }
    false
}

/// Checks that all buckets but the last are as full as requested, and all nodes but one use all lanes.
fn is_full(cloud: &PointCloud) {
    let view = cloud.view();
    // An empty cloud with capacity has one bucket to insert into.
    let wanted = buckets_for(view.len().max(usize::from(view.capacity() > 0)), view.bucket_size());
    assert_eq!((view.buckets().len(), view.nodes().len()), (wanted, nodes_for(wanted)));
}
