/*
 * simdop: exact collision and distance queries between bodies of triangles or spheres.
 *
 * Bodies. A body is opened from the bytes of a baked tree, or built. Its tree is of k = 18 and arity 16, which `simdop build`
 * makes unless told otherwise. A query asks about two bodies, A and B, and a pose that places A in the frame of B. A scene
 * has many bodies, at poses in the world.
 *
 * An edge of a planner asks whether moving bodies meet anywhere on their way: at all times from 0 to 1, not at samples of them.
 * A robot moves bodies by joints.
 *
 * Units. The library knows none: coordinates, translations, radii, margins and distances are all in the same one. They are
 * at most 2^300, and those below 2^-250 count as zero. Angles are in radians.
 *
 * Errors. A function that can fail returns a simdop_error, which is 0 of success. After a failure nothing is written where an
 * answer goes, and NULL where a handle goes. simdop_error_text() says what a code means, simdop_last_error() has the whole
 * message of the last failure.
 *
 * Pointers. NULL is an error, except where a handle is destroyed. Any other pointer must lead to as many items as are said,
 * which nobody writes during the call. No output may overlap an input.
 *
 * Lifetimes. Opened bytes must stay, unchanged, until their body is destroyed. A body must stay until it is removed from each
 * scene that it was put into, or the scene is destroyed.
 *
 * Threads. Any number of them may use a handle at once where it is a pointer to const. Who changes or destroys it must be
 * alone with it. Messages belong to the thread that the failure was on.
 *
 * Linking. With libsimdop_capi.so, or libsimdop_capi.a and on Linux -lpthread -lm -ldl.
 *
 * Memory. Queries allocate nothing, except for the message where they fail, and for edges: see SIMDOP_EDGE_ROOM. They take
 * 64 KiB of stack at most.
 */

#ifndef SIMDOP_H
#define SIMDOP_H

/* Made by cbindgen from capi/src: `cargo test` in capi makes it anew. */

#include <stddef.h>
#include <stdint.h>

/**
 * As many visits as it takes: then no answer is unknown.
 */
#define SIMDOP_NO_BUDGET UINT64_MAX

/**
 * The index of a primitive where there is none.
 */
#define SIMDOP_NO_PRIMITIVE UINT32_MAX

/**
 * In every group, or against every group.
 */
#define SIMDOP_ALL_GROUPS UINT32_MAX

/**
 * Pairs of bodies that a query of an edge has room for, each in an interval of time which it has yet to ask about: two for each
 * pair of bodies that come near each other, and more where these come close. Those there is no room for are unresolved. A scene
 * allocates this room, 768 KiB, at its first edge, and keeps it; its later edges allocate nothing, unless more bodies move, or a
 * robot of more joints or variables.
 */
#define SIMDOP_EDGE_ROOM 65536

/**
 * What a function came to. The numbers stay what they are.
 */
