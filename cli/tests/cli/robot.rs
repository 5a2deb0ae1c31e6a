//! `simdop robot`, run as a user runs it: its report on a robot, on planning problems and on pairs of links,
//! compared with brute force on the Panda.

#[path = "../../../benches/support/robots.rs"]
mod robots;

use crate::folder::Folder;
use crate::support::data::{self, MeshData, directory, suite_step};
use crate::support::rng::{self, Rng};
use glam::DAffine3;
use robots::{Configuration, Problem, Robot, SETTINGS};
use serde_json::{Value, json};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;

type Tree = Bvh<Node16<18>>;

/// A link with this geometry that slides along x by at most 1.
fn slider(geometry: &str) -> String {
    format!(
        r#"<robot name="slider"><link name="rail"/>
        <link name="sled"><collision><geometry>{geometry}</geometry></collision></link>
        <joint name="slide" type="prismatic"><parent link="rail"/><child link="sled"/><axis xyz="1 0 0"/>
        <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
        <joint name="stop" type="fixed"><parent link="rail"/><child link="end"/></joint><link name="end"/></robot>"#
    )
}

/// A problem with one small ball.
fn ball_at(position: [f64; 3]) -> Value {
    let ball =
        json!({"id": "ball", "type": "sphere", "dims": [0.01], "pos": position, "quat_xyzw": [0, 0, 0, 1]});
    json!({"start": {"slide": 0, "stop": 1}, "goals": [{"slide": 1}], "obstacles": [ball]})
}

const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn count(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

fn sum(list: &Value, key: &str) -> usize {
    list.as_array().unwrap().iter().map(|row| count(&row[key])).sum()
}

#[test]
fn the_built_in_arm_needs_no_file() {
    let folder = Folder::new("robot");
    let report = folder.json(&["robot"]);
    let robot = &report["robot"];
    assert_eq!(robot["bodies"].as_array().unwrap().len(), 5);
    assert_eq!(count(&robot["bytes"]), sum(&robot["bodies"], "bytes"));
    assert_eq!(robot["joints"][0], json!({"name": "waist", "limits": [-2.9, 2.9]}));
    let (asked, ruled_out) = (count(&robot["pairs_asked"]), count(&robot["pairs_ruled_out"]));
    assert_eq!((asked, ruled_out), (4, 6));

    let validity = &report["problems"]["validity"];
    let [configurations, valid] =
        ["configurations", "valid"].map(|key| sum(&validity["configurations"], key));
    assert!(configurations == 24 && (5..24).contains(&valid), "{validity}");
    assert_eq!(sum(&validity["hits"], "configurations"), configurations - valid);
    for row in report["problems"]["edges"].as_array().unwrap() {
        let [free, hits, unresolved] = ["free", "hits", "unresolved"].map(|key| count(&row[key]));
        assert_eq!(free + hits + unresolved, count(&row["asked"]));
        assert!(hits > 0 && count(&row["missed_by_samples"]) <= hits, "{row}");
    }

    let pairs = &report["pairs"];
    assert_eq!((sum(&pairs["classes"], "asked"), sum(&pairs["classes"], "ruled_out")), (asked, ruled_out));
    let refuted = pairs["refuted"].as_array().unwrap();
    assert_eq!(refuted.len(), 1, "{refuted:?}");
    assert_eq!((&refuted[0]["bodies"], &refuted[0]["meets"]), (&json!(["column", "forearm"]), &true.into()));
    let never = |pair: &&Value| pair["is_asked"] == true && pair["class"] == "never";
    let never: Vec<&Value> = pairs["matrix"].as_array().unwrap().iter().filter(never).collect();
    assert!(never.len() == 1 && never[0]["bodies"] == json!(["upper_arm", "hand"]), "{never:?}");

    // Each configuration with its verdict, and a path of free motions for each problem.
    let report = folder.json(&["robot", "--edges", "0", "--pairs", "1", "--plan"]);
    let rows = report["problems"]["validity"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), configurations);
    assert_eq!(rows.iter().filter(|row| row["valid"] == true).count(), valid);
    assert!(rows.iter().all(|row| row["bodies"].is_null() == (row["valid"] == true)), "{rows:?}");
    let plans = &report["problems"]["plans"];
    assert_eq!((&plans["solved"], &plans["problems"]), (&report["problems"]["problems"], &plans["problems"]));
    for plan in plans["plans"].as_array().unwrap() {
        let path = plan["path"].as_array().unwrap();
        assert!(path.len() > 1 && plan["length"].as_f64().unwrap() > 0.0, "{plan}");
    }

    let table = String::from_utf8(folder.run(&["robot", "--edges", "3", "--plan"]).stdout).unwrap();
    assert!(table.contains("\nplans      asked  solved"), "{table}");
    assert!(table.contains("\nrandom               6 "), "{table}");
    assert!(table.contains("refuted: \"Never\" of column, forearm: they meet at"), "{table}");
    assert!(table.contains("asked, and they never meet: upper_arm, hand"), "{table}");
}

