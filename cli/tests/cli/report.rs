//! `simdop report`, run as a user runs it: the contents of its files, that they are reproducible, and what it
//! rejects.

use crate::folder::Folder;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// An octahedron whose triangles are cut into four `cuts` times, projected onto a slender ellipsoid: covers of the
/// report have as many spheres as its surface is large.
fn egg(cuts: u32) -> String {
    let (mut vertices, mut triangles): (Vec<[f64; 3]>, Vec<[usize; 3]>) = (Vec::new(), Vec::new());
    let sides = 1_usize << cuts;
    let mut known = BTreeMap::new();
    let mut vertex = |p: [f64; 3]| {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        let key = p.map(|x| (x / length * 1e9).round() as i64);
        *known.entry(key).or_insert_with(|| {
            vertices.push([0.3 * p[0] / length, 0.3 * p[1] / length, 1.5 * p[2] / length]);
            vertices.len()
        })
    };
    for signs in 0..8_u32 {
        let sign = |axis: u32| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let mut at = |i: usize, j: usize| {
            let share = |n: usize| n as f64 / sides as f64;
            vertex([sign(0) * share(i), sign(1) * share(j), sign(2) * share(sides - i - j)])
        };
        let mut found = Vec::new();
        for (i, j) in (0..sides).flat_map(|i| (0..sides - i).map(move |j| (i, j))) {
            found.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 2 <= sides {
                found.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        // An odd number of negative signs mirrors the triangle.
        let is_mirrored = signs.count_ones() % 2 == 1;
        triangles.extend(found.iter().map(|&[a, b, c]| if is_mirrored { [a, c, b] } else { [a, b, c] }));
    }
    let mut text = String::new();
    vertices.iter().for_each(|[x, y, z]| text += &format!("v {x:?} {y:?} {z:?}\n"));
    triangles.iter().for_each(|[a, b, c]| text += &format!("f {a} {b} {c}\n"));
    text
}

/// A quick report: few poses, and few spheres unless an option says otherwise.
fn quick<'a>(rest: &[&'a str]) -> Vec<&'a str> {
    let spheres: &[&str] = if rest.contains(&"--spheres") { &[] } else { &["--spheres", "20"] };
    [&["report", "--poses", "6"], spheres, rest].concat()
}

fn read(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.0.join(name)).unwrap()
}

type Record = BTreeMap<String, String>;

fn records(csv: &str) -> Vec<Record> {
    csv::Reader::from_reader(csv.as_bytes()).deserialize().map(Result::unwrap).collect()
}

fn number(record: &Record, column: &str) -> f64 {
    let number: f64 = record[column].parse().unwrap_or_else(|_| panic!("{column} of {record:?}"));
    assert!(number.is_finite() && number >= 0.0, "{column} of {record:?}");
    number
}

const DISTANCES: [&str; 4] = ["1 % deep", "0 %", "1 %", "5 %"];

#[test]
fn the_built_in_scene_needs_no_file() {
    let folder = Folder::new("report_built_in");
    let (code, error) = folder.fate(&["report", "--poses", "2", "--spheres", "10"]);
    assert_eq!((code, error.as_str()), (0, ""));
    let names: BTreeSet<_> =
        std::fs::read_dir(&folder.0).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["report.csv", "report.html"].map(Into::into).into());
    assert!(read(&folder, "report.html").contains("torus knot (built in) against gear ring (built in)"));
}

