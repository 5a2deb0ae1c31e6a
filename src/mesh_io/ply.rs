//! PLY, ASCII and binary of either byte order. The crate `ply-rs-bw` reads headers and binary elements; ASCII elements
//! are read here.

use super::data::{Faces, MeshData};
use super::decimals::Decimals;
use super::error::{FileError, FilePlace};
use super::text::{check_last_line, check_single, count, lines, quote, text, unknown_vertex};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, Version,
};

/// An element of either kind: a vertex has a position, a face has corners.
struct Element {
    position: [f64; 3],
    corners: Vec<i64>,
}

fn axis(property: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|axis| *axis == property)
}

fn is_corner_list(property: &str) -> bool {
    matches!(property, "vertex_indices" | "vertex_index")
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self { position: [f64::NAN; 3], corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if let Some(axis) = axis(name) {
            let Some(x) = real(&property) else { return PropertyAccessResult::UnsupportedType };
            self.position[axis] = x;
        } else if is_corner_list(name) {
            let Some(corners) = integers(property) else { return PropertyAccessResult::UnsupportedType };
            self.corners = corners;
        } else {
            return PropertyAccessResult::Ignored;
        }
        PropertyAccessResult::Set
    }
}

fn real(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => return None,
    })
}

fn integers(property: Property) -> Option<Vec<i64>> {
    fn widen<T: Into<i64>>(list: Vec<T>) -> Option<Vec<i64>> {
        Some(list.into_iter().map(Into::into).collect())
    }
    match property {
        Property::ListChar(list) => widen(list),
        Property::ListUChar(list) => widen(list),
        Property::ListShort(list) => widen(list),
        Property::ListUShort(list) => widen(list),
        Property::ListInt(list) => widen(list),
        Property::ListUInt(list) => widen(list),
        _ => None,
    }
}

pub(super) fn parse(bytes: &[u8]) -> Result<MeshData, FileError> {
    let Elements { vertices, faces, .. } = elements(bytes, Wanted::Mesh)?;
    faces.into_mesh(vertices)
}

/// The vertices in their order. Ignores everything else in the file.
pub(super) fn points(bytes: &[u8]) -> Result<Vec<[f64; 3]>, FileError> {
    Ok(elements(bytes, Wanted::Points)?.vertices)
}

/// What to read from a file.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Wanted {
    Mesh,
    Points,
}

fn elements(bytes: &[u8], wanted: Wanted) -> Result<Elements, FileError> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Element>::new().read_header(&mut reader).map_err(|error| header_fault(&error))?;
    let vertex_count = check_header(&header, wanted)?;
    let first_line = reader.line();
    let payload = reader.into_inner();
    let elements = Elements { wanted, vertex_count, vertices: Vec::new(), faces: Faces::default() };
    match header.encoding {
        Encoding::Ascii => ascii(&text(payload), first_line, &header, elements),
        order => binary(payload, bytes.len(), order, &header, elements),
    }
}

/// The crate's messages have several lines, since they quote the file. Keep the first line.
fn header_fault(error: &ParseError) -> FileError {
    let message = error.to_string();
    let message = message.lines().next().unwrap_or("");
    let message = message.split_once(": ").filter(|_| error.line().is_some()).map_or(message, |(_, m)| m);
    FileError {
        place: error.line().map_or(FilePlace::Nowhere, FilePlace::Line),
        problem: message.to_string(),
    }
}

/// Checks that the file has the wanted elements and can be read in full. Returns the number of vertices.
fn check_header(header: &Header, wanted: Wanted) -> Result<usize, FileError> {
    let what = if wanted == Wanted::Mesh { "mesh" } else { "cloud" };
    let element = |name: &str| {
        let missing = || FileError::file(format!("not a {what}: there is no element '{name}'"));
        header.elements.get(name).ok_or_else(missing)
    };
    let Version { major, minor } = header.version;
    if (major, minor) != (1, 0) {
        return Err(FileError::file(format!(
            "the format's version is {major}.{minor}, and the only one known is 1.0"
        )));
    }
    let vertex = element("vertex")?;
    for axis in ["x", "y", "z"] {
        if !matches!(vertex.properties.get(axis).map(|p| &p.data_type), Some(PropertyType::Scalar(_))) {
            return Err(FileError::file(format!("the element 'vertex' has no number '{axis}'")));
        }
    }
    if wanted == Wanted::Points {
        return Ok(vertex.count);
    }
    let face = element("face")?;
    let is_list = |p: &PropertyType| matches!(p, PropertyType::List(..));
    if !face.properties.iter().any(|(name, p)| is_corner_list(name) && is_list(&p.data_type)) {
        return Err(FileError::file("the element 'face' has no list 'vertex_indices'"));
    }
    if header.elements.get("tristrips").is_some_and(|strips| strips.count > 0) {
        return Err(FileError::file("triangle strips are not supported"));
    }
    Ok(vertex.count)
}

