//! Files of robots: errors name the fault, the file and the line.

use super::arm_file;
use crate::support::rng::Rng;
use simdop::planning::{LinkGeometry, PlanningScene, RobotFiles};
use simdop::robot::{LinkShapes, Robot, RobotError};
use std::path::{Path, PathBuf};

/// A folder that is removed at the end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("simdop-planning-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn file(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn urdf(mesh: &str, scale: &str) -> String {
    format!(
        "<robot name=\"r\"><link name=\"a\"><collision><geometry><mesh filename=\"{mesh}\"{scale}/></geometry>\
         </collision></link><link name=\"b\"/><joint name=\"j\" type=\"continuous\"><parent link=\"a\"/>\
         <child link=\"b\"/><axis xyz=\"0 0 1\"/></joint></robot>"
    )
}

fn message(files: &RobotFiles<'_>) -> String {
    files.load().unwrap_err().to_string()
}

#[test]
fn a_wrong_file_is_named_with_its_line() {
    let folder = Folder::new("wrong");
    let path = |name: &str| folder.0.join(name).display().to_string();
    let srdf = |name: &str, text: &str| {
        message(&RobotFiles::new(arm_file("arm.urdf")).srdf(folder.file(name, text)))
    };

    let missing = message(&RobotFiles::new(folder.0.join("none.urdf")));
    assert!(missing.starts_with(&path("none.urdf")), "{missing}");
    let unknown = srdf(
        "unknown.srdf",
        "<robot name=\"arm\">\n<disable_collisions link1=\"base\" link2=\"claw\" reason=\"Never\"/></robot>",
    );
    assert_eq!(unknown, format!("{}: line 2: the robot has no link claw", path("unknown.srdf")));
    let other = srdf("urdf.srdf", &std::fs::read_to_string(arm_file("arm.urdf")).unwrap());
    assert!(other.contains("line 4: a link outside of a group: a URDF file"), "{other}");
    let group =
        srdf("group.srdf", "<robot name=\"arm\"><group name=\"g\">\n<joint name=\"knee\"/></group></robot>");
    assert!(group.contains("line 2") && group.contains("knee"), "{group}");

    let mesh = |file: &str| message(&RobotFiles::new(folder.file("mesh.urdf", urdf(file, ""))));
    assert!(mesh("none.obj").starts_with(&format!("link a: {}", path("none.obj"))));
    folder.file("damaged.obj", "v 0 0 zero\n");
    assert_eq!(
        mesh("damaged.obj"),
        format!("link a: {}, line 1: 'zero' is not a number", path("damaged.obj"))
    );
    folder.file("empty.obj", "v 0 0 0\n");
    assert_eq!(mesh("empty.obj"), format!("link a: {}: there is no triangle in the file", path("empty.obj")));
}

/// A closed mesh is a solid with its outside outwards, even if the scale reflects it.
#[test]
fn meshes_are_scaled_solids() {
    let folder = Folder::new("scaled");
    folder.file("t.obj", OBJ);
    for (scale, corner) in [("", 1.0), (" scale=\"2 2 2\"", 2.0), (" scale=\"-1 1 1\"", 1.0)] {
        let model = RobotFiles::new(folder.file("t.urdf", urdf("t.obj", scale))).load().unwrap();
        let [body @ LinkGeometry::Mesh { tree, hole: None }] = model.bodies() else { panic!("one mesh") };
        assert!(body.is_solid());
        let y = (0..4).flat_map(|i| tree.view().primitive(i)).map(|p| p[1]).fold(0.0, f64::max);
        assert_eq!(y, corner);
    }
}

#[test]
fn holes_are_capped_on_request() {
    let folder = Folder::new("holes");
    folder.file("open.obj", &OBJ[..OBJ.len() - "f 3 1 4\n".len()]);
    let files = || RobotFiles::new(folder.file("open.urdf", urdf("open.obj", "")));
    let open = files().load().unwrap();
    let [body @ LinkGeometry::Mesh { hole: Some(width), .. }] = open.bodies() else { panic!("a surface") };
    assert!(!body.is_solid() && (*width - 2.0_f64.sqrt()).abs() < 1e-12);
    assert!(files().cap(1.5).load().unwrap().bodies()[0].is_solid());
}

#[test]
fn meshes_are_found_as_the_caller_says_or_upwards() {
    let folder = Folder::new("found");
    let mesh = folder.file("elsewhere/t.obj", OBJ);
    let path = folder.file("robot/urdf/r.urdf", urdf("package://r/meshes/t.obj", ""));
    let files = || RobotFiles::new(&path);
    assert!(files().load().is_err());
    let asked = |name: &str| (name == "package://r/meshes/t.obj").then(|| mesh.clone());
    assert!(files().resolve(asked).load().is_ok());
    folder.file("robot/meshes/t.obj", OBJ);
    assert!(files().resolve(|_| None).load().is_ok());
}

