/*
 * Three questions. An arm's link that holds a tetrahedron, beside a box: do they meet, and how near do they come? A
 * swinging link: does it meet a thin wall on its way? An arm with two joints: how does it get past a post? Links and
 * obstacles are shapes. Compiles as C99 and as C++11.
 *
 * Lengths are in metres. Exits with 0 only if each answer is as expected; `capi/check` builds and runs it.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "simdop.h"

/* Ends the program with the library's message unless a call succeeded. */
static void must(simdop_error error) {
    if (error != SIMDOP_ERROR_NONE) {
        fprintf(stderr, "%s: %s\n", simdop_error_text(error), simdop_last_error());
        exit(EXIT_FAILURE);
    }
}

/* Ends the program unless the expectation holds. */
static void expect(int is_so, const char *what) {
    printf("%s: %s\n", is_so ? "as expected" : "NOT AS EXPECTED", what);
    if (!is_so) {
        exit(EXIT_FAILURE);
    }
}

/* Ends the program unless a call failed as expected. */
static void must_fail(simdop_error error, simdop_error expected) {
    expect(error == expected, simdop_last_error());
}

/* A translation. */
static simdop_pose at(double x, double y, double z) {
    const simdop_pose pose = {{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}}};
    return pose;
}

/* A shape with up to three numbers. */
static simdop_shape shape(simdop_shape_kind kind, double x, double y, double z, simdop_pose pose) {
    const simdop_shape made = {(uint32_t)kind, {x, y, z, 0}, 0, pose};
    return made;
}

/* A body of one shape. */
static simdop_body *body_of(simdop_shape shape) {
    simdop_body *body;
    must(simdop_body_build_shape(&shape, &body));
    return body;
}

/* The box with sides x, y, z about the origin. */
static simdop_body *box(double x, double y, double z) {
    return body_of(shape(SIMDOP_SHAPE_KIND_CUBOID, x, y, z, at(0, 0, 0)));
}

/* All points below a height. */
static simdop_body *ground(double height) {
    simdop_shape below = shape(SIMDOP_SHAPE_KIND_HALF_SPACE, 0, 0, 1, at(0, 0, 0));
    below.numbers[3] = height;
    return body_of(below);
}

/* Counts hits, and stops at `most`. */
struct count {
    int found, most;
};

static int on_hit(void *user, const simdop_scene_hit *hit) {
    struct count *count = (struct count *)user;
    printf("  primitive %u of one body meets primitive %u of the other\n", (unsigned)hit->pair.a,
           (unsigned)hit->pair.b);
    count->found++;
    return count->found == count->most;
}

/* A motion given by callbacks: a body slides from one place to another along a straight line. */
struct slide {
    double from[3], to[3];
    int left; /* Calls of slide_go_to() until it stops the query. */
};

static int slide_go_to(void *user, double time, simdop_pose *poses) {
    struct slide *slide = (struct slide *)user;
    double place[3];
    for (int i = 0; i < 3; i++) {
        place[i] = slide->from[i] + time * (slide->to[i] - slide->from[i]);
    }
    poses[0] = at(place[0], place[1], place[2]);
    return slide->left-- == 0;
}

/* All points of the body move equally far: in the whole time, from one place to the other. 1e-12 covers rounding. */
static double slide_path(void *user, size_t body, const double *centre, double radius, double span) {
    const struct slide *slide = (const struct slide *)user;
    double square = 0;
    (void)body, (void)centre, (void)radius;
    for (int i = 0; i < 3; i++) {
        square += (slide->to[i] - slide->from[i]) * (slide->to[i] - slide->from[i]);
    }
    return span * sqrt(square) + 1e-12;
}