#[test]
fn what_repeats_repeats() {
    let folder = Folder::new("report_repeats");
    folder.write("egg.obj", egg(2));
    let digest = |rest: &[&str]| {
        let report = folder.json(&quick(&[&["egg.obj"], rest].concat()));
        report["digest"].as_str().unwrap().to_owned()
    };
    let first = digest(&["-o", "a.html"]);
    assert_eq!(first.len(), 16);
    assert_eq!(first, digest(&["-o", "b.html", "--flash", "1", "--error", "0"]));
    assert_eq!(first, digest(&["--isa", "scalar"]));
    assert_ne!(first, digest(&["--seed", "2"]));
    assert_ne!(first, digest(&["--spheres", "0"]));
    for page in ["a.html", "b.html"] {
        assert!(read(&folder, page).contains(&first), "{page}");
    }
    // The CSV files are equal, too, except for the measured times.
    let repeatable = |csv: &str| -> Vec<Record> {
        let mut records = records(&read(&folder, csv));
        for record in &mut records {
            record.retain(|column, _| {
                !["build_ms", "median_us", "p99_us", "is_on_front"].contains(&column.as_str())
            });
        }
        records
    };
    assert_eq!(repeatable("a.csv"), repeatable("b.csv"));
}

#[test]
fn the_csv_holds_every_setting_at_every_distance() {
    let folder = Folder::new("report_csv");
    folder.write("egg.obj", egg(2));
    let report = folder.json(&quick(&["egg.obj", "--csv", "other.csv"]));
    let records = records(&read(&folder, "other.csv"));
    let trees: Vec<&Record> = records.iter().filter(|record| record["kind"] == "tree").collect();
    assert_eq!(trees.len(), 45 * DISTANCES.len());
    let of_storage = |storage: &str| trees.iter().filter(|record| record["storage"] == storage).count();
    assert_eq!([of_storage("fixed"), of_storage("half")], [33, 12].map(|count| count * DISTANCES.len()));
    // The two storages of a setting have trees of one size, and k-DOPs that differ.
    for half in trees.iter().filter(|record| record["storage"] == "half") {
        let same = ["k", "arity", "leaf_size", "splitter", "normal_slabs", "distance"];
        let is_twin = |record: &&&Record| {
            record["storage"] == "fixed" && same.iter().all(|column| record[*column] == half[*column])
        };
        let fixed = trees.iter().find(is_twin).unwrap();
        assert_eq!(half["bytes"], fixed["bytes"], "{half:?}");
        assert_ne!(half["overestimate_mean"], fixed["overestimate_mean"], "{half:?}");
    }
    let mut costs = Vec::new();
    for of_setting in trees.chunks_exact(DISTANCES.len()) {
        let mut logarithms = 0.0;
        for (record, distance) in of_setting.iter().zip(DISTANCES) {
            assert_eq!(record["distance"], distance);
            let of = |column| number(record, column);
            assert_eq!(of("hits"), of_same(&trees, distance, "hits"), "verdicts are exact: {record:?}");
            if of("hits") == 0.0 {
                assert_eq!(of("false_positives"), of("leaf_pairs"), "{record:?}");
            } else {
                assert!(of("false_positives") < of("leaf_pairs"), "{record:?}");
            }
            assert!(of("overestimate_mean") <= of("overestimate_greatest"), "{record:?}");
            assert!((of("bytes") - 128.0 * of("bytes_per_triangle")).abs() < 1e-6, "{record:?}");
            assert!(of("median_us") > 0.0 && of("median_us") <= of("p99_us"), "{record:?}");
            assert!(of("build_ms") > 0.0 && of("visits") > 0.0, "{record:?}");
            logarithms += of("median_us").ln();
        }
        let first = of_setting[0];
        let time = (logarithms / DISTANCES.len() as f64).exp();
        let cost = [time, number(first, "overestimate_greatest"), number(first, "bytes")];
        costs.push((cost, first["is_on_front"] == "true"));
    }
    assert_eq!(number(trees[0], "hits"), 6.0, "deep");
    assert_eq!(number(trees[3], "hits"), 0.0, "5 %");
    let beats = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|i| a[i] <= b[i]) && a != b;
    for (cost, is_on_front) in &costs {
        assert_eq!(*is_on_front, !costs.iter().any(|(other, _)| beats(other, cost)), "{cost:?}");
    }
    assert!((2..45).contains(&costs.iter().filter(|(_, is_on_front)| *is_on_front).count()));
    let covers: Vec<&Record> = records.iter().filter(|record| record["kind"] == "cover").collect();
    assert_eq!(covers.len(), 3 * DISTANCES.len());
    for of_cover in covers.chunks_exact(DISTANCES.len()) {
        let error = &of_cover[0]["cover_error"];
        let made = folder.json(&["cover", "egg.obj", "--error", error, "-o", "egg.cover"]);
        for (record, distance) in of_cover.iter().zip(DISTANCES) {
            assert_eq!(record["distance"], distance);
            for column in ["spheres", "bytes"] {
                assert_eq!(number(record, column), made[column].as_f64().unwrap(), "{record:?}");
            }
            let exact = of_same(&trees, distance, "hits");
            assert!((exact..=6.0).contains(&number(record, "hits")), "no hit is missed: {record:?}");
        }
        assert_eq!(number(of_cover[1], "hits"), 6.0, "what nearly touches is nearer than the error");
    }
    assert_eq!(number(covers[3], "hits"), 6.0, "5 % apart, within two errors of 5 %");
    assert_eq!(number(covers[11], "hits"), 0.0, "5 % apart, beyond two errors of 1 %");
    let packings: Vec<&Record> = records.iter().filter(|record| record["kind"] == "packing").collect();
    assert_eq!(packings.len(), 2 * DISTANCES.len(), "of 10 and 20 spheres");
    let [ten, twenty] = [packings[0], packings[4]].map(|record| number(record, "volume_error"));
    assert!(0.05 < twenty && twenty < ten && ten < 0.6, "{twenty} and {ten}");
    assert_eq!(report["settings"].as_array().unwrap().len(), 45);
    assert_eq!(report["settings"][0]["bytes"].as_f64().unwrap(), number(trees[0], "bytes"));
}