#[test]
fn the_file_of_a_mesh_is_sought_upwards() {
    let folder = Folder::new("packages");
    let located = |urdf: &Path, name: &str| simdop::planning::located(urdf, name);
    let make = |path: &str| folder.file(path, "");
    let urdf = make("clone/urdf/arm.urdf");
    let (beside, inside, other) =
        (make("clone/urdf/a.stl"), make("clone/meshes/b.stl"), make("hand/meshes/c.stl"));
    assert_eq!(located(&urdf, "a.stl"), beside);
    assert_eq!(located(&urdf, &format!("file://{}", inside.display())), inside);
    assert_eq!(located(&urdf, "package://arm/meshes/b.stl"), inside);
    assert_eq!(located(&urdf, "package://hand/meshes/c.stl"), other);
    assert_eq!(located(&urdf, "package://arm/d.stl"), urdf.with_file_name("arm").join("d.stl"));
}

const TWO_ARMS: &str = r#"<robot name="two"><link name="torso"/><link name="l1"/><link name="l2"/><link name="lf"/>
  <link name="r1"/><link name="finger"/>
  <joint name="left_1" type="revolute"><parent link="torso"/><child link="l1"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="left_2" type="continuous"><parent link="l1"/><child link="l2"/><axis xyz="0 0 1"/></joint>
  <joint name="left_tip" type="fixed"><parent link="l2"/><child link="lf"/></joint>
  <joint name="right_1" type="prismatic"><parent link="torso"/><child link="r1"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
  <joint name="mimic" type="prismatic"><parent link="r1"/><child link="finger"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/><mimic joint="right_1"/></joint></robot>"#;

#[test]
fn groups_hold_the_variables_of_their_members() {
    let robot = Robot::from_urdf(TWO_ARMS, LinkShapes::Collision).unwrap();
    assert_eq!(robot.variables, ["left_1", "left_2", "right_1"]);
    assert_eq!(robot.continuous, [false, true, false]);
    let srdf = r#"<robot name="two"><virtual_joint name="world" type="fixed" parent_frame="w" child_link="torso"/>
        <group name="left"><chain base_link="torso" tip_link="lf"/><joint name="world"/></group>
        <group name="right"><joint name="right_1"/><joint name="mimic"/></group>
        <group name="link"><link name="l2"/><link name="torso"/></group>
        <group name="both"><group name="left"/><group name="right"/></group></robot>"#;
    let groups = robot.groups(srdf).unwrap();
    let found: Vec<_> = groups.iter().map(|group| (group.name.as_str(), &*group.variables)).collect();
    assert_eq!(found, [("left", &[0, 1][..]), ("right", &[2]), ("link", &[1]), ("both", &[0, 1, 2])]);

    let fault = |member: &str| {
        robot
            .groups(&format!("<robot name=\"two\">\n<group name=\"g\">{member}</group></robot>"))
            .unwrap_err()
    };
    let named = |name: &str| RobotError::UnknownMember { line: 2, name: name.into() };
    assert_eq!(fault("<joint name=\"x\"/>"), named("x"));
    assert_eq!(fault("<group name=\"g\"/>"), named("g"));
    assert_eq!(fault("<chain base_link=\"r1\" tip_link=\"l2\"/>"), named("l2"));
    assert_eq!(fault("<link name=\"x\"/>"), RobotError::UnknownLink { line: 2, link: "x".into() });
}

/// No text makes the readers panic.
#[test]
fn damaged_descriptions_are_refused_or_read() {
    let robot = Robot::from_urdf(TWO_ARMS, LinkShapes::Collision).unwrap();
    let mut rng = Rng::new(3);
    for _ in 0..2000 {
        let mut text = TWO_ARMS.as_bytes().to_vec();
        for _ in 0..1 + rng.below(3) {
            let i = rng.below(text.len() as u64) as usize;
            match rng.below(3) {
                0 => text[i] = b" <>\"/a0"[rng.below(7) as usize],
                1 => text.truncate(i.max(1)),
                _ => drop(text.remove(i)),
            }
        }
        let text = String::from_utf8(text).unwrap();
        let _ = Robot::from_urdf(&text, LinkShapes::Collision).map(|robot| robot.pairs(&[]).unwrap());
        let _ = robot.groups(&text);
    }
}

#[test]
fn a_group_is_planned_for_alone() {
    let chain = "<chain base_link=\"upper_arm\" tip_link=\"hand\"/>";
    let srdf = &format!("<robot name=\"arm\"><group name=\"tip\">{chain}</group></robot>");
    let folder = Folder::new("group");
    let files = RobotFiles::new(arm_file("arm.urdf")).srdf(folder.file("a.srdf", srdf));
    let mut scene = PlanningScene::new(files.load().unwrap()).unwrap();
    let mut workspace = scene.workspace();
    let whole = [0.3, -0.4, 2.2, 1.9];
    let all = scene.collide(&mut workspace, &whole).unwrap();
    scene.select_group("tip", &[0.3, -0.4, 0.0, 0.0]).unwrap();
    assert_eq!((scene.variables(), scene.limits()), (2, &[[-2.4, 2.4], [-2.0, 2.0]][..]));
    assert_eq!(scene.collide(&mut workspace, &whole[2..]).unwrap(), all);
    assert!(scene.collide(&mut workspace, &whole).is_err());
    assert!(scene.select_group("toe", &whole).unwrap_err().to_string().contains("toe"));
    assert!(scene.select_group("tip", &[9.0; 4]).is_err());
}