typedef enum {
  /**
   * Success.
   */
  SIMDOP_ERROR_NONE = 0,
  /**
   * A pointer is NULL.
   */
  SIMDOP_ERROR_NULL = 1,
  /**
   * A pointer is not aligned: the bytes of a tree to 64, an array to its items.
   */
  SIMDOP_ERROR_MISALIGNED = 2,
  /**
   * An array is larger than there can be, or than a body may be.
   */
  SIMDOP_ERROR_TOO_LARGE = 3,
  /**
   * A defect of the library, which is printed to stderr, too. Handles that were part of the call may only be destroyed.
   */
  SIMDOP_ERROR_PANIC = 4,
  /**
   * An error that has no code of its own: see simdop_last_error().
   */
  SIMDOP_ERROR_OTHER = 5,
  /**
   * A pose has an entry that is NaN or infinite.
   */
  SIMDOP_ERROR_POSE_NOT_FINITE = 10,
  /**
   * A pose's translation is too long: beyond 2^300, in a scene 2^298.
   */
  SIMDOP_ERROR_POSE_TOO_FAR = 11,
  /**
   * A pose's matrix is no rotation: an entry of its product with its transpose is off by more than 1e-4, in a scene 1.5e-5.
   */
  SIMDOP_ERROR_POSE_NOT_ORTHONORMAL = 12,
  /**
   * A pose's matrix mirrors.
   */
  SIMDOP_ERROR_POSE_MIRRORED = 13,
  /**
   * The squared length of a quaternion is off 1 by more than 1e-4.
   */
  SIMDOP_ERROR_POSE_NOT_UNIT = 14,
  /**
   * The bytes are not a baked tree.
   */
  SIMDOP_ERROR_BYTES_NOT_A_TREE = 20,
  /**
   * The tree has a layout of another version: bake it anew.
   */
  SIMDOP_ERROR_BYTES_VERSION = 21,
  /**
   * The tree is neither of triangles nor of spheres.
   */
  SIMDOP_ERROR_BYTES_OTHER_PRIMITIVE = 22,
  /**
   * The tree's k and arity are not 18 and 16: bake it anew.
   */
  SIMDOP_ERROR_BYTES_OTHER_NODE = 23,
  /**
   * The bytes end early.
   */
  SIMDOP_ERROR_BYTES_TRUNCATED = 24,
  /**
   * Bytes follow after the end of the tree.
   */
  SIMDOP_ERROR_BYTES_TOO_LONG = 25,
  /**
   * A field of the tree's header cannot be.
   */
  SIMDOP_ERROR_BYTES_HEADER = 26,
  /**
   * A node of the tree cannot be.
   */
  SIMDOP_ERROR_BYTES_NODE = 27,
  /**
   * A vertex in the bytes is not finite or out of range.
   */
  SIMDOP_ERROR_BYTES_VERTEX = 28,
  /**
   * A primitive in the bytes names a vertex that there is not.
   */
  SIMDOP_ERROR_BYTES_PRIMITIVE = 29,
  /**
   * A primitive in the bytes had an index that is not below their number.
   */
  SIMDOP_ERROR_BYTES_SOURCE = 30,
  /**
   * What stands for a part in the bytes cannot.
   */
  SIMDOP_ERROR_BYTES_PART = 31,
  /**
   * A vertex is NaN, infinite, or beyond 2^300.
   */
  SIMDOP_ERROR_BUILD_VERTEX = 40,
  /**
   * A sphere's radius is negative, NaN or infinite, or takes it beyond 2^300.
   */
  SIMDOP_ERROR_BUILD_RADIUS = 41,
  /**
   * All coordinates are below 2^-250: choose a smaller unit.
   */
  SIMDOP_ERROR_BUILD_TOO_SMALL = 42,
  /**
   * A triangle names a vertex that there is not.
   */
  SIMDOP_ERROR_BUILD_PRIMITIVE = 43,
  /**
   * What shall be solid is not closed, or its triangles are not oriented alike.
   */
  SIMDOP_ERROR_BUILD_OPEN = 44,
  /**
   * A margin, tolerance or cutoff is negative, NaN or too large, or a resolution is NaN or not above 0.
   */
  SIMDOP_ERROR_TOLERANCE = 60,
  /**
   * The body is not in the scene, or not any more.
   */
  SIMDOP_ERROR_SCENE_NO_SUCH_BODY = 70,
  /**
   * A body's radius in a scene is negative, NaN or beyond 2^300.
   */
  SIMDOP_ERROR_SCENE_RADIUS = 71,
  /**
   * The body is attached to another.
   */
  SIMDOP_ERROR_SCENE_IS_ATTACHED = 72,
  /**
   * A body would be attached to itself.
   */
  SIMDOP_ERROR_SCENE_CYCLE = 73,
  /**
   * A body is no pair with itself.
   */
  SIMDOP_ERROR_SCENE_NO_PAIR = 74,
  /**
   * A motion's `go_to` stopped the query.
   */
  SIMDOP_ERROR_MOTION_STOPPED = 80,
  /**
   * An edge is asked about in no parts.
   */
  SIMDOP_ERROR_MOTION_NO_PARTS = 81,
  /**
   * A motion moves more or fewer bodies than are named.
   */
  SIMDOP_ERROR_MOTION_BODIES = 82,
  /**
   * A joint or a body is on a link that does not come before it.
   */
  SIMDOP_ERROR_MOTION_NO_SUCH_LINK = 83,
  /**
   * A joint is moved by a variable that has no limits.
   */
  SIMDOP_ERROR_MOTION_NO_SUCH_VARIABLE = 84,
  /**
   * The limits of a variable are no interval.
   */
  SIMDOP_ERROR_MOTION_LIMITS = 85,
  /**
   * An axis is no direction: zero, or not finite.
   */
  SIMDOP_ERROR_MOTION_NO_DIRECTION = 86,
  /**
   * A number of a motion is not finite.
   */
  SIMDOP_ERROR_MOTION_NOT_FINITE = 87,
  /**
   * There are more or fewer values than variables.
   */
  SIMDOP_ERROR_MOTION_LENGTH = 88,
  /**
   * A value is outside of the limits of its variable.
   */
  SIMDOP_ERROR_MOTION_OUT_OF_LIMITS = 89,
  /**
   * A joint's kind is none of simdop_joint_kind.
   */
  SIMDOP_ERROR_MOTION_NO_SUCH_KIND = 90,
} simdop_error;