/// The elements read so far.
struct Elements {
    wanted: Wanted,
    /// The number of vertices in the header.
    vertex_count: usize,
    vertices: Vec<[f64; 3]>,
    faces: Faces,
}

impl Elements {
    /// Whether elements of a kind are used.
    fn wants(&self, kind: &str) -> bool {
        kind == "vertex" || kind == "face" && self.wanted == Wanted::Mesh
    }

    /// Adds an element of the file.
    fn add(&mut self, kind: &str, element: &Element, place: FilePlace) -> Result<(), FileError> {
        let fault = |problem| FileError { place, problem };
        match kind {
            "vertex" => {
                if let Some(x) = element.position.iter().find(|x| !x.is_finite()) {
                    return Err(fault(format!("the coordinate {x} is not finite")));
                }
                if self.wanted == Wanted::Points {
                    check_single(element.position).map_err(fault)?;
                }
                self.vertices.push(element.position);
            }
            "face" if self.wants(kind) => {
                let vertices = self.vertex_count;
                let known = |&v: &i64| {
                    let index = u32::try_from(v).ok().filter(|&v| (v as usize) < vertices);
                    index.ok_or_else(|| fault(unknown_vertex(v, vertices)))
                };
                let corners = element.corners.iter().map(known).collect::<Result<Vec<u32>, FileError>>()?;
                self.faces.add(corners, place)?;
            }
            _ => {}
        }
        Ok(())
    }
}

fn inside(def: &ElementDef, index: usize) -> String {
    format!("the file ends at {} {index} of {}", def.name, def.count)
}

fn ascii(
    text: &str,
    first_line: usize,
    header: &Header,
    mut elements: Elements,
) -> Result<Elements, FileError> {
    let mut decimals = Decimals::default();
    let end = first_line + lines(text).count();
    let source = lines(text).map(|(line, content)| (first_line + line - 1, content));
    let mut source = source.filter(|(_, content)| !content.trim().is_empty());
    for def in header.elements.values() {
        for index in 0..def.count {
            let (line, content) = source.next().ok_or_else(|| FileError::line(end, inside(def, index)))?;
            if elements.wants(&def.name) {
                let element = ascii_element(def, content, line, &mut decimals)?;
                elements.add(&def.name, &element, FilePlace::Line(line))?;
            }
        }
    }
    if let Some((line, _)) = source.next() {
        return Err(FileError::line(line, "more lines than the header announces"));
    }
    check_last_line(text, first_line)?;
    decimals.settle(&mut elements.vertices);
    Ok(elements)
}

/// Reads decimals as in the other formats, whatever type the header gives them. Skips unused properties.
fn ascii_element(
    def: &ElementDef,
    content: &str,
    line: usize,
    decimals: &mut Decimals,
) -> Result<Element, FileError> {
    let mut element = Element::new();
    let mut words = content.split_ascii_whitespace();
    let missing = || FileError::line(line, "a number is missing");
    for (name, property) in &def.properties {
        match (&property.data_type, axis(name)) {
            (PropertyType::Scalar(_), Some(axis)) => {
                element.position[axis] = decimals.coordinate(words.next(), line)?;
            }
            (PropertyType::Scalar(_), None) => drop(words.next().ok_or_else(missing)?),
            (PropertyType::List(..), _) => {
                for _ in 0..count(words.next(), line)? {
                    let word = words.next().ok_or_else(missing)?;
                    if is_corner_list(name) {
                        let problem = || FileError::line(line, format!("{} is not an index", quote(word)));
                        element.corners.push(word.parse().map_err(|_| problem())?);
                    }
                }
            }
        }
    }
    match words.next() {
        Some(word) => Err(FileError::line(line, format!("{} is one number too many", quote(word)))),
        None => Ok(element),
    }
}

