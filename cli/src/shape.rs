//! Shapes as bodies: `box:0.1,0.2,0.3` instead of a file, and `hull:FILE`.

use super::body::BodyFile;
use super::poses::numbers;
use clap::builder::{PathBufValueParser, TypedValueParser};
use simdop::primitive::Shape;
use simdop::primitive::shape::Core;
use std::path::PathBuf;

/// A body on the command line.
#[derive(Clone, Debug)]
pub(super) enum Given {
    File(BodyFile),
    Shape(NamedShape),
}

/// A shape, and the text that describes it.
#[derive(Clone, Debug)]
pub(super) struct NamedShape {
    pub(super) name: String,
    pub(super) shape: Shape,
}

/// A shape or hull, if the argument begins with its kind and a colon; otherwise a file.
pub(super) fn parser() -> impl TypedValueParser<Value = Given> {
    PathBufValueParser::new().try_map(parse)
}

fn parse(path: PathBuf) -> Result<Given, String> {
    let Some((kind, rest)) = path.to_str().and_then(|text| text.split_once(':')) else {
        return Ok(Given::File(BodyFile { path, is_hull: false }));
    };
    let shape = match kind {
        "box" => Shape::cuboid(numbers(rest, "X, Y and Z")?),
        "sphere" => {
            let [radius] = numbers(rest, "R")?;
            Shape::sphere(radius)
        }
        "capsule" | "cylinder" | "cone" => {
            let [radius, height] = numbers(rest, "R and H")?;
            match kind {
                "capsule" => Shape::capsule(radius, height),
                "cylinder" => Shape::cylinder(radius, height),
                _ => Shape::cone(radius, height),
            }
        }
        "plane" => {
            let [x, y, z, offset] = numbers(rest, "NX, NY, NZ and D")?;
            Shape::half_space([x, y, z], offset)
        }
        "hull" => return Ok(Given::File(BodyFile { path: rest.into(), is_hull: true })),
        // A single letter is a Windows drive.
        _ if kind.len() > 1 && kind.bytes().all(|c| c.is_ascii_alphabetic()) && !path.exists() => {
            return Err(format!(
                "{kind} is not a shape: box, sphere, capsule, cylinder, cone, plane and hull are; nor is there such a \
                 file"
            ));
        }
        _ => return Ok(Given::File(BodyFile { path, is_hull: false })),
    };
    let shape = shape.map_err(|error| error.to_string())?;
    Ok(Given::Shape(NamedShape { name: path.display().to_string(), shape }))
}

/// The name of a shape's kind.
pub(super) const fn kind(shape: &Shape) -> &'static str {
    match shape.core() {
        Core::Point(_) => "sphere",
        Core::Segment(_) => "capsule",
        Core::Triangle(_) => "triangle",
        Core::Cuboid { .. } => "box",
        Core::Cylinder { .. } => "cylinder",
        Core::Cone { .. } => "cone",
        Core::HalfSpace { .. } => "plane",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_their_kind_and_numbers() {
        let shape = |text: &str| match parse(text.into()) {
            Ok(Given::Shape(named)) => {
                assert_eq!(named.name, text);
                Some(named.shape)
            }
            Ok(Given::File(file)) => {
                assert_eq!(file.name(), text);
                assert_eq!(file.is_hull, text.starts_with("hull:"));
                None
            }
            Err(problem) => panic!("{text}: {problem}"),
        };
        for (text, want) in [
            ("box:1,2,3", Shape::cuboid([1.0, 2.0, 3.0])),
            ("sphere: 1e-3", Shape::sphere(1e-3)),
            ("capsule:1,2", Shape::capsule(1.0, 2.0)),
            ("cylinder:0.03,0.14", Shape::cylinder(0.03, 0.14)),
            ("cone:1 2", Shape::cone(1.0, 2.0)),
            ("plane:0,0,1,-2", Shape::half_space([0.0, 0.0, 1.0], -2.0)),
        ] {
            assert_eq!(shape(text), want.ok());
            let kind_of = kind(&want.unwrap());
            assert!(text.starts_with(kind_of), "{text} is a {kind_of}");
        }
        for file in ["a.obj", "./box:1,2,3", "C:\\a.obj", "a.b:c", "box", "hull:a.obj", "hull:b:c"] {
            assert_eq!(shape(file), None, "{file}");
        }
    }

    #[test]
    fn faults_name_what_is_needed() {
        let fault = |text: &str| parse(text.into()).unwrap_err();
        assert_eq!(fault("box:1,2"), "2 numbers, 3 are needed: X, Y and Z");
        assert_eq!(fault("sphere:1,2"), "2 numbers, 1 are needed: R");
        assert_eq!(fault("cone:1,x"), "'x' is not a number");
        assert_eq!(fault("cylinder:1,0"), "0e0 is not a length of a shape");
        assert_eq!(fault("capsule:-1,1"), "-1e0 is not a length of a shape");
        assert_eq!(fault("sphere:nan"), "NaN is not a length of a shape");
        assert_eq!(fault("plane:0,0,0,1"), "an axis, normal or half edge of a shape is zero");
        assert!(fault("torus:1,2").starts_with("torus is not a shape: box, "));
    }
}
