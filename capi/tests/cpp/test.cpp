/*
 * Tests simdop.hpp: its answers are those known beforehand or of a loop, and those of eight threads on shared bodies
 * are those of one. Compiles with and without SIMDOP_EXPECTED. Exits with 0 only if all hold; `capi/check` builds and
 * runs it under the sanitizers.
 */
#include "simdop.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <thread>

namespace {

/* The value of a result that has one. */
#ifdef SIMDOP_EXPECTED
template <class T> T must(simdop::result<T> result) {
    if (!result) {
        std::fprintf(stderr, "%s\n", result.error().what());
        std::exit(EXIT_FAILURE);
    }
    return std::move(result).value();
}

void must(simdop::result<void> result) {
    if (!result) {
        std::fprintf(stderr, "%s\n", result.error().what());
        std::exit(EXIT_FAILURE);
    }
}

template <class Ask> simdop_error code_of(Ask ask) {
    const auto result = ask();
    return result ? SIMDOP_ERROR_NONE : result.error().code();
}
#else
template <class T> T must(T value) {
    return value;
}

template <class Ask> simdop_error code_of(Ask ask) {
    try {
        (void)ask();
    } catch (const simdop::error &error) {
        return error.code();
    }
    return SIMDOP_ERROR_NONE;
}
#endif

/* For calls without a value: their result may be void. */
#ifdef SIMDOP_EXPECTED
#define DO(call) must(call)
#else
#define DO(call) call
#endif

void expect_at(bool is_so, const char *what, int line) {
    if (!is_so) {
        std::fprintf(stderr, "line %d: NOT SO: %s\n", line, what);
        std::exit(EXIT_FAILURE);
    }
}

#define EXPECT(what) expect_at((what), #what, __LINE__)

bool is_near(double a, double b) {
    return std::fabs(a - b) < 1e-9;
}

const std::vector<simdop::vec3> CORNERS = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<simdop::triangle> FACES = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

simdop::mesh tetrahedron() {
    return {CORNERS, FACES};
}

void two_bodies() {
    const simdop::body solid = must(simdop::body::solid(tetrahedron()));
    const simdop::body ball = must(simdop::body::shape(simdop::ball(0.5)));
    DO(solid.verify());
    EXPECT(must(simdop::collide(ball, solid, simdop::translation(0, 0, 1.5))).verdict == SIMDOP_VERDICT_HIT);
    EXPECT(must(simdop::collide(ball, solid, simdop::translation(0, 0, 1.500001))).verdict == SIMDOP_VERDICT_FREE);
    EXPECT(must(simdop::within(ball, solid, simdop::translation(0, 0, 2), 0.5)).verdict == SIMDOP_VERDICT_HIT);
    EXPECT(must(simdop::within(ball, solid, simdop::translation(0, 0, 2), 0.4)).verdict == SIMDOP_VERDICT_FREE);
    EXPECT(is_near(must(simdop::distance(solid, solid, simdop::translation(3, 0, 0))).upper, 2));
    EXPECT(must(simdop::distance(solid, solid, simdop::translation(3, 0, 0), 0, 1)).lower == 1);

    /* Opened from its own bytes. */
    const auto bytes = must(solid.bytes());
    const simdop::body opened = must(simdop::body::open(bytes));
    std::array<simdop::pose, 3> poses = {simdop::identity(), simdop::translation(1, 0, 0),
                                         simdop::translation(1.001, 0, 0)};
    std::array<simdop_answer, 3> answers{};
    DO(simdop::collide(solid, opened, poses, answers));
    EXPECT(answers[0].verdict == SIMDOP_VERDICT_HIT && answers[1].verdict == SIMDOP_VERDICT_HIT);
    EXPECT(answers[2].verdict == SIMDOP_VERDICT_FREE);

    simdop::hint hint;
    const auto first = must(hint.collide(solid, opened, poses[1]));
    const auto second = must(hint.collide(solid, opened, poses[1]));
    EXPECT(first.verdict == SIMDOP_VERDICT_HIT && second.verdict == SIMDOP_VERDICT_HIT);
    EXPECT(second.stats.visits == 0 && first.stats.visits > 0);

    int found = 0;
    const auto pairs = must(simdop::each_pair(solid, opened, poses[1], [&](const simdop_pair &) { found++; }));
    EXPECT(found == 9 && pairs.completion == SIMDOP_COMPLETION_COMPLETE);
    bool is_thrown = false;
    try {
        (void)simdop::each_pair(solid, opened, poses[1], [](const simdop_pair &) -> bool { throw 7; });
    } catch (int) {
        is_thrown = true;
    }
    EXPECT(is_thrown);

    EXPECT(is_near(must(simdop::depth_along(ball, ball, simdop::translation(0.25, 0, 0), {1, 0, 0})), 0.75));
    int of_ball = 0;
    (void)must(simdop::each_pair(solid, ball, simdop::identity(), [&](const simdop_pair &pair) {
        of_ball += pair.b == 0 ? 1 : 100;
    }));
    EXPECT(of_ball == 3);

    const std::vector<simdop::sphere> unit = {{0, 0, 0, 1}};
    const simdop::body spheres = must(simdop::body::spheres(unit));
    const auto shared = must(simdop::penetration(spheres, spheres, simdop::translation(1, 0, 0)));
    EXPECT(is_near(shared.volume, 5.0 / 12.0 * 3.14159265358979323846) && shared.direction[0] == 1);

    const auto packing = must(simdop::pack(tetrahedron(), 20));
    EXPECT(packing.spheres.size() == 20 && is_near(packing.volume, 1.0 / 6));
    EXPECT(packing.share > 0.4 && packing.share < 1);
    const simdop::body plain = must(simdop::body::solid(tetrahedron()));
    const simdop::body packed = must(plain.packed(packing.spheres));
    EXPECT(must(packed.bytes()).size() > must(plain.bytes()).size());
    EXPECT(code_of([&] { return packed.packed({}); }) == SIMDOP_ERROR_BUILD_PACKING);
    EXPECT(must(simdop::cover(tetrahedron(), 0.1, true, 1)).size() > 1);
}

void errors() {
    EXPECT(simdop::is_compatible());
    const std::vector<simdop::triangle> open(FACES.begin(), FACES.begin() + 3);
    EXPECT(code_of([&] { return simdop::body::solid({CORNERS, open}); }) == SIMDOP_ERROR_BUILD_OPEN);
    EXPECT(code_of([&] { return simdop::body::surface({CORNERS, open}); }) == SIMDOP_ERROR_NONE);
    EXPECT(code_of([&] { return simdop::body::shape(simdop::ball(-1)); }) == SIMDOP_ERROR_SHAPE_LENGTH);
    EXPECT(code_of([] { return simdop::from_quaternion({1, 1, 0, 0}, {0, 0, 0}); }) == SIMDOP_ERROR_POSE_NOT_UNIT);
    const simdop::body body = must(simdop::body::surface({{}, {}}));
    EXPECT(must(simdop::collide(body, body, simdop::identity())).verdict == SIMDOP_VERDICT_FREE);
}

void scenes() {
    const simdop::body box = must(simdop::body::shape(simdop::cuboid(1, 1, 1)));
    simdop::scene scene = must(simdop::scene::create());
    simdop::body_id wall = SIMDOP_NO_BODY, hand = SIMDOP_NO_BODY, cup = SIMDOP_NO_BODY;
    {
        /* The scene keeps bodies whose other handles are gone. */
        const simdop::body gone = must(simdop::body::surface(tetrahedron()));
        wall = must(scene.insert(gone, simdop::translation(5, 0, 0), simdop::fixed()));
    }
    hand = must(scene.insert(box, simdop::translation(0, 0, 0), simdop::padded(0.25)));
    cup = must(scene.insert(box, simdop::translation(0, 0, 1), simdop::padded(0.25)));
    EXPECT(must(scene.collide()).verdict == SIMDOP_VERDICT_HIT);
    EXPECT(must(scene.is_asked(hand, cup)));
    DO(scene.allow_collision(hand, cup));
    EXPECT(!must(scene.is_asked(hand, cup)));
    DO(scene.attach(cup, hand));
    EXPECT(must(scene.collide()).verdict == SIMDOP_VERDICT_FREE);
    EXPECT(is_near(must(scene.clearance()).upper, 4.25));
    EXPECT(is_near(must(scene.signed_clearance()).lower, 4.25));
    const std::array<simdop::body_id, 1> moving = {hand};
    const std::array<simdop::pose, 1> near = {simdop::translation(4.25, 0, 0)};
    DO(scene.place(moving, near));
    EXPECT(must(scene.world_pose(cup)).rows[2][3] == 1 && must(scene.world_pose(cup)).rows[0][3] == 4.25);
    int hits = 0;
    EXPECT(must(scene.each_hit(0, [&](const simdop_scene_hit &hit) { hits += hit.a == hand || hit.b == hand; }))
               .completion == SIMDOP_COMPLETION_COMPLETE);
    EXPECT(hits == 1);
    const auto edge =
        must(scene.check_motion(hand, simdop::translation(0, 0, 0), simdop::translation(9, 0, 0), 1e-6));
    EXPECT(edge.verdict == SIMDOP_MOTION_VERDICT_HIT);
    EXPECT(code_of([&] { return scene.collide(); }) == SIMDOP_ERROR_NONE);

    simdop::scene other = must(simdop::scene::create(SIMDOP_STORAGE_HALF));
    other = std::move(scene);
    DO(other.remove(wall));
    EXPECT(must(other.collide()).verdict == SIMDOP_VERDICT_FREE);
}

void clouds() {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> in(-1, 1);
    std::vector<simdop::point> points(500);
    for (auto &point : points) {
        point = {in(random), in(random), in(random)};
    }
    simdop::cloud cloud = must(simdop::cloud::build(points));
    EXPECT(cloud.size().points == 500 && cloud.size().capacity == 500);
    const auto is_near = [](const simdop::point &p, const simdop::point &q, float radius) {
        const float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
        return x * x + y * y + z * z <= radius * radius;
    };
    simdop::neighbours found, others;
    (void)must(cloud.find(0.25F, found));
    (void)must(cloud.find(points, 0.25F, others));
    std::vector<std::uint32_t> counts(500);
    (void)must(cloud.count(0.25F, counts));
    for (std::size_t i = 0; i < points.size(); i++) {
        std::uint32_t count = 0;
        for (const auto &point : points) {
            count += is_near(point, points[i], 0.25F) ? 1 : 0;
        }
        EXPECT(found.of(i).size() == count && others.of(i).size() == count && counts[i] == count);
        for (const std::uint32_t index : found.of(i)) {
            EXPECT(is_near(points[index], points[i], 0.25F));
        }
    }
    std::vector<simdop_neighbour> nearest(1000);
    DO(cloud.nearest(points, 2, nearest));
    for (std::uint32_t i = 0; i < 500; i++) {
        EXPECT(nearest[2 * i].index == i && nearest[2 * i].square == 0 && nearest[2 * i + 1].square > 0);
    }
    int seen = 0;
    (void)must(cloud.each_within(points[0], 10, [&](std::uint32_t) { return ++seen < 3; }));
    EXPECT(seen == 3 && must(cloud.any_within(points[0], 0)) && !must(cloud.any_within({5, 5, 5}, 1)));

    simdop::scene scene = must(simdop::scene::create());
    (void)must(scene.insert(cloud, simdop::translation(3, 0, 0), simdop::fixed()));
    const simdop::body ball = must(simdop::body::shape(simdop::ball(1)));
    const simdop::body_id id = must(scene.insert(ball));
    EXPECT(must(scene.collide()).verdict == SIMDOP_VERDICT_FREE);
    DO(scene.place(id, simdop::translation(3, 0, 0)));
    EXPECT(must(scene.collide()).verdict == SIMDOP_VERDICT_HIT);
}

/* An arm of two links in the plane, beside a post. */
struct arm {
    simdop::robot robot;
    simdop::body link, post;