/**
 * Whether bodies meet, or come within the margin. Touching counts.
 */
typedef enum {
  /**
   * They do not: certain.
   */
  SIMDOP_VERDICT_FREE = 0,
  /**
   * They do.
   */
  SIMDOP_VERDICT_HIT = 1,
  /**
   * The budget was spent before it was known: they may.
   */
  SIMDOP_VERDICT_UNKNOWN = 2,
} simdop_verdict;

/**
 * How a search ended.
 */
typedef enum {
  /**
   * By itself.
   */
  SIMDOP_COMPLETION_COMPLETE = 0,
  /**
   * The callback stopped it.
   */
  SIMDOP_COMPLETION_STOPPED = 1,
  /**
   * The budget was spent.
   */
  SIMDOP_COMPLETION_OUT_OF_BUDGET = 2,
} simdop_completion;

/**
 * What became of an edge.
 */
typedef enum {
  /**
   * No two bodies that are asked against each other meet at any time from 0 to 1: certain.
   */
  SIMDOP_MOTION_VERDICT_FREE = 0,
  /**
   * Two bodies meet at a time. It need not be the first.
   */
  SIMDOP_MOTION_VERDICT_HIT = 1,
  /**
   * No hit was found, but within an interval of time something may meet.
   */
  SIMDOP_MOTION_VERDICT_UNRESOLVED = 2,
} simdop_motion_verdict;

/**
 * What a joint does.
 */
typedef enum {
  /**
   * Turns about its axis, by its value in radians.
   */
  SIMDOP_JOINT_KIND_REVOLUTE = 0,
  /**
   * Slides along its axis, by its value in the unit of length.
   */
  SIMDOP_JOINT_KIND_PRISMATIC = 1,
} simdop_joint_kind;

/**
 * A body: a set of primitives, triangles or spheres, and the tree over them. It never changes.
 */
typedef struct simdop_body simdop_body;

/**
 * A robot: joints, the limits of the variables that move them, and where bodies are on the links. Which bodies these are it
 * does not know: those of a scene are named with each question.
 */
typedef struct simdop_robot simdop_robot;

/**
 * Bodies, placed in the world.
 */
typedef struct simdop_scene simdop_scene;

/**
 * A rigid motion x -> R x + t: the three rows of [R|t]. Fill it in, or use simdop_pose_from_quaternion(). Every function that
 * takes one checks it: R R^T may differ from 1 by 1e-4, in a scene by 1.5e-5, and R must not mirror.
 */
typedef struct {
  /**
   * R, with t as the last column.
   */
  double rows[3][4];
} simdop_pose;

/**
 * Two primitives, by their indices in what was built; SIMDOP_NO_PRIMITIVE where there are none.
 */
typedef struct {
  /**
   * Primitive of body A.
   */
  uint32_t a;
  /**
   * Primitive of body B.
   */
  uint32_t b;
} simdop_pair;

/**
 * The work of a query: the same on every machine.
 */
typedef struct {
  /**
   * Pairs of nodes, or of a node and a leaf: the unit of the budget.
   */
  uint64_t visits;
  /**
   * Overlap kernels called.
   */
  uint64_t kernels;
  /**
   * Nodes whose children were turned into the other body's frame.
   */
  uint64_t realignments;
  /**
   * Pairs of primitives tested.
   */
  uint64_t primitive_pairs;
  /**
   * Of these, the ones that needed exact arithmetic.
   */
  uint64_t exact_pairs;
} simdop_query_stats;