/* A link that swings about the origin, and a wall 2 mm thick half way. */
static void swing(simdop_body *link) {
    simdop_body *wall = box(0.4, 0.002, 0.4);
    simdop_role role = simdop_role_default(), fixed = simdop_role_default();
    simdop_scene *scene;
    simdop_body_id link_id, wall_id;
    simdop_motion_answer edge;
    const double none[4] = {0, 0, 0, 1}, eighth[4] = {0, 0, sin(atan(1) / 2), cos(atan(1) / 2)},
                 quarter[4] = {0, 0, sqrt(0.5), sqrt(0.5)}, back[4] = {0, 0, -sqrt(0.5), sqrt(0.5)};
    const double at_0[3] = {0.3, 0, 0}, at_45[3] = {0.25, 0.25, 0}, at_90[3] = {0, 0.3, 0},
                 at_270[3] = {0, -0.3, 0};
    simdop_pose start, across, end, other_end;
    must(simdop_pose_from_quaternion(none, at_0, &start));
    must(simdop_pose_from_quaternion(eighth, at_45, &across));
    must(simdop_pose_from_quaternion(quarter, at_90, &end));
    must(simdop_pose_from_quaternion(back, at_270, &other_end));
    fixed.is_fixed = 1;
    must(simdop_scene_create(&scene));
    must(simdop_scene_insert(scene, link, &role, &start, &link_id));
    must(simdop_scene_insert(scene, wall, &fixed, &across, &wall_id));

    simdop_scene_answer seen;
    must(simdop_scene_collide(scene, SIMDOP_NO_BUDGET, &seen));
    expect(seen.verdict == SIMDOP_VERDICT_FREE, "the link is free at the start");
    must(simdop_scene_place(scene, link_id, &end));
    must(simdop_scene_collide(scene, SIMDOP_NO_BUDGET, &seen));
    expect(seen.verdict == SIMDOP_VERDICT_FREE, "and at the end");
    must(simdop_scene_check_screw(scene, link_id, &start, &end, 1e-6, SIMDOP_NO_BUDGET, &edge));
    expect(edge.verdict == SIMDOP_MOTION_VERDICT_HIT, "in between it meets the wall");
    expect((edge.hit.a == wall_id || edge.hit.b == wall_id) && fabs(edge.time - 0.5) < 0.1, "half way");
    must(simdop_scene_check_screw(scene, link_id, &start, &other_end, 1e-6, SIMDOP_NO_BUDGET, &edge));
    expect(edge.verdict == SIMDOP_MOTION_VERDICT_FREE, "the other way round it is free, at all times");

    /* The same queries with a motion given by callbacks: the link slides past the wall, and through it. */
    struct slide slide = {{-1, 0.6, 0}, {1, 0.6, 0}, 1000};
    simdop_motion motion = {&slide, slide_go_to, slide_path, NULL};
    must(simdop_scene_check_motion(scene, &link_id, 1, &motion, 1e-6, SIMDOP_NO_BUDGET, &edge));
    expect(edge.verdict == SIMDOP_MOTION_VERDICT_FREE, "it slides past the wall");
    slide.from[1] = slide.to[1] = 0.2;
    must(simdop_scene_check_motion_discrete(scene, &link_id, 1, &motion, 1, SIMDOP_NO_BUDGET, &edge));
    expect(edge.verdict == SIMDOP_MOTION_VERDICT_UNRESOLVED && edge.times == 2, "its two ends alone prove nothing");
    must(simdop_scene_check_motion(scene, &link_id, 1, &motion, 1e-6, SIMDOP_NO_BUDGET, &edge));
    expect(edge.verdict == SIMDOP_MOTION_VERDICT_HIT, "it slides through it");
    slide.left = 0;
    must_fail(simdop_scene_check_motion(scene, &link_id, 1, &motion, 1e-6, SIMDOP_NO_BUDGET, &edge),
              SIMDOP_ERROR_MOTION_STOPPED);
    motion.path = NULL;
    must_fail(simdop_scene_check_motion(scene, &link_id, 1, &motion, 1e-6, SIMDOP_NO_BUDGET, &edge),
              SIMDOP_ERROR_NULL);

    simdop_scene_destroy(scene);
    simdop_body_destroy(wall);
}