    static arm build() {
        const double limits[] = {-3, 3, -3, 3};
        const auto joint = [](std::uint32_t i, double x) {
            return simdop_joint{SIMDOP_JOINT_KIND_REVOLUTE, i, i, simdop::translation(x, 0, 0), {0, 0, 1}, 1, 0};
        };
        const std::array<simdop_joint, 2> joints = {joint(0, 0), joint(1, 1)};
        const std::array<simdop_link_body, 2> bodies = {simdop_link_body{1, simdop::translation(0.5, 0, 0)},
                                                        simdop_link_body{2, simdop::translation(0.5, 0, 0)}};
        const std::array<std::array<double, 2>, 2> each = {{{limits[0], limits[1]}, {limits[2], limits[3]}}};
        return {must(simdop::robot::build(simdop::identity(), joints, bodies, each)),
                must(simdop::body::shape(simdop::cuboid(0.9, 0.1, 0.1))),
                must(simdop::body::shape(simdop::cylinder(0.2, 1)))};
    }

    /* A scene of its own. */
    simdop::scene scene(std::array<simdop::body_id, 2> &ids) const {
        simdop::scene made = must(simdop::scene::create());
        ids = {must(made.insert(link)), must(made.insert(link))};
        (void)must(made.insert(post, simdop::translation(1.2, 1.2, 0), simdop::fixed()));
        DO(made.allow_collision(ids[0], ids[1]));
        return made;
    }
};

void states() {
    const arm arm = arm::build();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> in(-3, 3);
    std::vector<double> values(2 * 1000);
    for (double &value : values) {
        value = in(random);
    }
    std::array<simdop::body_id, 2> ids{};
    simdop::scene scene = arm.scene(ids);
    std::vector<std::uint8_t> free(1000), from_poses(1000);
    const auto answer = must(scene.check_states(ids, arm.robot, values, free));
    EXPECT(answer.free > 100 && answer.free < 1000);

    /* One by one, and from poses. */
    simdop::robot robot = arm.robot;
    std::vector<simdop::pose> poses(2 * 1000);
    for (std::size_t i = 0; i < 1000; i++) {
        DO(robot.poses({values.data() + 2 * i, 2}, {poses.data() + 2 * i, 2}));
    }
    (void)must(scene.check_states(ids, poses, from_poses));
    for (std::size_t i = 0; i < 1000; i++) {
        DO(scene.place(ids, simdop::view<const simdop::pose>(poses.data() + 2 * i, 2)));
        EXPECT((must(scene.collide()).verdict == SIMDOP_VERDICT_FREE) == (free[i] == 1));
        EXPECT(free[i] == from_poses[i]);
    }

    /* Eight threads on the same bodies and robot, each with a scene, answer alike: configurations and edges. */
    std::vector<std::thread> threads;
    std::array<int, 8> wrong{};
    for (std::size_t thread = 0; thread < 8; thread++) {
        threads.emplace_back([&, thread] {
            std::array<simdop::body_id, 2> own_ids{};
            simdop::scene own = arm.scene(own_ids);
            std::vector<std::uint8_t> seen(1000);
            (void)must(own.check_states(own_ids, arm.robot, values, seen));
            wrong[thread] += seen != free;
            for (std::size_t i = thread; i + 1 < 200; i += 8) {
                const simdop::view<const double> from(values.data() + 2 * i, 2), to(values.data() + 2 * i + 2, 2);
                const auto edge = must(own.check_motion(own_ids, arm.robot, from, to, 1e-4));
                /* Free only if both ends are. */
                wrong[thread] += edge.verdict == SIMDOP_MOTION_VERDICT_FREE && !(free[i] && free[i + 1]);
            }
            /* A failure of this thread, whose message is its own. */
            wrong[thread] += code_of([&] { return own.within(-1.0 - static_cast<double>(thread)); }) !=
                             SIMDOP_ERROR_TOLERANCE;
            const std::string expected = std::to_string(thread + 1);
            wrong[thread] += std::string(simdop_last_error()).find(expected) == std::string::npos;
        });
    }
    for (std::size_t thread = 0; thread < 8; thread++) {
        threads[thread].join();
        EXPECT(wrong[thread] == 0);
    }

    std::array<double, 2> meeting{}, apart{};
    const auto report = must(scene.classify_pair(ids, arm.robot, ids[0], ids[1], 1000, meeting, apart));
    EXPECT(report.pair_class == SIMDOP_PAIR_CLASS_SOMETIMES && report.has_meeting && report.has_free);
}

#ifdef SIMDOP_URDF
void descriptions() {
    const std::string urdf = R"(<robot name="two">
        <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
        <link name="arm"><collision><geometry><sphere radius="0.5"/></geometry></collision></link>
        <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="2 0 0"/>
        <axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="1" velocity="1"/></joint></robot>)";
    const simdop::description description = must(simdop::description::read(urdf));
    EXPECT(description.variables() == 1 && description.bodies() == 2);
    const auto variable = must(description.variable(0));
    EXPECT(std::string(variable.name) == "turn" && variable.lower == -1 && variable.upper == 2);
    const auto arm = must(description.described_body(1));
    EXPECT(std::string(arm.link_name) == "arm" && arm.link == 1 && arm.mesh_file == nullptr);
    simdop::robot robot = must(description.build_robot());
    simdop::scene scene = must(simdop::scene::create());
    std::vector<simdop::body_id> ids;
    std::vector<simdop::pose> poses(2);
    const std::array<double, 1> values = {0};
    DO(robot.poses(values, poses));
    for (std::size_t i = 0; i < 2; i++) {
        ids.push_back(must(scene.insert(must(description.build_body(i)), poses[i])));
    }
    DO(description.select_pairs("", scene, ids));
    EXPECT(is_near(must(scene.clearance()).upper, 1));
    DO(description.select_pairs(R"(<robot><disable_collisions link1="arm" link2="base"/></robot>)", scene, ids));
    EXPECT(std::isinf(must(scene.clearance()).upper));
    EXPECT(code_of([&] { return simdop::description::read("<robot"); }) == SIMDOP_ERROR_DESCRIPTION_FORMAT);
}
#endif