fn of_same(trees: &[&Record], distance: &str, column: &str) -> f64 {
    number(trees.iter().find(|record| record["distance"] == distance).unwrap(), column)
}

#[test]
fn what_is_recommended_keeps_to_the_limits() {
    let folder = Folder::new("report_limits");
    folder.write("egg.obj", egg(2));
    let ask = |rest: &[&str]| -> (Option<Value>, String) {
        let report = folder.json(&quick(&[&["egg.obj"], rest].concat()));
        let chosen = report["recommended"].as_u64().map(|index| report["settings"][index as usize].clone());
        let sentence = report["recommendation"].as_str().unwrap().to_owned();
        assert!(read(&folder, "report.html").contains(&sentence), "{sentence}");
        (chosen, sentence)
    };
    let (free, sentence) = ask(&[]);
    let free = free.unwrap();
    assert!(sentence.starts_with(&format!(
        "Without a limit on error or flash, take {}",
        free["setting"].as_str().unwrap()
    )));
    // The page has the command that builds the recommended tree.
    let page = read(&folder, "report.html");
    let command =
        page.split_once("<code>simdop build MESH -o TREE ").unwrap().1.split_once("</code>").unwrap().0;
    let arguments: Vec<&str> =
        ["build", "egg.obj", "-o", "egg.simdop"].into_iter().chain(command.split(' ')).collect();
    assert_eq!(folder.fate(&arguments), (0, String::new()));
    assert_eq!(
        std::fs::read(folder.0.join("egg.simdop")).unwrap().len() as u64,
        free["bytes"].as_u64().unwrap()
    );
    let storage = match folder.json(&["info", "egg.simdop"])["storage"].as_str() {
        Some("half") => "half floats",
        _ => "fixed point",
    };
    assert!(sentence.contains(storage), "{sentence}");

    let report = folder.json(&quick(&["egg.obj"]));
    let least = |key: &str| {
        let all = report["settings"].as_array().unwrap().iter();
        all.map(|one| one[key].as_f64().unwrap()).fold(f64::INFINITY, f64::min)
    };
    let (bytes, error) = (least("bytes") * 1.2, least("overestimate_greatest") * 1.01);
    let (small, _) = ask(&["--flash", &format!("{bytes:.0}")]);
    assert!(small.unwrap()["bytes"].as_f64().unwrap() <= bytes);
    let (tight, sentence) = ask(&["--error", &error.to_string()]);
    assert!(tight.unwrap()["overestimate_greatest"].as_f64().unwrap() <= error);
    assert!(sentence.contains(&format!("stick out by at most {error}")), "{sentence}");
    let cover = &report["covers"][1];
    let (bytes, within) = (cover["bytes"].to_string(), cover["error"].to_string());
    let spheres = format!(" take {bytes} bytes and ");
    let (_, sentence) = ask(&["--error", &within]);
    assert!(
        sentence.contains("Spheres that cover the mesh within ") && sentence.contains(&spheres),
        "{sentence}"
    );
    let (_, sentence) =
        ask(&["--error", &within, "--flash", &(cover["bytes"].as_u64().unwrap() - 1).to_string()]);
    assert!(!sentence.contains("Spheres"), "{sentence}");
    let (none, sentence) = ask(&["--flash", "100", "--error", "0.5"]);
    assert_eq!(none, None);
    let smallest = format!("there is no setting: the smallest takes {} bytes", least("bytes"));
    assert!(sentence.contains(&smallest), "{sentence}");
}

