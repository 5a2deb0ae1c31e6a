//! Pictures of trees and packings.

use crate::files::{obj, off, tetrahedron};
use crate::folder::Folder;
use crate::helpers::strewn;

/// The picture has a path for each triangle. No tree is written unless the option asks for one.
#[test]
fn build_paints_the_first_level() {
    let folder = Folder::new("picture");
    folder.write("a<b>&.off", off(&strewn(9, 100)));
    for (splitter, arity) in
        [("longest-axis", 4), ("extended-longest-axis", 16), ("surface-area", 4), ("mean-width", 16)]
    {
        let arity = format!("--arity={arity}");
        let arguments = ["build", "a<b>&.off", "--picture", "a.svg", "--splitter", splitter, &arity];
        assert_eq!(folder.fate(&arguments), (0, String::new()));
        let svg = std::fs::read_to_string(folder.0.join("a.svg")).unwrap();
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && svg.contains("a&lt;b&gt;&amp;.off"));
        assert_eq!(svg.matches("<path ").count(), 100);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 2);
    let (code, message) = folder.fate(&["build", "a<b>&.off"]);
    assert!(code == 2 && message.contains("--output"), "{message}");
    let (code, message) = folder.fate(&["build", "a<b>&.off", "--picture", "absent/a.svg"]);
    assert!(code == 2 && message.starts_with("simdop: absent/a.svg: "), "{message}");
}

/// Compares the PNG with the paths of the SVG: each pixel whose centre is far from every outline has the colour
/// of the last path that covers it.
#[test]
fn a_png_shows_what_the_svg_does() {
    let folder = Folder::new("png");
    folder.write("a.obj", obj(&strewn(10, 40)));
    for name in ["a.svg", "a.PNG"] {
        assert_eq!(folder.fate(&["build", "a.obj", "--picture", name]), (0, String::new()));
    }
    let svg = std::fs::read_to_string(folder.0.join("a.svg")).unwrap();
    let image = tiny_skia::Pixmap::load_png(folder.0.join("a.PNG")).unwrap();
    let size = format!("viewBox=\"0 0 {} {}\"", image.width(), image.height());
    assert!(svg.contains(&size) && image.width() > 100 && image.height() > 100, "{size}");
    let paths: Vec<(String, [[f64; 2]; 3])> = svg
        .lines()
        .filter_map(|line| line.strip_prefix("<path fill=\"#"))
        .map(|line| {
            let numbers: Vec<f64> = line[12..]
                .split(|c: char| !"-.0123456789".contains(c))
                .filter_map(|word| word.parse().ok())
                .collect();
            (line[..6].to_string(), core::array::from_fn(|i| [numbers[2 * i], numbers[2 * i + 1]]))
        })
        .collect();
    assert_eq!(paths.len(), 40);
    let mut checked = [0, 0];
    for (index, pixel) in image.pixels().iter().enumerate() {
        let (x, y) = (index as u32 % image.width(), index as u32 / image.width());
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        // Distances from the three edges: all positive inside for one orientation of the corners, all negative
        // for the other.
        let distances = |t: &[[f64; 2]; 3]| -> [f64; 3] {
            core::array::from_fn(|i| {
                let ([ax, ay], [bx, by]) = (t[i], t[(i + 1) % 3]);
                ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / (bx - ax).hypot(by - ay).max(1e-9)
            })
        };
        let all: Vec<[f64; 3]> = paths.iter().map(|(_, t)| distances(t)).collect();
        if all.iter().flatten().all(|d| d.abs() > 1.0) {
            let covers = |d: &[f64; 3]| d.iter().all(|d| *d > 0.0) || d.iter().all(|d| *d < 0.0);
            let top = all.iter().rposition(covers);
            let want = top.map_or("ffffff", |top| &paths[top].0);
            let have = format!("{:02x}{:02x}{:02x}", pixel.red(), pixel.green(), pixel.blue());
            assert_eq!((have.as_str(), pixel.alpha()), (want, 255), "at {x} {y}");
            checked[usize::from(top.is_some())] += 1;
        }
    }
    assert!(checked.iter().all(|count| *count > 10_000), "{checked:?}");
    for name in ["a.jpg", "a", "a.svg.bak"] {
        let want = format!("simdop: --picture: {name}: a picture's name ends in .svg or .png");
        assert_eq!(folder.fate(&["build", "a.obj", "-o", "a.tree", "--picture", name]), (2, want));
        assert!(!folder.0.join(name).exists() && !folder.0.join("a.tree").exists());
    }
}

/// The picture has a circle for each sphere. Each pixel of the PNG far from every rim has the colour of the
/// last circle that covers it.
#[test]
fn a_picture_of_a_packing_shows_its_spheres() {
    let folder = Folder::new("pack_picture");
    folder.write("a.obj", obj(&tetrahedron()));
    for name in ["a.svg", "a.png"] {
        let arguments = ["pack", "a.obj", "-n", "40", "-o", "a.txt", "--picture", name];
        assert_eq!(folder.fate(&arguments), (0, String::new()));
    }
    let svg = std::fs::read_to_string(folder.0.join("a.svg")).unwrap();
    let image = tiny_skia::Pixmap::load_png(folder.0.join("a.png")).unwrap();
    let (width, height) = (f64::from(image.width()), f64::from(image.height()));
    let circles: Vec<(String, [f64; 3])> = svg
        .lines()
        .filter_map(|line| line.strip_prefix("<circle fill=\"#"))
        .map(|line| {
            let number = |name: &str| -> f64 {
                let (_, rest) = line.split_once(&format!(" {name}=\"")).unwrap();
                rest.split_once('"').unwrap().0.parse().unwrap()
            };
            (line[..6].to_string(), ["cx", "cy", "r"].map(number))
        })
        .collect();
    assert_eq!(circles.len(), 40);
    for (_, [x, y, r]) in &circles {
        assert!(*r > 0.0 && x - r >= 0.0 && x + r <= width && y - r >= 0.0 && y + r <= height, "{x} {y} {r}");
    }
    let colours: std::collections::BTreeSet<&String> = circles.iter().map(|(colour, _)| colour).collect();
    assert!((8..=16).contains(&colours.len()), "{colours:?}: a colour for each child of the root");
    let mut checked = [0, 0];
    for (index, pixel) in image.pixels().iter().enumerate() {
        let (x, y) = (index as u32 % image.width(), index as u32 / image.width());
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let outside: Vec<f64> = circles.iter().map(|(_, [cx, cy, r])| (x - cx).hypot(y - cy) - r).collect();
        if outside.iter().all(|d| d.abs() > 2.0) {
            let top = outside.iter().rposition(|d| *d < 0.0);
            let want = top.map_or("ffffff", |top| &circles[top].0);
            let have = format!("{:02x}{:02x}{:02x}", pixel.red(), pixel.green(), pixel.blue());
            assert_eq!((have.as_str(), pixel.alpha()), (want, 255), "at {x} {y}");
            checked[usize::from(top.is_some())] += 1;
        }
    }
    assert!(checked.iter().all(|count| *count > 10_000), "{checked:?}");
    let arguments = ["pack", "a.obj", "-o", "b.svg", "--picture", "./b.svg"];
    let want = "simdop: --picture: ./b.svg is the file of --output".to_owned();
    assert_eq!(folder.fate(&arguments), (2, want));
}
