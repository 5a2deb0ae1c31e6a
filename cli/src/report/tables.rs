//! The tables of the page.

use super::approach::DISTANCES;
use super::html::letter;
use super::results::{Results, short};
use crate::markup::escaped;
use core::fmt::Write;

/// One line per setting, the fastest first.
pub(super) fn settings(page: &mut String, results: &Results) {
    page.push_str(
        "<h2>All settings, the fastest first</h2>\n<table class=\"settings\">\n<thead>\n\
         <tr><th rowspan=\"2\">front</th>",
    );
    for (head, unit) in [
        ("k", ""),
        ("arity", ""),
        ("storage", ""),
        ("leaf", "triangles"),
        ("splitter", ""),
        ("normal slabs", ""),
        ("in all", "KiB"),
        ("a triangle", "bytes"),
        ("build", "ms"),
    ] {
        let _ = write!(page, "<th rowspan=\"2\">{head}<br/><small>{unit}</small></th>");
    }
    for (head, columns) in [
        ("overestimate<br/><small>mesh's unit</small>", 2),
        ("false positives<br/><small>a pose</small>", 4),
        ("median time<br/><small>µs</small>", 5),
    ] {
        let _ = write!(page, "<th colspan=\"{columns}\">{head}</th>");
    }
    page.push_str("</tr>\n<tr><th>mean</th><th>greatest</th>");
    for distance in DISTANCES.iter().chain(&DISTANCES) {
        let _ = write!(page, "<th>{distance}</th>");
    }
    page.push_str("<th>geo. mean</th></tr>\n</thead>\n<tbody>\n");
    let mut order: Vec<usize> = (0..results.settings.len()).collect();
    let time = |index: &usize| results.settings[*index].geometric_mean_microseconds;
    order.sort_by(|a, b| time(a).total_cmp(&time(b)));
    for index in order {
        let one = &results.settings[index];
        let (class, star) = match (results.recommended == Some(index), one.is_on_front) {
            (true, _) => (" class=\"best\"", "★"),
            (false, true) => (" class=\"front\"", "●"),
            (false, false) => ("", ""),
        };
        let setting = &one.setting;
        let _ = write!(
            page,
            "<tr{class}><td>{star}</td><td>{}</td><td>{}</td><td class=\"word\">{}</td><td>{}</td>\
             <td class=\"word\">{}</td><td>{}</td>",
            setting.node.k,
            setting.node.arity,
            setting.storage_name(),
            setting.leaf_size,
            setting.splitter_name(),
            if setting.has_normal_slabs { "yes" } else { "no" }
        );
        let kibibytes = one.bytes as f64 / 1024.0;
        let whole = [kibibytes, one.bytes_per_triangle, one.build_milliseconds];
        let overestimates = [one.overestimate_mean, one.overestimate_greatest];
        let false_positives = one.at.map(|at| at.false_positives);
        let times = one.at.map(|at| at.median_microseconds);
        let numbers = whole.iter().chain(&overestimates).chain(&false_positives).chain(&times);
        for number in numbers.chain([&one.geometric_mean_microseconds]) {
            let _ = write!(page, "<td>{}</td>", short(*number));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody>\n</table>\n<p>★ recommended, ● on the Pareto front.</p>\n");
}

/// One line per error.
pub(super) fn covers(page: &mut String, results: &Results) {
    page.push_str("<h2>Covers: coarser bodies for scenes</h2>\n\
        <p>Spheres that cover the mesh, none of whose points is farther from it than the error. If they are \
         free, so are the meshes; if they meet, the meshes are nearer than the sum of both errors. <code>simdop \
         cover MESH --error LENGTH -o TREE</code>. For closed meshes as solids, <code>--solid</code> gives covers \
         with fewer spheres, which include the inside.</p>\n\
         <table>\n<thead>\n<tr><th>error<br/><small>mesh's unit</small></th><th>spheres</th><th>in \
         all<br/><small>KiB</small></th><th>build<br/><small>ms</small></th>");
    for distance in DISTANCES {
        let _ = write!(
            page,
            "<th>{distance}<br/><small>hits</small></th><th>{distance}<br/><small>µs</small></th>"
        );
    }
    page.push_str("</tr>\n</thead>\n<tbody>\n");
    for one in &results.covers {
        let [error, kibibytes, build] =
            [one.error, one.bytes as f64 / 1024.0, one.build_milliseconds].map(short);
        let _ =
            write!(page, "<tr><td>{error}</td><td>{}</td><td>{kibibytes}</td><td>{build}</td>", one.spheres);
        for at in &one.at {
            let _ = write!(page, "<td>{}</td><td>{}</td>", at.hits, short(at.median_microseconds));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody>\n</table>\n");
}

/// One line per number of spheres.
pub(super) fn packings(page: &mut String, results: &Results) {
    if results.packed().is_empty() {
        return;
    }
    page.push_str(
        "<h2>All packings</h2>\n<table>\n<thead>\n<tr><th>spheres</th><th>not covered<br/><small>% of \
        volume</small></th><th>in all<br/><small>KiB</small></th>",
    );
    for distance in DISTANCES {
        let _ = write!(
            page,
            "<th>{distance}<br/><small>pairs</small></th><th>{distance}<br/><small>µs</small></th>"
        );
    }
    page.push_str("</tr>\n</thead>\n<tbody>\n");
    for one in results.packed() {
        let (error, kibibytes) = (short(100.0 * one.volume_error), short(one.bytes as f64 / 1024.0));
        let _ = write!(page, "<tr><td>{}</td><td>{error}</td><td>{kibibytes}</td>", one.spheres);
        for at in &one.at {
            let _ = write!(page, "<td>{}</td><td>{}</td>", short(at.pairs), short(at.median_microseconds));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody>\n</table>\n");
}

/// One line per library.
pub(super) fn peers(page: &mut String, results: &Results) {
    if results.peers.is_empty() {
        return;
    }
    page.push_str(
        "<h2>Other libraries</h2>\n<p>From a results.csv of benches/peers: measured at another time, at other poses \
         with the same distances.</p>\n<table>\n<thead>\n<tr><th></th><th>library</th><th>a \
        triangle<br/><small>bytes</small></th><th>build<br/><small>ms</small></th>",
    );
    for distance in DISTANCES {
        let _ = write!(page, "<th>{distance}<br/><small>µs</small></th>");
    }
    page.push_str("</tr>\n</thead>\n<tbody>\n");
    let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), short);
    for (index, peer) in results.peers.iter().enumerate() {
        let (library, bytes) = (escaped(&peer.library), cell(peer.bytes_per_triangle));
        let _ = write!(
            page,
            "<tr><td>{}</td><td class=\"word\">{library}</td><td>{bytes}</td><td>{}</td>",
            letter(index),
            short(peer.build_milliseconds)
        );
        for time in peer.median_microseconds {
            let _ = write!(page, "<td>{}</td>", cell(time));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody>\n</table>\n");
}
