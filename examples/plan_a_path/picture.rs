//! The arm along its path, as SVG: every configuration in both views, the first blue and the last red.

use core::error::Error;
use simdop::motion::LinkFrame;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::primitive::shape::Core;
use simdop::robot::Robot;

/// Pixels per metre, and the centres of the two views.
const SCALE: f64 = 330.0;
const VIEWS: [(&str, [usize; 2], [f64; 2]); 2] =
    [("from the side", [0, 2], [330.0, 480.0]), ("from above", [0, 1], [970.0, 330.0])];

/// Corners of a box: bit i selects the side along axis i.
const FACES: [[u8; 4]; 6] =
    [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

/// A face of a box. Drawing all six gives its outline from any view.
fn polygon(
    face: [u8; 4],
    centre: &[f64; 3],
    half: &[[f64; 3]; 3],
    flat: impl Fn([f64; 3]) -> [f64; 2],
) -> String {
    let corner = |bits: u8| {
        let side = |i: usize| if bits >> i & 1 == 0 { -1.0 } else { 1.0 };
        let along = |j: usize| (0..3).map(|i| side(i) * half[i][j]).sum::<f64>();
        let [x, y] = flat(core::array::from_fn(|j| centre[j] + along(j)));
        format!("{x:.1},{y:.1} ")
    };
    format!("<polygon points=\"{}\" stroke=\"none\"/>\n", face.map(corner).concat().trim_end())
}

/// A shape at its place: a capsule as a thick line, a box as its faces.
fn drawn(shape: &Shape, flat: impl Fn([f64; 3]) -> [f64; 2] + Copy) -> Option<String> {
    match shape.core() {
        Core::Segment(ends) => {
            let ([[x, y], [u, v]], width) = (ends.map(flat), 2.0 * SCALE * shape.radius());
            Some(format!(
                "<line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{u:.1}\" y2=\"{v:.1}\" stroke-width=\"{width:.1}\"/>\n"
            ))
        }
        Core::Cuboid { centre, half } => Some(FACES.map(|face| polygon(face, centre, half, flat)).concat()),
        _ => None,
    }
}

/// `boxes` are side lengths and centres, `shown` the configurations along the path.
pub(crate) fn draw(
    robot: &Robot,
    boxes: &[[[f64; 3]; 2]],
    shown: &[[f64; 4]],
) -> Result<String, Box<dyn Error>> {
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1300 660\" width=\"1300\" height=\"660\" \
         font-family=\"sans-serif\" font-size=\"18\">\n<rect width=\"1300\" height=\"660\" fill=\"white\"/>\n",
    );
    for (title, axes, middle) in VIEWS {
        let flat = |p: [f64; 3]| [middle[0] + SCALE * p[axes[0]], middle[1] - SCALE * p[axes[1]]];
        for [sides, at] in boxes {
            let [left, top] =
                flat(core::array::from_fn(|i| at[i] + if i == 0 { -0.5 } else { 0.5 } * sides[i]));
            let (width, height) = (SCALE * sides[axes[0]], SCALE * sides[axes[1]]);
            svg += &format!(
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
                 fill=\"#8a7f70\" fill-opacity=\"0.25\" stroke=\"#8a7f70\"/>\n"
            );
        }
        let mut hands = Vec::new();
        for (i, values) in shown.iter().enumerate() {
            let (colour, opacity) = match i {
                0 => ("#1f77b4", 1.0),
                _ if i + 1 == shown.len() => ("#d62728", 1.0),
                _ => ("#555555", 0.18),
            };
            svg += &format!(
                "<g stroke=\"{colour}\" fill=\"{colour}\" opacity=\"{opacity}\" stroke-linecap=\"round\">\n"
            );
            let (mut links, mut poses) = ([LinkFrame::EMPTY; 5], [Pose::IDENTITY; 8]);
            robot.kinematics()?.go_to(values, &mut links, &mut poses)?;
            for (link, pose) in robot.shapes.iter().zip(&poses) {
                let shape = link.shape().map(|shape| shape.moved(pose));
                svg +=
                    &shape.and_then(|shape| drawn(&shape, flat)).ok_or("the arm has capsules and boxes")?;
            }
            svg += "</g>\n";
            hands.push(flat(poses[robot.shapes.len() - 1].apply([0.0, 0.0, 0.07])));
        }
        let points: Vec<String> = hands.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        svg += &format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"black\" stroke-width=\"1.5\" stroke-dasharray=\"5 4\"/>\n",
            points.join(" ")
        );
        for ([x, y], text) in [(hands[0], "start"), (hands[hands.len() - 1], "goal")] {
            svg += &format!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" stroke=\"white\" \
                 stroke-width=\"4\" paint-order=\"stroke\">{text}</text>\n",
                x + 9.0,
                y - 9.0
            );
        }
        svg += &format!("<text x=\"{:.1}\" y=\"30\" text-anchor=\"middle\">{title}</text>\n", middle[0]);
    }
    Ok(svg + "</svg>\n")
}