#ifdef SIMDOP_PLANNING
/* Around the post there is a path, whose motions are free, and whose share of the straight one is. */
void paths(const simdop::planner &planner, const std::array<double, 4> &start, const std::array<double, 4> &goal,
           simdop::body_id post) {
    auto workspace = must(planner.make_workspace());
    const std::vector<double> path = must(planner.plan(workspace, start, goal));
    EXPECT(path.size() >= 12 && path.size() % 4 == 0);
    std::vector<double> ends;
    for (std::size_t i = 0; i + 4 < path.size(); i += 4) {
        ends.insert(ends.end(), path.begin() + static_cast<std::ptrdiff_t>(i),
                    path.begin() + static_cast<std::ptrdiff_t>(i + 8));
    }
    std::vector<std::uint8_t> free(path.size() / 4 - 1);
    EXPECT(must(planner.check_motions(workspace, ends, free)) == free.size());
    simdop_plan_settings settings = simdop_plan_settings_default();
    settings.configurations = 0;
    EXPECT(must(planner.plan(workspace, start, goal, settings)).empty());
    settings.step = 0;
    EXPECT(code_of([&] { return planner.plan(workspace, start, goal, settings); }) == SIMDOP_ERROR_PLANNER_STEP);

    const double share = must(planner.free_share(workspace, start, goal));
    EXPECT(share > 0 && share < 1);
    std::array<double, 4> there = start;
    there[0] += share * (goal[0] - start[0]);
    EXPECT(must(planner.check_motion(workspace, start, there)).verdict == SIMDOP_MOTION_VERDICT_FREE);
    EXPECT(must(planner.check_motion_discrete(workspace, start, goal, 1)).verdict != SIMDOP_MOTION_VERDICT_HIT);
    EXPECT(must(planner.check_motion_discrete(workspace, start, goal, 100)).verdict == SIMDOP_MOTION_VERDICT_HIT);

    const std::array<double, 4> amid = {0, 1.2, 0.3, 0};
    int hits = 0;
    (void)must(planner.each_hit(workspace, amid, 0, [&](const simdop_scene_hit &hit) {
        hits += hit.a == post || hit.b == post;
    }));
    EXPECT(hits > 0);
    std::array<double, 4> gradient{}, signed_gradient{};
    const auto near = must(planner.clearance(workspace, there));
    DO(planner.clearance_gradient(workspace, near, gradient));
    (void)must(planner.signed_clearance(workspace, there, signed_gradient));
    for (std::size_t i = 0; i < 4; i++) {
        EXPECT(std::fabs(gradient[i] - signed_gradient[i]) < 1e-6);
    }
    EXPECT(must(planner.to_world(workspace, post, {0, 0, 0}))[0] == 0.45);

    std::array<double, 4> meeting{}, apart{};
    const simdop::body_id hand = must(planner.link("hand"));
    const auto report = must(planner.classify_pair(workspace, hand, post, 100000, meeting, apart));
    EXPECT(report.pair_class == SIMDOP_PAIR_CLASS_SOMETIMES && report.has_meeting && report.has_free);
    EXPECT(must(planner.within(workspace, meeting)).verdict == SIMDOP_VERDICT_HIT);

    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    const std::vector<double> drawn = must(planner.random_free(workspace, [&] { return unit(random); }, 1000));
    EXPECT(drawn.size() == 4 && must(planner.within(workspace, drawn)).verdict == SIMDOP_VERDICT_FREE);
    EXPECT(must(planner.random_free(workspace, [] { return 0.5; }, 0)).empty());
    bool is_thrown = false;
    try {
        (void)planner.random_free(workspace, []() -> double { throw 7; }, 10);
    } catch (int) {
        is_thrown = true;
    }
    EXPECT(is_thrown);

    simdop::planner bounded = must(planner.copy());
    DO(bounded.use_bounds(0.05));
    EXPECT(bounded.bound_bytes() > 0);
    std::array<std::uint8_t, 1> is_free{};
    EXPECT(must(bounded.check_states(workspace, amid, is_free)) == 0);
    DO(bounded.set_budget(0));
    EXPECT(must(bounded.within(workspace, amid)).verdict != SIMDOP_VERDICT_FREE);
    DO(bounded.set_resolution(-1));
    EXPECT(code_of([&] { return bounded.check_motion(workspace, start, there); }) == SIMDOP_ERROR_TOLERANCE);
}