/**
 * The answer of simdop_collide() and simdop_within().
 */
typedef struct {
  /**
   * The verdict.
   */
  simdop_verdict verdict;
  /**
   * Of a hit: primitives that meet, or come within the margin. Of a body that is inside of a solid, one of the part that is
   * inside and one of the solid's.
   */
  simdop_pair pair;
  /**
   * Of an unknown verdict: the distance of the bodies is at least this. Otherwise 0.
   */
  double lower;
  /**
   * Of an unknown verdict: the distance of the bodies is at most this. Otherwise infinite.
   */
  double upper;
  /**
   * The work.
   */
  simdop_query_stats stats;
} simdop_answer;

/**
 * The answer of simdop_distance(): the distance lies in lower ..= upper.
 */
typedef struct {
  /**
   * Whether the bodies meet.
   */
  simdop_verdict verdict;
  /**
   * Whether the bounds are as near to each other as was asked. They hold in any case.
   */
  simdop_completion completion;
  /**
   * Lower bound: infinite if a body is empty.
   */
  double lower;
  /**
   * Upper bound: infinite if a body is empty, or the budget was spent before a witness was found. 0 if and only if the
   * witnesses meet, or one body is inside of the other, which is solid.
   */
  double upper;
  /**
   * Two primitives that are `upper` apart, if that is finite.
   */
  simdop_pair pair;
  /**
   * Where they are closest: the point of A, in B's frame, up to rounding. NaN if there is no witness.
   */
  double point_a[3];
  /**
   * The point of B, in B's frame.
   */
  double point_b[3];
  /**
   * The work.
   */
  simdop_query_stats stats;
} simdop_distance_answer;

/**
 * A joint, and the link that it moves: the link behind joint i is link i + 1, and link 0 is the base. A joint that does not
 * move is none: what is behind it belongs to the link before.
 */
typedef struct {
  /**
   * What it does: one of simdop_joint_kind.
   */
  uint32_t kind;
  /**
   * The link that it is on, which comes before its own: at most i for joint i.
   */
  uint32_t parent;
  /**
   * The index of the variable that moves it. Of a joint that mimics another, the other's.
   */
  uint32_t variable;
  /**
   * Where it stands in the frame of the link that it is on.
   */
  simdop_pose origin;
  /**
   * Its axis in its own frame: a direction of any length.
   */
  double axis[3];
  /**
   * Its value is `multiplier` times its variable, plus `offset`. 1, unless it mimics another.
   */
  double multiplier;
  /**
   * In radians, or in the unit of length. 0, unless it mimics another.
   */
  double offset;
} simdop_joint;

/**
 * A body on a link.
 */
typedef struct {
  /**
   * The link: 0 is the base.
   */
  uint32_t link;
  /**
   * Where the body stands in the link's frame.
   */
  simdop_pose pose;
} simdop_link_body;

/**
 * What a body is in a scene. Begin with simdop_role_default(): of all zeros it is in no group, and asked against none.
 */
typedef struct {
  /**
   * Everything within this of the body's primitives belongs to it, too. Not negative.
   */
  double radius;
  /**
   * Not 0: the body stands still. No two of these are asked against each other. It may be placed anew all the same.
   */
  int is_fixed;
  /**
   * The groups that the body is in: bit i is group i.
   */
  uint32_t groups;
  /**
   * The groups that it is asked against. Two bodies are, if each is in a group that the other names here.
   */
  uint32_t against;
} simdop_role;

/**
 * A body in its scene, and in no other one. That of a body which was removed is an error, until its place was taken 2^32 times.
 */
typedef uint64_t simdop_body_id;

/**
 * Two bodies that meet, and where; SIMDOP_NO_BODY and SIMDOP_NO_PRIMITIVE where there are none.
 */
typedef struct {
  /**
   * One of the bodies.
   */
  simdop_body_id a;
  /**
   * The other.
   */
  simdop_body_id b;
  /**
   * Primitives of theirs.
   */
  simdop_pair pair;
} simdop_scene_hit;