/* A post 0.4 m high on a foot that stands on the ground, 0.2 m below the arm. */
static simdop_body *post(void) {
    const simdop_shape parts[2] = {
        shape(SIMDOP_SHAPE_KIND_CYLINDER, 0.05, 0.4, 0, at(0, 0, 0)),
        shape(SIMDOP_SHAPE_KIND_CUBOID, 0.2, 0.2, 0.02, at(0, 0, -0.19)),
    };
    simdop_body *body;
    must(simdop_body_build_shapes(parts, 2, &body));
    return body;
}

/* An arm in the plane, and a post 0.9 m from its base, half way through a quarter turn. */
static void reach(simdop_body *link) {
    enum { SHOULDER, ELBOW, JOINTS };
    static const double limits[JOINTS][2] = {{-2, 2}, {-2.6, 2.6}};
    const double quarter = 2 * atan(1), start[JOINTS] = {0, 0}, folded[JOINTS] = {0, 2.5},
                 turned[JOINTS] = {quarter, 2.5}, end[JOINTS] = {quarter, 0}, beyond[JOINTS] = {0, 3};
    const double *way[] = {start, folded, turned, end};
    const simdop_pose base = at(0, 0, 0), aside = at(0.9 * sqrt(0.5), 0.9 * sqrt(0.5), 0);
    simdop_pose poses[JOINTS];
    simdop_joint joints[JOINTS];
    simdop_link_body bodies[JOINTS];
    simdop_body *obstacles[2] = {post(), ground(-0.2)};
    simdop_role role = simdop_role_default(), fixed = simdop_role_default();
    simdop_scene *scene;
    simdop_body_id ids[JOINTS], post_id, ground_id;
    simdop_robot *robot, *none;
    simdop_motion_answer edge;
    must(simdop_scene_create(&scene));
    for (uint32_t i = 0; i < JOINTS; i++) {
        /* Each joint rotates about z at the end of the previous link; the body is half a link further. */
        const simdop_pose origin = at(i == ELBOW ? 0.5 : 0, 0, 0);
        const simdop_joint joint = {SIMDOP_JOINT_KIND_REVOLUTE, i, i, origin, {0, 0, 1}, 1, 0};
        const simdop_link_body body = {i + 1, at(0.25, 0, 0)};
        joints[i] = joint;
        bodies[i] = body;
        /* The pose in the scene does not matter: a motion query sets the poses. */
        must(simdop_scene_insert(scene, link, &role, &base, &ids[i]));
    }
    must(simdop_scene_allow_collision(scene, ids[SHOULDER], ids[ELBOW]));
    fixed.is_fixed = 1;
    must(simdop_scene_insert(scene, obstacles[0], &fixed, &aside, &post_id));
    must(simdop_scene_insert(scene, obstacles[1], &fixed, &base, &ground_id));
    must(simdop_robot_new(&base, joints, JOINTS, bodies, JOINTS, &limits[0][0], JOINTS, &robot));

    must(simdop_robot_poses(robot, end, poses));
    expect(fabs(poses[ELBOW].rows[1][3] - 0.75) < 1e-12, "stretched along y, its second link is 0.75 m from the base");
    must(simdop_scene_check_joint_motion(scene, ids, JOINTS, robot, start, end, 1e-6, SIMDOP_NO_BUDGET, &edge));
    expect(edge.verdict == SIMDOP_MOTION_VERDICT_HIT, "stretched, it meets the post on the way");
    expect(edge.hit.a == post_id || edge.hit.b == post_id, "not the ground");
    for (int i = 0; i < 3; i++) {
        must(simdop_scene_check_joint_motion(scene, ids, JOINTS, robot, way[i], way[i + 1], 1e-6, SIMDOP_NO_BUDGET,
                                             &edge));
        expect(edge.verdict == SIMDOP_MOTION_VERDICT_FREE, "folded, it is free at all times");
    }
    must_fail(simdop_robot_poses(robot, beyond, poses), SIMDOP_ERROR_MOTION_OUT_OF_LIMITS);
    joints[ELBOW].kind = 7;
    must_fail(simdop_robot_new(&base, joints, JOINTS, bodies, JOINTS, &limits[0][0], JOINTS, &none),
              SIMDOP_ERROR_MOTION_NO_SUCH_KIND);

    simdop_robot_free(robot);
    simdop_scene_destroy(scene);
    simdop_body_destroy(obstacles[0]);
    simdop_body_destroy(obstacles[1]);
}