/* The arm of the examples passes a post. */
void planners(const char *urdf, const char *srdf) {
    simdop::planner planner = must(simdop::planner::load(urdf, srdf));
    EXPECT(planner.variables() == 4 && must(planner.limits()).size() == 4);
    const simdop::body_id post =
        must(planner.insert(must(simdop::body::shape(simdop::cylinder(0.05, 2))), simdop::translation(0.45, 0, 1),
                            simdop::fixed()));
    const simdop::planner copy = must(planner.copy());
    DO(planner.remove(post));
    const std::array<double, 4> before = {-1, 1.2, 0.3, 0}, after = {1, 1.2, 0.3, 0}, amid = {0, 1.2, 0.3, 0};
    const std::array<double, 8> both = {before[0], 1.2, 0.3, 0, amid[0], 1.2, 0.3, 0};
    std::vector<std::thread> threads;
    std::array<int, 8> wrong{};
    for (std::size_t thread = 0; thread < 8; thread++) {
        threads.emplace_back([&, thread] {
            auto workspace = must(copy.make_workspace());
            std::array<std::uint8_t, 2> free{};
            wrong[thread] += must(copy.check_states(workspace, both, free)) != 1 || free[0] != 1;
            wrong[thread] += must(copy.check_motion(workspace, before, after)).verdict != SIMDOP_MOTION_VERDICT_HIT;
            wrong[thread] += must(copy.within(workspace, amid)).hit.b != post &&
                             must(copy.within(workspace, amid)).hit.a != post;
            wrong[thread] += !(must(copy.clearance(workspace, before)).lower > 0);
            /* Without the post. */
            wrong[thread] += must(planner.check_motion(workspace, before, after)).verdict !=
                             SIMDOP_MOTION_VERDICT_FREE;
        });
    }
    for (std::size_t thread = 0; thread < 8; thread++) {
        threads[thread].join();
        EXPECT(wrong[thread] == 0);
    }
    EXPECT(code_of([] { return simdop::planner::load("/nonexistent.urdf"); }) == SIMDOP_ERROR_PLANNER_FILE);
    paths(copy, before, after, post);

    simdop::planner grouped = must(copy.copy());
    const std::vector<std::string> groups = must(grouped.groups());
    EXPECT(groups.size() == 1 && groups[0] == "reach" && std::string(must(grouped.variable(0)).name) == "waist");
    DO(grouped.select_group(groups[0], before));
    EXPECT(grouped.variables() == 3 && std::string(must(grouped.variable(0)).name) == "shoulder");
    EXPECT(code_of([&] { return grouped.variable(99); }) == SIMDOP_ERROR_DESCRIPTION_INDEX);
}
#endif

} // namespace

int main(int count, char **arguments) {
#ifdef SIMDOP_PLANNING
    EXPECT(count == 3);
    planners(arguments[1], arguments[2]);
#else
    (void)count, (void)arguments;
#endif
    two_bodies();
    errors();
    scenes();
    clouds();
    states();
#ifdef SIMDOP_URDF
    descriptions();
#endif
    std::puts("all as expected");
    return EXIT_SUCCESS;
}