/**
 * The answer of simdop_scene_collide() and simdop_scene_within().
 */
typedef struct {
  /**
   * Whether any two bodies that are asked against each other meet, or come within the margin.
   */
  simdop_verdict verdict;
  /**
   * Of a hit: the first that was found.
   */
  simdop_scene_hit hit;
  /**
   * Pairs of bodies whose boxes were near each other, and which were asked about.
   */
  uint64_t pairs;
  /**
   * The work for these pairs.
   */
  simdop_query_stats stats;
} simdop_scene_answer;

/**
 * The answer of simdop_scene_clearance(): the least distance of any two bodies lies in lower ..= upper.
 */
typedef struct {
  /**
   * Whether the bounds are as near to each other as was asked. They hold in any case.
   */
  simdop_completion completion;
  /**
   * Lower bound: the cutoff, if no two are nearer.
   */
  double lower;
  /**
   * Upper bound: infinite if no two were found that are nearer than the cutoff. 0 if and only if two meet.
   */
  double upper;
  /**
   * Bodies that are `upper` apart, and their primitives, if that is finite.
   */
  simdop_scene_hit hit;
  /**
   * Where the primitives are closest: the point of `hit.a`'s in the world, up to rounding. A body's radius is not heeded.
   * NaN if there is no hit.
   */
  double point_a[3];
  /**
   * The point of `hit.b`'s.
   */
  double point_b[3];
  /**
   * Pairs of bodies that were asked about.
   */
  uint64_t pairs;
  /**
   * The work for these pairs.
   */
  simdop_query_stats stats;
} simdop_scene_clearance_answer;

/**
 * Is called with each hit: 0 goes on, anything else stops. It must return, without an exception or a longjmp(), and must not
 * change the scene, which it may ask.
 */
typedef int (*simdop_on_hit)(void *user, const simdop_scene_hit *hit);

/**
 * What simdop_scene_each_hit() came to.
 */
typedef struct {
  /**
   * How it ended: hits may be missing unless it is complete.
   */
  simdop_completion completion;
  /**
   * Pairs of bodies that were asked about.
   */
  uint64_t pairs;
  /**
   * The work for these pairs.
   */
  simdop_query_stats stats;
} simdop_scene_hits;

/**
 * A motion of some bodies over the times from 0 to 1, by functions of the caller's. They get `user`, and bodies by their place
 * in the list of those that move. They must return, without an exception or a longjmp(), and must not use the scene that the
 * question is about. At the same time a motion must always have the same poses and paths.
 */
typedef struct {
  /**
   * What the functions are called with. May be NULL.
   */
  void *user;
  /**
   * Writes where all bodies are in the world at a time: as many poses as bodies move, each of which is then checked. One that
   * is left as it was is SIMDOP_ERROR_POSE_NOT_FINITE. Returns 0; anything else stops the query with
   * SIMDOP_ERROR_MOTION_STOPPED, for instance because it takes too long.
   */
  int (*go_to)(void *user, double time, simdop_pose *poses);
  /**
   * How far a point of a ball, which a body carries as if the ball were part of it, gets at most from where it is at the time
   * last gone to, at any time that is at most `span` before or after, within 0 to 1. `centre` has three numbers: where the
   * ball's centre is in the world at the time last gone to.
   *
   * The verdict rests on this bound: one that is too small makes verdicts wrong. It must have room for the rounding of the
   * poses that are written. One that is larger than need be only costs time. NaN, a negative number and one beyond 2^300
   * count as infinite, by which nothing is certified.
   */
  double (*path)(void *user, size_t body, const double *centre, double radius, double span);
  /**
   * The same of two balls that two moving bodies carry, as one sees the other: no two points of theirs come nearer to each
   * other than they are at the time last gone to by more than this. May be NULL: then it is the sum of both paths. More
   * than that it need never be, and less it is where both bodies are moved by the same, as the links of an arm are.
   */
  double (*motion_bound_between)(void *user,
                                 size_t body_a,
                                 const double *centre_a,
                                 double radius_a,
                                 size_t body_b,
                                 const double *centre_b,
                                 double radius_b,
                                 double span);
} simdop_motion;

/**
 * The answer of simdop_scene_check_motion() and its like.
 */