/// The mesh is in a package, scaled by two and mirrored. A ball inside it is a hit; a ball where the mesh would
/// be without the mirroring is free.
#[test]
fn a_mesh_is_found_scaled_and_solid() {
    let folder = Folder::new("robot_mesh");
    for path in ["here/urdf", "here/meshes"] {
        std::fs::create_dir_all(folder.0.join(path)).unwrap();
    }
    folder.write("here/meshes/t.obj", TETRAHEDRON);
    folder.write("here/meshes/open.obj", TETRAHEDRON.rsplit_once("f 3").unwrap().0);
    let mesh = |name: &str| format!(r#"<mesh filename="package://there/meshes/{name}" scale="2 2 -2"/>"#);
    folder.write("here/urdf/robot.urdf", slider(&mesh("t.obj")));
    folder.write("here/urdf/open.urdf", slider(&mesh("open.obj")));
    let lines = [ball_at([0.3, 0.3, -0.3]), ball_at([0.3, 0.3, 0.3]), ball_at([1.9, 1.9, -0.1])];
    folder.write("problems", lines.map(|line| line.to_string()).join("\n\n"));
    let asked =
        |urdf: &str| folder.json(&["robot", urdf, "--problems", "problems", "--edges", "0", "--pairs", "1"]);

    let report = asked("here/urdf/robot.urdf");
    let body = &report["robot"]["bodies"][0];
    assert_eq!((&body["name"], &body["shape"]), (&"sled".into(), &"solid".into()));
    assert_eq!(report["problems"]["validity"]["configurations"][0]["valid"], 2, "the first start is not");
    assert_eq!(report["problems"]["validity"]["configurations"][1]["valid"], 3, "goals");
    // The hits of random configurations count, too.
    assert_eq!(report["problems"]["validity"]["hits"][0]["bodies"], json!(["sled", "ball"]));
    assert_eq!(report["problems"]["edges"][0]["free"], 2);
    assert_eq!(report["problems"]["edges"][1]["asked"], 0);
    // A surface does not collide with a ball inside it.
    let report = asked("here/urdf/open.urdf");
    assert_eq!(report["robot"]["bodies"][0]["shape"], "surface");
    assert_eq!(report["problems"]["validity"]["configurations"][0]["valid"], 3);
    // A solid with a cap does.
    let capped = |width| {
        let arguments =
            ["robot", "here/urdf/open.urdf", "--cap", width, "--problems", "problems", "--edges", "0"];
        folder.json(&arguments)
    };
    let (report, other) = (capped("2.9"), capped("2.8"));
    let body = &report["robot"]["bodies"][0];
    assert_eq!((&body["shape"], &body["caps"]["holes"]), (&"capped".into(), &1.into()));
    assert_eq!(report["problems"]["validity"]["configurations"][0]["valid"], 2);
    let body = &other["robot"]["bodies"][0];
    assert_eq!((&body["shape"], &body["caps"]), (&"surface".into(), &Value::Null));
    assert_eq!(body["widest_hole"].as_f64().unwrap(), 8.0_f64.sqrt());
    assert_eq!(other["problems"]["validity"]["configurations"][0]["valid"], 3);
    let table =
        |options: &[&str]| String::from_utf8(folder.run(&[&["robot"], options].concat()).stdout).unwrap();
    let lines = [
        (&["here/urdf/robot.urdf"][..], "sled  solid            4 "),
        (&["here/urdf/open.urdf"], "sled  surface          3 "),
        (&["here/urdf/open.urdf", "--cap", "3"], "sled  capped           3 "),
    ];
    for (options, line) in lines {
        let table = table(options);
        let warning = "\nwarning: what is wholly inside of these is free, unless --cap closes them: sled\n";
        assert!(table.contains(&format!("\n{line}")), "{table}");
        assert_eq!(table.contains(warning), line.contains("surface"), "{table}");
        assert_eq!(table.contains("  with holes up to 2.8285 wide\n"), line.contains("surface"), "{table}");
        assert_eq!(
            table.contains("  1 hole capped, at most 2.8285 wide\n"),
            line.contains("capped"),
            "{table}"
        );
    }
}

/// Shapes are exactly those of the URDF: a ball a micrometre beside a round cylinder is free, where a prism around the
/// cylinder would meet it.
#[test]
fn a_urdf_has_its_own_shapes() {
    let folder = Folder::new("robot_shapes");
    let shapes = [
        (r#"<cylinder radius="0.1" length="0.4"/>"#, "cylinder", 0.1),
        (r#"<capsule radius="0.1" length="0.4"/>"#, "capsule", 0.1),
        (r#"<sphere radius="0.1"/>"#, "sphere", 0.1),
        (r#"<box size="0.2 0.2 0.2"/>"#, "box", 0.1),
    ];
    for (geometry, kind, reach) in shapes {
        folder.write("robot.urdf", slider(geometry));
        // Beside the sled at the start, which is invalid only if they meet.
        let lines = [1e-6, 1e-12, -1e-6].map(|gap| ball_at([0.0, reach + 0.01 + gap, 0.0]).to_string());
        folder.write("problems", lines.join("\n"));
        let arguments = ["robot", "robot.urdf", "--problems", "problems", "--edges", "0"];
        let report = folder.json(&arguments);
        let none = Value::Null;
        let body = json!({
            "name": "sled", "shape": kind, "triangles": 0, "bytes": 0, "caps": none, "widest_hole": none
        });
        assert_eq!(report["robot"]["bodies"], json!([body]));
        let starts = &report["problems"]["validity"]["configurations"][0];
        assert_eq!((&starts["configurations"], &starts["valid"]), (&3.into(), &2.into()), "{kind}");
        let edges = &report["problems"]["edges"][0];
        // Motions so near the ball may be unresolved.
        assert!(edges["hits"] == 1, "{kind}: {edges}");
        let output = folder.run(&arguments);
        let table = String::from_utf8(output.stdout).unwrap();
        assert!(output.stderr.is_empty() && table.contains(&format!("\nsled  {kind} ")), "{table}");
        assert!(!table.contains("error") && !table.contains("prism"), "{table}");
    }
}

#[test]
fn faults_name_the_link_the_file_and_the_place() {
    let folder = Folder::new("robot_faults");
    let here = std::path::absolute(&folder.0).unwrap();
    let sled = |file: &str| format!("simdop: link sled: {}", here.join(file).display());
    let mesh = |file: &str| slider(&format!(r#"<mesh filename="{file}"/>"#));
    folder.write("arm.dae", "<COLLADA/>");
    folder.write("empty.obj", "");
    folder.write("dae.urdf", mesh("arm.dae"));
    folder.write("missing.urdf", mesh("package://arm/missing.stl"));
    folder.write("empty.urdf", mesh("empty.obj"));
    folder.write("flat.urdf", slider(r#"<sphere radius="-1"/>"#));
    folder.write("good.urdf", slider(r#"<sphere radius="0.1"/>"#));
    folder.write("text.urdf", "robot");
    let rail = r#"<link name="rail"/>"#;
    let two = slider(r#"<sphere radius="1"/>"#).replace(rail, &(rail.to_owned() + r#"<link name="lost"/>"#));
    folder.write("two.urdf", two);
    folder.write("bad.srdf", "<robot>\n<disable_collisions link1=\"rail\" reason=\"Never\"/></robot>");

    let fault = |arguments: &[&str]| {
        let (code, message) = folder.fate(&[&["robot"], arguments].concat());
        assert_eq!(code, 2, "{arguments:?}: {message}");
        message
    };
    let starts = |arguments: &[&str], with: &str| {
        let message = fault(arguments);
        assert!(message.starts_with(with), "{message}\n{with}");
    };
    starts(&["dae.urdf"], &(sled("arm.dae") + ": COLLADA is not read: convert it"));
    starts(&["missing.urdf"], &(sled("arm/missing.stl") + ": No such file"));
    starts(&["empty.urdf"], &(sled("empty.obj") + ": the file is empty"));
    starts(&["flat.urdf"], "simdop: flat.urdf: link sled: -1e0 is not a length of a shape");
    starts(&["text.urdf"], "simdop: text.urdf: not a robot's description: ");
    starts(&["two.urdf"], "simdop: two.urdf: the links are no tree: see ");
    starts(&["nowhere.urdf"], "simdop: nowhere.urdf: No such file");
    let srdf = "simdop: bad.srdf: not a robot's description: line 2: disable_collisions without link2";
    assert_eq!(fault(&["good.urdf", "--srdf", "bad.srdf"]), srdf);
    assert_eq!(fault(&["good.urdf", "--edges", "4"]), "simdop: --edges: edges are those of --problems");
    assert_eq!(fault(&["good.urdf", "--plan"]), "simdop: --plan: paths are those of --problems");
    folder.write(
        "other.srdf",
        "<robot>\n<disable_collisions link1=\"rail\" link2=\"tail\" reason=\"Never\"/></robot>",
    );
    let other = "simdop: other.srdf: line 2: the robot has no link tail";
    assert_eq!(fault(&["good.urdf", "--srdf", "other.srdf"]), other);
    assert_eq!(
        fault(&["good.urdf", "--srdf", "good.urdf"]).split(": ").nth(3),
        Some("line 1"),
        "a URDF file is no SRDF file"
    );
    assert!(fault(&["--problems", "x"]).contains("<URDF>"));

    let good = ball_at([9.0; 3]);
    let with = |change: &dyn Fn(&mut Value)| {
        let mut line = good.clone();
        change(&mut line);
        folder.write("problems.jsonl", format!("{good}\n{line}\n"));
        let message = fault(&["good.urdf", "--problems", "problems.jsonl"]);
        message.strip_prefix("simdop: problems.jsonl, line 2: ").unwrap_or(&message).to_string()
    };
    assert_eq!(with(&|line| line["start"]["knee"] = 0.into()), "the start: the robot has no joint knee");
    assert_eq!(
        with(&|line| line["goals"][0]["slide"] = json!(1.5)),
        "goal 0, counted from 0: slide is 1.5, and its limits are 0 and 1"
    );
    assert!(
        with(&|line| line["obstacles"][0]["dims"] = json!([0.0])).starts_with("obstacle ball: "),
        "a ball without a radius"
    );
    assert!(with(&|line| line["goals"] = Value::Null).starts_with("column "));
    assert!(with(&|line| line["obstacles"][0]["type"] = "cone".into()).contains("unknown variant `cone`"));
    folder.write("none.jsonl", "\n");
    assert_eq!(
        fault(&["good.urdf", "--problems", "none.jsonl"]),
        "simdop: none.jsonl: there is no problem in the file"
    );
}

fn solid_if_closed(mesh: &Mesh<'_>) -> Tree {
    Builder::new().solid().build_as(mesh).unwrap_or_else(|_| Builder::new().build_as(mesh).unwrap())
}

/// The Panda, placed as in the benchmarks, with trees of its links. Each pair is queried at the pose of one
/// body in the other's frame.
struct Panda {
    robot: Robot,
    links: Vec<Tree>,
    query: Query,
}

impl Panda {
    fn new(data: &std::path::Path) -> Self {
        let robot = SETTINGS[0].robot(data);
        let tree =
            |mesh: &MeshData| solid_if_closed(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles });
        Self {
            links: robot.links.iter().map(|link| tree(&link.mesh)).collect(),
            robot,
            query: Query::new(Isa::detect()),
        }
    }

    fn meet(&self, a: &Tree, at: &DAffine3, b: &Tree, place: &DAffine3) -> bool {
        let pose = Pose::try_from(place.inverse() * *at).unwrap();
        !self.query.collide(a, b, &pose).is_free()
    }

    /// A link among obstacles, each placed in the link's frame.
    fn meets_any(&self, problem: &Problem, link: &Tree, at: &DAffine3) -> bool {
        problem.obstacles.iter().any(|obstacle| {
            let pose = Pose::try_from(at.inverse() * obstacle.at).unwrap();
            !self.query.collide_shape(&obstacle.shape.shape(), link, &pose).is_free()
        })
    }

    fn is_valid(&self, problem: &Problem, values: &Configuration) -> bool {
        let at = self.robot.poses(values);
        let of_itself = |&(i, j): &(usize, usize)| self.meet(&self.links[i], &at[i], &self.links[j], &at[j]);
        let mut links = self.links.iter().zip(&at);
        !self.robot.pairs.iter().any(of_itself) && !links.any(|(link, at)| self.meets_any(problem, link, at))
    }
}

/// Random starts and goals among the obstacles of the data set's problems.
#[test]
fn validity_is_that_of_all_pairs() {
    let Some(data) = directory() else { return };
    let (folder, panda) = (Folder::new("robot_panda"), Panda::new(&data));
    let text = std::fs::read_to_string(data.join("planning/mbm_panda.jsonl")).unwrap();
    let mut rng = Rng::new(41);
    let mut random = || json!(panda.robot.random(&mut rng));
    let lines = text.lines().step_by(5 * suite_step()).map(|line| {
        let mut line: Value = serde_json::from_str(line).unwrap();
        (line["start"], line["goals"]) = (random(), json!([random()]));
        line.to_string() + "\n"
    });
    let lines: String = lines.collect();
    let problem = |line: &str| Problem::new(line, &panda.robot, &mut Rng::new(42));
    let problems: Vec<Problem> = lines.lines().map(problem).collect();
    folder.write("problems.jsonl", &lines);

    let (mut valid, mut crossing) = ([0, 0], 0);
    for problem in &problems {
        for (valid, values) in valid.iter_mut().zip(&problem.ends) {
            *valid += usize::from(panda.is_valid(problem, values));
        }
        let [from, to] = &problem.ends;
        let at = |i: u32| {
            let between =
                |(name, x): (&String, &f64)| (name.clone(), x + f64::from(i) / 64.0 * (to[name] - x));
            from.iter().map(between).collect::<Configuration>()
        };
        crossing += usize::from((0..=64).any(|i| !panda.is_valid(problem, &at(i))));
    }
    let path = |name: &str| data.join("robots/panda").join(name).to_str().unwrap().to_string();
    let (urdf, srdf) = (path("panda.urdf"), path("panda.srdf"));
    let report = folder.json(&["robot", &urdf, "--srdf", &srdf, "--problems", "problems.jsonl"]);
    let rows = &report["problems"]["validity"]["configurations"];
    let reported = [0, 1].map(|row| count(&rows[row]["valid"]));
    assert_eq!(reported, valid, "of {} starts and goals", problems.len());
    assert!(valid[0] > 0 && valid[0] < problems.len());
    let edges = &report["problems"]["edges"];
    assert_eq!(count(&edges[0]["asked"]), problems.len());
    assert!(count(&edges[0]["free"]) <= problems.len() - crossing, "{edges}");
    assert!(count(&edges[0]["hits"]) + count(&edges[0]["unresolved"]) >= crossing, "{edges}");
    assert_eq!(sum(edges, "unresolved"), 0, "{edges}");
}

/// The SRDF disables a pair of links that meets when the arm folds: the samples of its author missed that.
#[test]
fn a_refuted_pair_meets_where_it_is_said() {
    let Some(data) = directory() else { return };
    let (folder, panda) = (Folder::new("robot_pairs"), Panda::new(&data));
    let path = |name: &str| data.join("robots/panda").join(name).to_str().unwrap().to_string();
    let (urdf, srdf) = (path("panda.urdf"), path("panda.srdf"));
    let report = folder.json(&["robot", &urdf, "--srdf", &srdf, "--pairs", "20000"]);
    let pairs = &report["pairs"];
    let all = count(&report["robot"]["pairs_asked"]) + count(&report["robot"]["pairs_ruled_out"]);
    assert_eq!(sum(&pairs["classes"], "asked") + sum(&pairs["classes"], "ruled_out"), all);
    let refuted = pairs["refuted"].as_array().unwrap();
    assert_eq!(refuted.len(), 1, "{refuted:?}");
    assert_eq!(refuted[0]["bodies"], json!(["panda_link2", "panda_link6"]));
    let values: Configuration = serde_json::from_value(refuted[0]["at"].clone()).unwrap();
    let at = panda.robot.poses(&values);
    let link = |name: &str| panda.robot.links.iter().position(|link| link.name == name).unwrap();
    let (i, j) = (link("panda_link2"), link("panda_link6"));
    assert!(panda.meet(&panda.links[i], &at[i], &panda.links[j], &at[j]));
    // Pairs that are certified never to meet do not meet at `SIMDOP_CONFIGURATIONS` random configurations.
    let matrix = pairs["matrix"].as_array().unwrap();
    assert_eq!(matrix.len(), all);
    let never: Vec<(usize, usize)> = matrix
        .iter()
        .filter(|pair| pair["class"] == "never")
        .map(|pair| (link(pair["bodies"][0].as_str().unwrap()), link(pair["bodies"][1].as_str().unwrap())))
        .collect();
    assert!(never.len() > 15, "{never:?}");
    let configurations =
        std::env::var("SIMDOP_CONFIGURATIONS").map_or(4000 / suite_step(), |n| n.parse().unwrap());
    let mut rng = Rng::new(43);
    for _ in 0..configurations {
        let values = panda.robot.random(&mut rng);
        let at = panda.robot.poses(&values);
        for &(i, j) in &never {
            assert!(
                !panda.meet(&panda.links[i], &at[i], &panda.links[j], &at[j]),
                "{i} and {j} at {values:?}"
            );
        }
    }
}