/* A ball on the ground, and between the boards of a shelf. */
static void roll(void) {
    const simdop_shape boards[2] = {
        shape(SIMDOP_SHAPE_KIND_CUBOID, 2, 1, 0.1, at(0, 0, 0)),
        shape(SIMDOP_SHAPE_KIND_CUBOID, 2, 1, 0.1, at(0, 0, 1.25)),
    };
    const simdop_shape wrong[2] = {boards[0], shape(SIMDOP_SHAPE_KIND_HALF_SPACE, 0, 0, 1, at(0, 0, 0))};
    simdop_shape no_length = boards[0];
    simdop_body *ball = body_of(shape(SIMDOP_SHAPE_KIND_SPHERE, 0.5, 0, 0, at(0, 0, 0)));
    simdop_body *plane = ground(0), *shelf, *opened, *none;
    simdop_pose pose = at(3, 4, 0.5);
    simdop_answer answer;
    simdop_distance_answer distance;
    const uint8_t *bytes;
    size_t count;
    must(simdop_collide(ball, plane, &pose, SIMDOP_NO_BUDGET, &answer));
    expect(answer.verdict == SIMDOP_VERDICT_HIT, "the ball touches the ground");
    pose = at(3, 4, 0.5000001);
    must(simdop_collide(ball, plane, &pose, SIMDOP_NO_BUDGET, &answer));
    expect(answer.verdict == SIMDOP_VERDICT_FREE, "above it, it does not");

    must(simdop_body_build_shapes(boards, 2, &shelf));
    must(simdop_body_bytes(shelf, &bytes, &count));
    must(simdop_body_open(bytes, count, &opened));
    pose = at(0, 0, 0.65);
    must(simdop_distance(ball, opened, &pose, 0, SIMDOP_NO_BUDGET, &distance));
    expect(fabs(distance.upper - 0.05) < 1e-12 && distance.pair.b == 1, "it is 5 cm below the upper board");
    must_fail(simdop_body_bytes(ball, &bytes, &count), SIMDOP_ERROR_SHAPE_NO_BYTES);
    must_fail(simdop_body_build_shapes(wrong, 2, &none), SIMDOP_ERROR_SHAPE_UNBOUNDED);
    no_length.numbers[2] = 0;
    must_fail(simdop_body_build_shape(&no_length, &none), SIMDOP_ERROR_SHAPE_LENGTH);

    simdop_body_destroy(opened);
    simdop_body_destroy(shelf);
    simdop_body_destroy(plane);
    simdop_body_destroy(ball);
}