typedef struct {
  /**
   * The verdict.
   */
  simdop_motion_verdict verdict;
  /**
   * Of a hit: the bodies, and primitives of theirs that meet.
   */
  simdop_scene_hit hit;
  /**
   * Of a hit: when. Otherwise NaN.
   */
  double time;
  /**
   * Of an unresolved verdict: when the first interval begins about which nothing is known. Before, nothing meets, unless
   * this is the answer about samples. Otherwise NaN.
   */
  double from;
  /**
   * When that interval ends: not more than the resolution later, if neither budget nor room ended the query.
   */
  double to;
  /**
   * At how many times the bodies were placed.
   */
  uint64_t times;
  /**
   * Pairs of bodies that were asked about, once for each time.
   */
  uint64_t pairs;
  /**
   * The work for these pairs.
   */
  simdop_query_stats stats;
} simdop_motion_answer;

/**
 * The id of a body where there is none.
 */
#define SIMDOP_NO_BODY UINT64_MAX

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Opens a body of triangles or spheres from the bytes of a baked tree, in place, after a check that they are safe to walk,
 * which takes time in proportion to them.
 *
 * # Safety
 * There are `count` bytes, which must stay unchanged until the body is destroyed. They must start at a multiple of 64.
 */
simdop_error simdop_body_open(const uint8_t *bytes,
                              size_t count,
                              simdop_body **body);

/**
 * Builds the body that is the surface of triangles, closed or not: what is inside of it without touching it is free.
 * `vertices` are `vertex_count` times x, y, z; `triangles` are `triangle_count` times three indices of vertices. Both are
 * copied. Without triangles the body is empty, and meets nothing.
 *
 * # Safety
 * The arrays have so many items.
 */
simdop_error simdop_body_build_surface(const double *vertices,
                                       size_t vertex_count,
                                       const uint32_t *triangles,
                                       size_t triangle_count,
                                       simdop_body **body);

/**
 * Builds the solid that closed triangles bound: what is wholly inside of it is a hit, too. Otherwise as
 * simdop_body_build_surface().
 *
 * # Safety
 * The arrays have so many items.
 */
simdop_error simdop_body_build_solid(const double *vertices,
                                     size_t vertex_count,
                                     const uint32_t *triangles,
                                     size_t triangle_count,
                                     simdop_body **body);

/**
 * Builds a body of spheres, which are solid: `count` times x, y, z and a radius.
 *
 * # Safety
 * The array has so many items.
 */
simdop_error simdop_body_build_spheres(const double *spheres, size_t count, simdop_body **body);

/**
 * The bytes of a body's tree: write them to a file or to flash, and open them there. They belong to the body, or to who
 * opened it, and are there as long.
 */
simdop_error simdop_body_bytes(const simdop_body *body,
                               const uint8_t **bytes,
                               size_t *count);

/**
 * Destroys a body, and the bytes that were built for it. Of NULL, nothing.
 */
void simdop_body_destroy(simdop_body *body);

/**
 * What a code means, in a few words: a text that is there for ever. Of a number that is no code, that it is none.
 */
const char *simdop_error_text(int code);

/**
 * The message of the last failure on this thread, with its details: which vertex, which value. Empty before the first one.
 * It stays until the next failure on this thread; success does not clear it.
 */
const char *simdop_last_error(void);

/**
 * The pose of a quaternion (x, y, z, w), whose squared length may differ from 1 by 1e-4, and a translation.
 *
 * # Safety
 * `xyzw` are four numbers, `translation` three.
 */
simdop_error simdop_pose_from_quaternion(const double *xyzw, const double *translation, simdop_pose *pose);

/**
 * Does body `a`, placed by `a_in_b` in the frame of body `b`, meet `b`? The verdict is exact. Gives up after `budget` visits.
 */
simdop_error simdop_collide(const simdop_body *a,
                            const simdop_body *b,
                            const simdop_pose *a_in_b,
                            uint64_t budget,
                            simdop_answer *answer);

/**
 * Do the bodies come within `margin`, finite and not negative, of each other? Never falsely free. Otherwise as
 * simdop_collide().
 */
simdop_error simdop_within(const simdop_body *a,
                           const simdop_body *b,
                           const simdop_pose *a_in_b,
                           double margin,
                           uint64_t budget,
                           simdop_answer *answer);