#[test]
fn the_page_stands_alone() {
    let folder = Folder::new("report_page");
    let name = "a<b&\"c\".obj";
    folder.write(name, egg(2));
    let csv = "mesh,triangles_a,triangles_b,distance,library,build_ms,bytes_per_triangle,median_us
m,128,128,0 %,Peer <1>,1.5,77,12.5
m,128,128,5 %,Peer <1>,1.5,77,0.5
m,128,128,0 %,simdop k 18,1,70,5
m,129,128,0 %,Another,1,70,5
";
    folder.write("peers.csv", csv);
    assert_eq!(folder.fate(&quick(&[name, "--peers", "peers.csv"])), (0, String::new()));
    let page = read(&folder, "report.html");
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..roxmltree::ParsingOptions::default() };
    let document = roxmltree::Document::parse_with_options(&page, options).unwrap();
    let elements = || document.descendants().filter(roxmltree::Node::is_element);
    for element in elements() {
        let tag = element.tag_name().name();
        assert!(!["script", "link", "img", "iframe", "image", "use"].contains(&tag), "{tag}");
        for attribute in element.attributes() {
            assert!(!["src", "href", "style"].contains(&attribute.name()), "{attribute:?}");
        }
    }
    let style = elements().find(|element| element.has_tag_name("style")).unwrap().text().unwrap();
    assert!(
        style.contains("prefers-color-scheme: dark") && !style.contains("url(") && !style.contains("@import")
    );
    let without_namespace = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    assert!(!without_namespace.contains("http:") && !without_namespace.contains("https:"));

    let tables: Vec<_> = elements().filter(|element| element.has_tag_name("table")).collect();
    let rows = |table: &roxmltree::Node<'_, '_>| {
        table
            .descendants()
            .filter(|node| {
                node.has_tag_name("td") && node.parent().unwrap().first_element_child() == Some(*node)
            })
            .count()
    };
    assert_eq!(tables.iter().map(rows).collect::<Vec<_>>(), [45, 3, 2, 1]);
    let plots: Vec<String> = elements()
        .filter(|element| element.attribute("width") == Some("2400"))
        .map(|plot| plot.descendants().filter_map(|node| node.text()).collect())
        .collect();
    assert_eq!(plots.len(), 6, "five quantities and the packings");
    for plot in &plots {
        assert!(DISTANCES.iter().all(|distance| plot.contains(distance)) && plot.contains("median time, µs"));
    }
    // The two storages have shapes of their own, and a definition.
    let text: String = document.descendants().filter_map(|node| node.text()).collect();
    assert!(["fixed point, arity 16", "half floats", "Storage"].iter().all(|part| text.contains(part)));
    assert!(!text.contains("half floats, another splitter"), "which is only in the full sweep");
    let heading = elements().find(|element| element.has_tag_name("h1")).unwrap();
    assert_eq!(heading.text(), Some(&*format!("simdop report: {name}")));
    let after = heading.next_sibling_element().unwrap();
    assert_eq!(after.attribute("class"), Some("recommendation"));

    let records = records(&read(&folder, "report.csv"));
    let peers: Vec<_> = records.iter().filter(|record| record["kind"] == "peer").collect();
    assert_eq!(peers.len(), 4);
    assert!(peers.iter().all(|record| record["library"] == "Peer <1>"));
    assert_eq!(
        peers.iter().map(|record| record["median_us"].as_str()).collect::<Vec<_>>(),
        ["", "12.5", "", "0.5"]
    );
}