fn binary(
    payload: &[u8],
    file_size: usize,
    order: Encoding,
    header: &Header,
    mut elements: Elements,
) -> Result<Elements, FileError> {
    let parser = Parser::<Element>::new();
    let mut rest = payload;
    // Elements without properties have no bytes, whatever their number.
    for def in header.elements.values().filter(|def| !def.properties.is_empty()) {
        for index in 0..def.count {
            let start = file_size - rest.len();
            let element = match order {
                Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut rest, def),
                _ => parser.read_little_endian_element(&mut rest, def),
            };
            let element = element.map_err(|error| match error.kind() {
                std::io::ErrorKind::UnexpectedEof => FileError::byte(file_size, inside(def, index)),
                _ => FileError { place: FilePlace::Byte(start), ..header_fault(&error) },
            })?;
            elements.add(&def.name, &element, FilePlace::Byte(start))?;
        }
    }
    if rest.is_empty() {
        Ok(elements)
    } else {
        Err(FileError::byte(file_size - rest.len(), "more bytes than the header announces"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ELEMENTS: &str = "element vertex 3\nproperty double x\nproperty float y\nproperty int z\nproperty uchar red\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn ascii_file(rest: &str) -> Vec<u8> {
        format!("ply\nformat ascii 1.0\ncomment made by hand\n{ELEMENTS}{rest}").into_bytes()
    }

    /// Three vertices of 17 bytes and a face with `corners`; `big` is the byte order. Also returns the size of the
    /// header.
    fn binary_file(big: bool, x: f64, corners: [i32; 3]) -> (Vec<u8>, usize) {
        let name = if big { "big" } else { "little" };
        let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n{ELEMENTS}").into_bytes();
        let size = bytes.len();
        for i in 0..3_u8 {
            let (y, z) = (f32::from(i) * 0.1, i32::from(i));
            let put = if big {
                [&x.to_be_bytes()[..], &y.to_be_bytes(), &z.to_be_bytes(), &[i]].concat()
            } else {
                [&x.to_le_bytes()[..], &y.to_le_bytes(), &z.to_le_bytes(), &[i]].concat()
            };
            bytes.extend(put);
        }
        bytes.push(3);
        bytes.extend(corners.iter().flat_map(|c| if big { c.to_be_bytes() } else { c.to_le_bytes() }));
        (bytes, size)
    }

    #[test]
    fn ascii_of_mixed_types() {
        let mesh = parse(&ascii_file("0.1 0.1 7 nan\n\n1 .5 0 0\n0 1. 0 0\n3 0 1 2\n")).unwrap();
        let tenth = f64::from(0.1_f32);
        assert_eq!(mesh.vertices, [[tenth, tenth, 7.0], [1.0, 0.5, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn binary_of_both_orders() {
        for big in [false, true] {
            let (bytes, _) = binary_file(big, 0.1, [2, 1, 0]);
            let mesh = parse(&bytes).unwrap();
            // In the order of their first use.
            assert_eq!(mesh.vertices[0], [0.1, f64::from(2.0 * 0.1_f32), 2.0]);
            assert_eq!(mesh.triangles, [[0, 1, 2]]);
        }
    }

    #[test]
    fn faults_of_ascii_name_their_line() {
        let fault = |rest: &str| parse(&ascii_file(rest)).unwrap_err();
        assert_eq!(fault("0 0 0 0\n0 zero 0 0\n"), FileError::line(13, "'zero' is not a number"));
        assert_eq!(fault("0 0 0 0\n0 nan 0 0\n"), FileError::line(13, "the coordinate 'nan' is not finite"));
        assert_eq!(fault("0 0 0 0\n0 0 0\n"), FileError::line(13, "a number is missing"));
        assert_eq!(fault("0 0 0 0 0\n"), FileError::line(12, "'0' is one number too many"));
        let vertices = "0 0 0 0\n0 0 0 0\n0 0 0 0\n";
        assert_eq!(fault(vertices), FileError::line(15, "the file ends at face 0 of 1"));
        let face = |line: &str| fault(&format!("{vertices}{line}\n"));
        assert_eq!(face("3 0 1 3"), FileError::line(15, "vertex 3 of 3, counted from 0, does not exist"));
        assert_eq!(face("3 0 1 -1"), FileError::line(15, "vertex -1 of 3, counted from 0, does not exist"));
        assert_eq!(face("2 0 1"), FileError::line(15, "a face with 2 corners, at least 3 are needed"));
        assert_eq!(face("3 0 1 2\n3 0 1 2"), FileError::line(16, "more lines than the header announces"));
    }

    #[test]
    fn faults_of_binary_name_their_byte() {
        for big in [false, true] {
            let (file, size) = binary_file(big, 0.0, [0, 1, 2]);
            let end = file.len();
            assert_eq!(
                parse(&file[..size + 20]),
                Err(FileError::byte(size + 20, "the file ends at vertex 1 of 3"))
            );
            assert_eq!(
                parse(&file[..end - 2]),
                Err(FileError::byte(end - 2, "the file ends at face 0 of 1"))
            );
            let more = [file.as_slice(), b"\n"].concat();
            assert_eq!(parse(&more), Err(FileError::byte(end, "more bytes than the header announces")));
            let (file, size) = binary_file(big, f64::INFINITY, [0, 1, 2]);
            assert_eq!(parse(&file), Err(FileError::byte(size, "the coordinate inf is not finite")));
            let (file, size) = binary_file(big, 0.0, [0, 1, 3]);
            let problem = "vertex 3 of 3, counted from 0, does not exist";
            assert_eq!(parse(&file), Err(FileError::byte(size + 3 * 17, problem)));
        }
    }

    #[test]
    fn a_cut_file_is_refused() {
        for file in [ascii_file("0 0 0 0\n1 0 0 0\n0 1 0 0\n3 0 1 2\n"), binary_file(false, 0.0, [0, 1, 2]).0]
        {
            assert_eq!(parse(&file).map(|mesh| mesh.triangles.len()), Ok(1));
            for length in 0..file.len() {
                assert!(parse(&file[..length]).is_err(), "{length}");
            }
        }
    }

    /// A cloud consists of all vertices, duplicates included; faces are skipped, even invalid ones.
    #[test]
    fn points_are_the_vertices_of_any_file() {
        let same = [[0.5, 0.5, 7.0], [0.5, 0.5, 7.0], [0.0, 1.0, 0.0]];
        let lines = ".5 .5 7 0\n.5 .5 7 0\n0 1 0 0\n";
        assert_eq!(points(&ascii_file(&format!("{lines}3 0 1 99\n"))).unwrap(), same);
        for big in [false, true] {
            let (bytes, size) = binary_file(big, 0.5, [0, 1, 99]);
            let want: [[f64; 3]; 3] =
                core::array::from_fn(|i| [0.5, f64::from(i as f32 * 0.1), f64::from(i as u8)]);
            assert_eq!(points(&bytes).unwrap(), want);
            assert_eq!(
                points(&bytes[..size + 20]),
                Err(FileError::byte(size + 20, "the file ends at vertex 1 of 3"))
            );
            let (bytes, size) = binary_file(big, 1e39, [0, 1, 2]);
            assert_eq!(points(&bytes), Err(FileError::byte(size, "the coordinate 1e39 is beyond f32")));
        }
        let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n";
        let with_z = format!("{cloud}property float z\nend_header\n");
        let fault = |text: &str| points(text.as_bytes()).unwrap_err();
        assert_eq!(points(format!("{with_z}1 2 3\n").as_bytes()).unwrap(), [[1.0, 2.0, 3.0]]);
        assert_eq!(fault(&with_z), FileError::line(8, "the file ends at vertex 0 of 1"));
        assert_eq!(fault(&format!("{with_z}1 2\n")), FileError::line(8, "a number is missing"));
        assert_eq!(fault(&format!("{with_z}1 2 -inf\n")).problem, "the coordinate '-inf' is not finite");
        assert_eq!(
            fault(&format!("{with_z}1 2 -4e38\n")),
            FileError::line(8, "the coordinate -4e38 is beyond f32")
        );
        assert_eq!(
            fault(&format!("{cloud}end_header\n1 2\n")),
            FileError::file("the element 'vertex' has no number 'z'")
        );
        assert_eq!(
            fault("ply\nformat ascii 1.0\nend_header\n"),
            FileError::file("not a cloud: there is no element 'vertex'")
        );
    }

    #[test]
    fn headers_that_are_not_of_meshes() {
        let fault = |text: &str| parse(text.as_bytes()).unwrap_err();
        assert_eq!(fault("solid\n").place, FilePlace::Line(1));
        assert_eq!(fault("ply\nformat ascii 2\n").place, FilePlace::Line(2));
        let later = "ply\nformat ascii 2.0\nelement vertex 0\nend_header\n";
        assert_eq!(
            fault(later),
            FileError::file("the format's version is 2.0, and the only one known is 1.0")
        );
        let cloud = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n";
        assert_eq!(
            fault(&format!("{cloud}property float z\nend_header\n")),
            FileError::file("not a mesh: there is no element 'face'")
        );
        let flat = format!("{cloud}element face 0\nproperty list uchar int vertex_indices\nend_header\n");
        assert_eq!(fault(&flat), FileError::file("the element 'vertex' has no number 'z'"));
    }
}