/**
 * How far apart are the bodies? The bounds are as near to each other as `tolerance`, relative to the distance, finite and not
 * negative; 0 is as near as can be computed. Otherwise as simdop_collide(). The greater body is best given as `b`.
 */
simdop_error simdop_distance(const simdop_body *a,
                             const simdop_body *b,
                             const simdop_pose *a_in_b,
                             double tolerance,
                             uint64_t budget,
                             simdop_distance_answer *answer);

/**
 * Makes a robot whose base stands at `base` in the world, of `joint_count` joints, each behind those between it and the base,
 * of `body_count` bodies on its links, and of the limits of `variable_count` variables: that many times the lower and the upper
 * one, both finite. All of it is copied.
 *
 * # Safety
 * The arrays have so many items.
 */
simdop_error simdop_robot_new(const simdop_pose *base,
                              const simdop_joint *joints,
                              size_t joint_count,
                              const simdop_link_body *bodies,
                              size_t body_count,
                              const double *limits,
                              size_t variable_count,
                              simdop_robot **robot);

/**
 * Forward kinematics: where the bodies of a robot stand in the world at some values of its variables. `values` has a number
 * for each variable, within its limits, and `poses` a place for each body. The robot is not const, for its memory is used.
 *
 * # Safety
 * There are so many numbers and places.
 */
simdop_error simdop_robot_poses(simdop_robot *robot,
                                const double *values,
                                simdop_pose *poses);

/**
 * Destroys a robot. Of NULL, nothing.
 */
void simdop_robot_free(simdop_robot *robot);

/**
 * A body that moves, of radius 0, in all groups and asked against all.
 */
simdop_role simdop_role_default(void);

/**
 * Makes a scene without bodies, which grows as they come.
 */
simdop_error simdop_scene_create(simdop_scene **scene);

/**
 * Destroys a scene, and none of its bodies. Of NULL, nothing.
 */
void simdop_scene_destroy(simdop_scene *scene);

/**
 * Puts a body into a scene, where it stands at `world`. One body may be put into several scenes, and into one several times.
 * It must stay until it is removed, or the scene is destroyed.
 */
simdop_error simdop_scene_insert(simdop_scene *scene,
                                 const simdop_body *body,
                                 const simdop_role *role,
                                 const simdop_pose *world,
                                 simdop_body_id *id);

/**
 * Takes a body out of a scene. Those that are attached to it stay where they are, and are attached no more.
 */
simdop_error simdop_scene_remove(simdop_scene *scene, simdop_body_id id);

/**
 * Places a body, and those that are attached to it. One that is attached is placed with the other only.
 */
simdop_error simdop_scene_place(simdop_scene *scene, simdop_body_id id, const simdop_pose *world);

/**
 * Attaches a body to another, which it is then placed with: it stays where it is as seen from there.
 */
simdop_error simdop_scene_attach(simdop_scene *scene, simdop_body_id id, simdop_body_id to);

/**
 * Attaches a body no more. It stays where it is. Of a body that is not attached, nothing.
 */
simdop_error simdop_scene_detach(simdop_scene *scene, simdop_body_id id);

/**
 * Allows two bodies to meet, whatever their groups: no question of the scene asks the pair.
 */
simdop_error simdop_scene_allow_collision(simdop_scene *scene, simdop_body_id a, simdop_body_id b);

/**
 * Forbids two bodies to meet, whatever their groups: all questions of the scene ask the pair.
 */
simdop_error simdop_scene_forbid_collision(simdop_scene *scene, simdop_body_id a, simdop_body_id b);

/**
 * Do any two bodies meet that are asked against each other? Gives up after `budget` visits for all pairs together.
 */
simdop_error simdop_scene_collide(const simdop_scene *scene,
                                  uint64_t budget,
                                  simdop_scene_answer *answer);

/**
 * Do any two bodies that are asked against each other come within `margin`, 0 to 2^300, in the world? Otherwise as
 * simdop_scene_collide().
 */
simdop_error simdop_scene_within(const simdop_scene *scene,
                                 double margin,
                                 uint64_t budget,
                                 simdop_scene_answer *answer);