/// A tree in place of a mesh, beside a mesh.
#[test]
fn trees_are_taken_for_their_meshes() {
    let folder = Folder::new("report_trees");
    folder.write("egg.obj", egg(2));
    folder.write("other.obj", egg(1));
    assert_eq!(folder.fate(&["build", "egg.obj", "-o", "egg.simdop", "-k", "18", "-a", "4"]).0, 0);
    let [of_mesh, of_tree] =
        ["egg.obj", "egg.simdop"].map(|body| folder.json(&quick(&[body, "other.obj", "--spheres", "0"])));
    assert_eq!(of_mesh["digest"], of_tree["digest"]);
    let triangles: Vec<_> = of_tree["subjects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|body| body["triangles"].as_u64().unwrap())
        .collect();
    assert_eq!(triangles, [128, 32]);
}

#[test]
fn a_mesh_that_is_open_has_no_packings() {
    let folder = Folder::new("report_open");
    let egg = egg(2);
    folder.write("open.obj", egg.trim_end().rsplit_once('\n').unwrap().0.to_owned() + "\n");
    assert_eq!(folder.fate(&quick(&["open.obj"])), (0, String::new()));
    assert!(read(&folder, "report.html").contains("<p>There are none: open.obj: "));
    assert!(!read(&folder, "report.csv").contains("packing"));
}

#[test]
fn what_cannot_be_reported_is_an_error_and_leaves_the_files() {
    let folder = Folder::new("report_errors");
    folder.write("egg.obj", egg(1));
    folder.write("point.obj", "v 1 1 1\nf 1 1 1\n");
    folder.write("none.obj", "v 0 0 0\n");
    folder.write("peers.csv", "mesh,distance\nm,1\n");
    folder.write("report.html", "old");
    let refused = |arguments: &[&str], want: &str| {
        let (code, error) = folder.fate(&quick(arguments));
        assert!(code == 2 && error.contains(want), "{arguments:?}: {code}, {error}");
        assert_eq!(read(&folder, "report.html"), "old");
        assert!(!folder.0.join("report.csv").exists());
    };
    refused(&["missing.obj"], "simdop: missing.obj: No such file");
    refused(&["none.obj"], "simdop: none.obj: there is no triangle in the file");
    refused(&["point.obj"], "simdop: point.obj: all corners are one point");
    refused(&["egg.obj", "-o", "egg.obj"], "simdop: --output: egg.obj is the file that is read");
    refused(&["egg.obj", "--csv", "report.html"], "simdop: --csv: report.html is the file of --output");
    refused(&["egg.obj", "-o", "x.csv"], "simdop: --csv: x.csv is the file of --output");
    refused(
        &["egg.obj", "--peers", "peers.csv"],
        "simdop: peers.csv, line 2: not the results of benches/peers",
    );
    refused(&["egg.obj", "--csv", "absent/report.csv"], "simdop: absent/report.csv: No such file");
    refused(&["egg.obj", "--error=-1"], "must be a length");
    refused(&["egg.obj", "--error", "nan"], "must be a length");
    refused(&["egg.obj", "--poses", "0"], "--poses");
    refused(&["egg.obj", "--isa", "mmx"], "--isa");
}