int main(void) {
    static const double corners[4 * 3] = {0, 0, 0, 0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
    static const uint32_t faces[4 * 3] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    /* The link lies along x. */
    const simdop_pose along_x = {{{0, 0, 1, 0}, {0, 1, 0, 0}, {-1, 0, 0, 0}}};
    simdop_body *shelf = box(0.4, 0.4, 0.4), *built, *tool, *none;
    simdop_body *link = body_of(shape(SIMDOP_SHAPE_KIND_CAPSULE, 0.025, 0.45, 0, along_x));

    /* The tool is opened from bytes, as it would be from flash. They belong to `built`, which must outlive it. */
    const uint8_t *bytes;
    size_t count;
    must(simdop_body_build_surface(corners, 4, faces, 4, &built));
    must(simdop_body_bytes(built, &bytes, &count));
    must(simdop_body_open(bytes, count, &tool));

    /* Two bodies. */
    simdop_pose pose = at(1, 0, 0);
    simdop_answer answer;
    simdop_distance_answer distance;
    must(simdop_distance(tool, shelf, &pose, 0, SIMDOP_NO_BUDGET, &distance));
    expect(fabs(distance.upper - 0.8) < 1e-12 && distance.lower <= distance.upper, "it is 0.8 m to the shelf");
    expect(fabs(distance.point_a[0] - 1) < 1e-12 && fabs(distance.point_b[0] - 0.2) < 1e-12, "between these points");
    must(simdop_within(tool, shelf, &pose, 0.79, SIMDOP_NO_BUDGET, &answer));
    expect(answer.verdict == SIMDOP_VERDICT_FREE, "it is not within 0.79 m");
    const double quarter_about_z[4] = {0, 0, sqrt(0.5), sqrt(0.5)}, inside[3] = {0.05, 0, 0};
    must(simdop_pose_from_quaternion(quarter_about_z, inside, &pose));
    must(simdop_collide(tool, shelf, &pose, SIMDOP_NO_BUDGET, &answer));
    expect(answer.verdict == SIMDOP_VERDICT_HIT, "wholly inside of the shelf it is a hit");

    /* A scene: the link holds the tool, and moves. */
    simdop_scene *scene;
    simdop_body_id shelf_id, link_id, tool_id;
    simdop_role fixed = simdop_role_default(), padded = simdop_role_default();
    fixed.is_fixed = 1;
    padded.radius = 0.01;
    must(simdop_scene_create(&scene));
    pose = at(0.9, 0, 0);
    must(simdop_scene_insert(scene, shelf, &fixed, &pose, &shelf_id));
    pose = at(0, 0, 0);
    must(simdop_scene_insert(scene, link, &padded, &pose, &link_id));
    pose = at(0.25, 0, 0);
    must(simdop_scene_insert(scene, tool, &padded, &pose, &tool_id));
    must(simdop_scene_allow_collision(scene, link_id, tool_id));
    must(simdop_scene_attach(scene, tool_id, link_id));

    simdop_scene_answer seen;
    simdop_scene_clearance_answer near;
    must(simdop_scene_collide(scene, SIMDOP_NO_BUDGET, &seen));
    expect(seen.verdict == SIMDOP_VERDICT_FREE, "the arm is free");
    must(simdop_scene_clearance(scene, 0, 1, SIMDOP_NO_BUDGET, &near));
    expect(fabs(near.upper - 0.34) < 1e-9, "the padded tool is 0.34 m from the shelf");
    pose = at(0.4, 0, 0);
    must(simdop_scene_place(scene, link_id, &pose));
    must(simdop_scene_within(scene, 0.05, SIMDOP_NO_BUDGET, &seen));
    expect(seen.verdict == SIMDOP_VERDICT_HIT, "it comes within 0.05 m of the shelf");
    expect(seen.hit.a != link_id && seen.hit.b != link_id, "the tool does, not the link");
    struct count hits = {0, 1};
    simdop_scene_hits all;
    must(simdop_scene_each_hit(scene, 0.1, SIMDOP_NO_BUDGET, on_hit, &hits, &all));
    expect(hits.found == 1 && all.completion == SIMDOP_COMPLETION_STOPPED, "the callback stopped at the first hit");

    /* Errors. */
    must_fail(simdop_body_build_solid(corners, 4, faces, 3, &none), SIMDOP_ERROR_BUILD_OPEN);
    expect(none == NULL, "there is no body then");
    must_fail(simdop_scene_place(scene, tool_id, &pose), SIMDOP_ERROR_SCENE_IS_ATTACHED);
    must_fail(simdop_collide(NULL, shelf, &pose, SIMDOP_NO_BUDGET, &answer), SIMDOP_ERROR_NULL);

    must(simdop_scene_detach(scene, tool_id));
    must(simdop_scene_remove(scene, tool_id));
    must_fail(simdop_scene_remove(scene, tool_id), SIMDOP_ERROR_SCENE_NO_SUCH_BODY);
    simdop_scene_destroy(scene);
    swing(link);
    reach(link);
    roll();
    simdop_body_destroy(tool);
    simdop_body_destroy(built);
    simdop_body_destroy(link);
    simdop_body_destroy(shelf);
    return EXIT_SUCCESS;
}