/**
 * How near do two bodies come that are asked against each other, up to `cutoff`, which may be infinite? The bounds are as near
 * to each other as `tolerance`, relative to the distance between primitives, before radii are taken off. Otherwise as
 * simdop_scene_collide().
 */
simdop_error simdop_scene_clearance(const simdop_scene *scene,
                                    double tolerance,
                                    double cutoff,
                                    uint64_t budget,
                                    simdop_scene_clearance_answer *answer);

/**
 * Calls `on_hit` with `user` and every two bodies that are asked against each other and come within `margin`, each two once.
 * Otherwise as simdop_scene_within().
 *
 * # Safety
 * `user`, which may be NULL, is what `on_hit` takes it for.
 */
simdop_error simdop_scene_each_hit(const simdop_scene *scene,
                                   double margin,
                                   uint64_t budget,
                                   simdop_on_hit on_hit,
                                   void *user,
                                   simdop_scene_hits *hits);

/**
 * Do any two bodies that are asked against each other meet at any time of a motion of some of them, and of what is attached to
 * these? All others stand still. SIMDOP_MOTION_VERDICT_FREE is certain for all times from 0 to 1, not for samples of them, if the
 * motion's `path` is the bound that it should be.
 *
 * `moving` are the `count` bodies that move, in the motion's order; none of them is attached. No interval of time that is not
 * longer than `resolution`, above 0, is halved: what comes so near that this would be needed is unresolved. Gives up after
 * `budget` visits for all pairs and times together. Afterwards, and after a failure, the bodies stand where they stood.
 *
 * # Safety
 * There are `count` ids. `motion->user` is what the motion's functions take it for, and these do what is said of them.
 */
simdop_error simdop_scene_check_motion(simdop_scene *scene,
                                       const simdop_body_id *moving,
                                       size_t count,
                                       const simdop_motion *motion,
                                       double resolution,
                                       uint64_t budget,
                                       simdop_motion_answer *answer);

/**
 * The same question at some times only: at those that divide 0 to 1 into `parts` evenly, at least 1, both ends among them, in
 * an order that halves the longest gaps first, until one is a hit. The verdict is never SIMDOP_MOTION_VERDICT_FREE, but
 * unresolved from 0 to 1: between the times, nothing is known. The motion's `path` is not called, and may be NULL. Otherwise as
 * simdop_scene_check_motion().
 *
 * # Safety
 * As of simdop_scene_check_motion().
 */
simdop_error simdop_scene_check_motion_discrete(simdop_scene *scene,
                                                const simdop_body_id *moving,
                                                size_t count,
                                                const simdop_motion *motion,
                                                uint32_t parts,
                                                uint64_t budget,
                                                simdop_motion_answer *answer);

/**
 * As simdop_scene_check_motion(), of one body, and of what is attached to it, on its way from one pose in the world to another: it turns
 * evenly about an axis, by at most half a turn, and moves evenly along the axis. This screw is the one that leads there, and of
 * poses which differ in no turn is a straight line. It ends at `to` up to 1e-7 of the coordinates, and up to what the matrices
 * are off a rotation. Where the body stands in the scene does not matter.
 */
simdop_error simdop_scene_check_screw(simdop_scene *scene,
                                      simdop_body_id id,
                                      const simdop_pose *from,
                                      const simdop_pose *to,
                                      double resolution,
                                      uint64_t budget,
                                      simdop_motion_answer *answer);

/**
 * As simdop_scene_check_motion(), of the bodies of a robot, and of what is attached to these, while each of its variables changes
 * evenly from one value to another. `from` and `to` have a number for each variable, within its limits. `moving` are the
 * robot's bodies, in its order: with more or fewer of them this is SIMDOP_ERROR_MOTION_BODIES. Where they stand in the scene
 * does not matter.
 *
 * # Safety
 * There are `count` ids, and a number for each variable in both arrays.
 */
simdop_error simdop_scene_check_joint_motion(simdop_scene *scene,
                                             const simdop_body_id *moving,
                                             size_t count,
                                             const simdop_robot *robot,
                                             const double *from,
                                             const double *to,
                                             double resolution,
                                             uint64_t budget,
                                             simdop_motion_answer *answer);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SIMDOP_H */
