// C API of Cranny, which plans grasps and motions of robot arms in confined spaces and proves them free of collision.
//
// Made by cbindgen from the sources of crates/capi; do not edit. docs/cpp.md is the guide, cranny.hpp the wrapper for C++17.
//
// Failures. A function that returns a CrannyStatus returns CRANNY_STATUS_OK, or leaves its reason as text for
// cranny_last_error, and nothing that it should write may be used. Other functions return NULL, 0, false or NaN for a handle that
// is NULL, with the same text. No exception and no panic leaves a function.
//
// Handles. A function that makes one writes it to its last argument; the caller frees it with the function of its type, once.
// Handles do not depend on each other: any may be freed first. Texts and arrays that a function returns belong to the handle.
//
// Arrays. The caller allocates them and states their lengths: `rows` configurations of `dof` values each are `rows` x `dof`
// consecutive numbers, row by row. A wrong `dof` and NULL are refused; an array that is shorter than stated is not detected.
// Texts are UTF-8 and end with a zero byte.
//
// Threads. Any function may be called in any thread, also at the same time on the same handle if the function takes it as const.
// A handle that is not const (a world that is added to, a handle that is freed) must have no other user meanwhile. Checks on one
// cell wait for each other; give each thread its own by cranny_cell_clone. The last error is that of the thread.
//
// Units. Metres, radians, seconds. Poses are homogeneous 4 x 4 matrices in the planning frame, the root frame of the robot.


#ifndef CRANNY_H
#define CRANNY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Version of the binary interface that this header describes. It grows with every change that an old program would notice.
#define CRANNY_ABI_VERSION 1

// Result of a call. After any other than CRANNY_STATUS_OK, cranny_last_error gives the reason as text, and nothing that the
// call should write may be used. A negative result (not free, not found, not valid) is no failure.
typedef enum {
  // The call did what it promises.
  CRANNY_STATUS_OK = 0,
  // An argument is NULL, has a wrong length, is not finite, or names something that does not exist.
  CRANNY_STATUS_ARGUMENT = 1,
  // A file, a text or a problem is refused; the text names its place and gives a hint.
  CRANNY_STATUS_REFUSED = 2,
  // A fault of Cranny itself. The handles stay usable; please report the text.
  CRANNY_STATUS_INTERNAL = 3,
} CrannyStatus;

// Result of the check of a straight motion between two configurations.
typedef enum {
  // All of the motion is proven free.
  CRANNY_MOTION_KIND_PROVEN = 0,
  // Some point of it is in contact, or closer than demanded.
  CRANNY_MOTION_KIND_CONTACT = 1,
  // Contact is neither found nor excluded: a pair comes within 1 µm of the required clearance.
  CRANNY_MOTION_KIND_UNRESOLVED = 2,
  // A bound of the tool is exceeded, or not proven.
  CRANNY_MOTION_KIND_OUT_OF_BOUNDS = 3,
  // An end is out of the joint limits.
  CRANNY_MOTION_KIND_OUT_OF_LIMITS = 4,
} CrannyMotionKind;

// Robot in a world, for checks of configurations and whole motions, and for clearances.
//
// Links and bodies are solids; pairs nearer than 10 µm, or than a required margin, count as contact. The results equal those
// of Rust and Python, bit for bit. A cell never changes, but has memory to compute in: checks of several threads on one cell
// wait for each other, so give each thread its own by cranny_cell_clone.
typedef struct CrannyCell CrannyCell;

// Set of grasps of an object. It never changes.
//
// A grasp is a pose of the gripper frame: its origin lies between the finger pads, y is the axis on which the fingers close, z
// points out of the palm; two equal pads turned by 180° about z are the same grasp. Poses are in the planning frame, those of
// cranny_grasps_sample in the frame of the mesh.
typedef struct CrannyGrasps CrannyGrasps;

// Result of planning: a path, its timing, its proof and the statistics of the search. It never changes.
typedef struct CrannyPlan CrannyPlan;

// Robot: links, and the group of joints that moves them. It never changes.
//
// A configuration q has one value for each joint of the group, in the order of cranny_robot_joint_name: metres for a prismatic
// joint, radians for a revolute one. The robot's root frame is the planning frame, in which all poses are given.
typedef struct CrannyRobot CrannyRobot;

// Trajectory at `count` instants. It never changes. The arrays that the functions return are valid as long as it.
typedef struct CrannySamples CrannySamples;

// Task: a robot, its surroundings, the object to grasp and its grasps, or goal configurations. It never changes; functions
// that alter it make another.
typedef struct CrannyScenario CrannyScenario;

// Verdict on a path. It never changes.
typedef struct CrannyVerification CrannyVerification;

// Bodies, to which functions add. A cell or a scenario takes a copy of the bodies that there are when it is made.
//
// A pose is world_from_body in the planning frame: 16 values of a homogeneous matrix, row by row, in metres; NULL is the
// identity. Names are unique.
typedef struct CrannyWorld CrannyWorld;

// Pair of bodies or links that violates its required clearance. The names are valid as long as the cell, of which they are,
// and its clones.
typedef struct {
  // Name of the link; NULL if there is no contact.
  const char *first;
  // Name of another link, or of a body; NULL if there is no contact.
  const char *second;
  // Distance of the pair in metres; 0 if they overlap.
  double clearance_m;
  // Required clearance in metres.
  double required_m;
  // Penetration depth in metres; 0 if they are only too close.
  double depth_m;
  // Point in the overlap, in the planning frame, in metres; NaN if they are only too close.
  double point_m[3];
} CrannyContact;

// Proof of a straight motion, or the obstruction to it. The names are valid as long as the cell and its clones.
typedef struct {
  // Kind of the result.
  CrannyMotionKind kind;
  // Position along the motion, in [0, 1], at which it is not free; NaN if it is proven, or if an end is out of limits.
  double at;
  // Pair that touches or is undecided there; its names are NULL for the other kinds.
  CrannyContact contact;
  // Name of the joint that is out of limits, or of the bound that is exceeded; NULL for the other kinds.
  const char *name;
} CrannyMotion;

// Function that ends a search when it returns true. A search calls it between its iterations, in the thread of cranny_plan.
typedef bool (*CrannyShouldStop)(void *context);

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns the reason of the last failure in this thread, in one line or a few: UTF-8, empty before the first failure. It is
// valid until the next failure in this thread.
const char *cranny_last_error(void);

// Returns the version of the binary interface that the library has. A program may compare it with CRANNY_ABI_VERSION, the
// version that it was compiled for.
uint32_t cranny_abi_version(void);

// Returns the version of Cranny, such as "0.1.0". It is valid forever.
const char *cranny_version(void);

// Returns a built-in robot: "panda_mobile", "ur5e", "ur5e_mobile", "fr3" or "fetch_like". The caller frees it with
// cranny_robot_free.
CrannyStatus cranny_robot_builtin(const char *name,
                                  CrannyRobot **robot);

// Reads the URDF file or the robot folder at `path`, with the SRDF, the limits.yaml and the robot.yaml beside the URDF. The
// caller frees the robot with cranny_robot_free.
//
// `options`: NULL, or a JSON object with any of "srdf" (another file), "tip" (the link whose frame reaches the grasps),
// "joints" (names of the joints of q, in order) or "group" (a group of the SRDF), "fixed" (values of other joints by name, m or
// rad), "packages" (folders to search for package:// names), "meshes" ("hull" or "solid"), "unchecked_pairs" (pairs of links
// that may touch).
CrannyStatus cranny_robot_from_urdf(const char *path,
                                    const char *options,
                                    CrannyRobot **robot);

// Reads a robot from the text of a URDF without meshes. Options and ownership as in cranny_robot_from_urdf.
CrannyStatus cranny_robot_from_urdf_text(const char *text, const char *options, CrannyRobot **robot);

// Frees a robot. NULL is ignored. Cells and scenarios of the robot stay valid.
void cranny_robot_free(CrannyRobot *robot);

// Returns the robot's name in the URDF, valid as long as the robot; NULL for NULL.
const char *cranny_robot_name(const CrannyRobot *robot);

// Returns the number of joints, the length of each configuration; 0 for NULL.
size_t cranny_robot_dof(const CrannyRobot *robot);

// Returns the name of a joint, 0 <= `joint` < dof, valid as long as the robot; NULL for another.
const char *cranny_robot_joint_name(const CrannyRobot *robot, size_t joint);

// Returns the number of links; 0 for NULL.
size_t cranny_robot_link_count(const CrannyRobot *robot);

// Returns the name of a link, the root first, valid as long as the robot; NULL for an index that is too large.
const char *cranny_robot_link_name(const CrannyRobot *robot,
                                   size_t link);

// Returns the name of the link whose frame is the gripper frame, which reaches the grasps, valid as long as the robot.
const char *cranny_robot_tip(const CrannyRobot *robot);

// Writes the limits of the joints, `dof` values each, in m or rad, m/s or rad/s, m/s² or rad/s². Any of the arrays may be
// NULL. An acceleration that the robot's files do not state is NaN.
CrannyStatus cranny_robot_limits(const CrannyRobot *robot,
                                 size_t dof,
                                 double *lower,
                                 double *upper,
                                 double *velocity,
                                 double *acceleration);

// Writes the start configuration of the robot's files, `dof` values. A robot without one is an error.
CrannyStatus cranny_robot_start(const CrannyRobot *robot, double *q, size_t dof);

// Computes the pose root_from_link of `link` (NULL: the tip) at each of `rows` configurations `q`, `rows` × `dof`. `poses`
// receives `rows` × 16 values: homogeneous matrices, row by row, in metres. Limits are not checked.
CrannyStatus cranny_robot_fk(const CrannyRobot *robot,
                             const char *link,
                             const double *q,
                             size_t rows,
                             size_t dof,
                             double *poses);

// Computes the geometric Jacobian of `link` (NULL: the tip) at its origin, in the root frame, at each of `rows`
// configurations `q`, `rows` × `dof`. `jacobians` receives `rows` × 6 × `dof` values: first three rows of metres of the origin,
// then three rows of radians of its rotation, per metre or radian of each joint.
CrannyStatus cranny_robot_jacobian(const CrannyRobot *robot,
                                   const char *link,
                                   const double *q,
                                   size_t rows,
                                   size_t dof,
                                   double *jacobians);

// Writes `rows` uniform samples within the joint limits to `q`, `rows` × `dof`. The same `seed` gives the same samples on
// every machine.
CrannyStatus cranny_robot_sample(const CrannyRobot *robot,
                                 uint64_t seed,
                                 double *q,
                                 size_t rows,
                                 size_t dof);

// Searches configurations that bring the tip to `pose`, root_from_tip, 16 values row by row. `q` receives at most `rows`
// distinct solutions within the joint limits, `rows` × `dof`, and `found` their number; 0 proves nothing.
//
// At most `attempts` searches (200 is usual, 100000 the most) start at random configurations drawn from `seed`. `cell`: NULL,
// or a cell in which the solutions must be free.
CrannyStatus cranny_robot_ik(const CrannyRobot *robot,
                             const double *pose,
                             const CrannyCell *cell,
                             size_t attempts,
                             uint64_t seed,
                             double *q,
                             size_t rows,
                             size_t dof,
                             size_t *found);

// Searches a configuration that brings the tip to `pose`, root_from_tip, 16 values row by row, from `start`, `dof` values. `q`
// receives `dof` values if there is one, and `found` 1, else 0. `cell` as in cranny_robot_ik.
CrannyStatus cranny_robot_ik_from(const CrannyRobot *robot,
                                  const double *pose,
                                  const double *start,
                                  const CrannyCell *cell,
                                  double *q,
                                  size_t dof,
                                  size_t *found);

// Makes a world without a body. The caller frees it with cranny_world_free.
CrannyStatus cranny_world_new(CrannyWorld **world);

// Reads the collision objects of a MoveIt planning scene (YAML or JSON) in the frame of the robot's root. The caller frees the
// world with cranny_world_free.
CrannyStatus cranny_world_from_moveit_scene(const char *path,
                                            const CrannyRobot *robot,
                                            CrannyWorld **world);

// Frees a world. NULL is ignored.
void cranny_world_free(CrannyWorld *world);

// Returns the number of bodies; 0 for NULL.
size_t cranny_world_body_count(const CrannyWorld *world);

// Adds a box of full lengths `size`, 3 values in metres, centred at `pose`.
CrannyStatus cranny_world_add_box(CrannyWorld *world,
                                  const char *name,
                                  const double *size,
                                  const double *pose);

// Adds a sphere, centred at `pose`.
CrannyStatus cranny_world_add_sphere(CrannyWorld *world,
                                     const char *name,
                                     double radius_m,
                                     const double *pose);

// Adds a cylinder of full `length_m` along the z axis of `pose`, centred there.
CrannyStatus cranny_world_add_cylinder(CrannyWorld *world,
                                       const char *name,
                                       double radius_m,
                                       double length_m,
                                       const double *pose);

// Adds a capsule along the z axis of `pose`, centred there; `length_m` is that of its cylindrical section.
CrannyStatus cranny_world_add_capsule(CrannyWorld *world,
                                      const char *name,
                                      double radius_m,
                                      double length_m,
                                      const double *pose);

// Adds the solid that a closed mesh bounds: `vertices`, `vertex_count` × 3 in metres, and `triangles`, `triangle_count` × 3
// indices of vertices. With `hull` it is the convex hull of the vertices, and the mesh need not be closed.
CrannyStatus cranny_world_add_mesh(CrannyWorld *world,
                                   const char *name,
                                   const double *vertices,
                                   size_t vertex_count,
                                   const uint32_t *triangles,
                                   size_t triangle_count,
                                   bool hull,
                                   const double *pose);

// Adds a floor: everything below `height_m` in the planning frame. Its name is "floor".
CrannyStatus cranny_world_add_floor(CrannyWorld *world, double height_m);

// Makes a cell of a robot in a world. All checks require the clearance `margin_m` (m) between any two bodies or links. The
// caller frees it with cranny_cell_free. cranny_scenario_cell makes that of a scenario.
CrannyStatus cranny_cell_new(const CrannyRobot *robot,
                             const CrannyWorld *world,
                             double margin_m,
                             CrannyCell **cell);

// Makes a second handle of a cell, for another thread: they share everything but the memory of the checks. The caller frees it
// with cranny_cell_free.
CrannyStatus cranny_cell_clone(const CrannyCell *cell,
                               CrannyCell **clone);

// Frees a cell. NULL is ignored.
void cranny_cell_free(CrannyCell *cell);

// Makes a handle of the robot of a cell. The caller frees it with cranny_robot_free.
CrannyStatus cranny_cell_robot(const CrannyCell *cell, CrannyRobot **robot);

// Checks a configuration, `dof` values. `is_free` receives whether it is within the joint limits and every pair keeps its
// clearance; a value that is not finite is not within them.
CrannyStatus cranny_cell_is_free(const CrannyCell *cell,
                                 const double *q,
                                 size_t dof,
                                 bool *is_free);

// Checks `rows` configurations, `rows` × `dof`, as cranny_cell_is_free, several times as fast. `are_free` receives `rows`
// verdicts.
CrannyStatus cranny_cell_are_free(const CrannyCell *cell,
                                  const double *q,
                                  size_t rows,
                                  size_t dof,
                                  bool *are_free);

// Measures `rows` configurations, `rows` × `dof`. `clearances_m` receives `rows` values: the least distance over all pairs in
// metres, a certified lower bound; 0 in contact, infinite without any pair. Joint limits are not checked.
CrannyStatus cranny_cell_clearances(const CrannyCell *cell,
                                    const double *q,
                                    size_t rows,
                                    size_t dof,
                                    double *clearances_m);

// Finds the first pair at a configuration, `dof` values, that violates its clearance, in a fixed order, hand and wrist before
// the base. Without one, the names of `contact` are NULL. Joint limits are not checked.
CrannyStatus cranny_cell_first_contact(const CrannyCell *cell,
                                       const double *q,
                                       size_t dof,
                                       CrannyContact *contact);

// Checks the straight motion from `a` to `b`, `dof` values each, along its whole length; samples prove nothing.
CrannyStatus cranny_cell_motion(const CrannyCell *cell,
                                const double *a,
                                const double *b,
                                size_t dof,
                                CrannyMotion *motion);

// Checks `rows` straight motions, from each row of `a` to that of `b`, `rows` × `dof` both. `are_free` receives `rows` verdicts:
// whether the whole motion is proven free.
CrannyStatus cranny_cell_motions_are_free(const CrannyCell *cell,
                                          const double *a,
                                          const double *b,
                                          size_t rows,
                                          size_t dof,
                                          bool *are_free);

// Checks a path of `rows` way points, `rows` × `dof`, joined by straight lines. `motion` receives the first edge that is not
// proven, and `edge` its number from 0; if all are proven, `edge` is `rows` - 1. A path of one way point is a motion that stands
// still.
CrannyStatus cranny_cell_path(const CrannyCell *cell,
                              const double *path,
                              size_t rows,
                              size_t dof,
                              size_t *edge,
                              CrannyMotion *motion);

// Measures the straight motion from `a` to `b`, `dof` values each. `clearance_m` receives one value: the least distance over
// all pairs along it in metres, a certified lower bound, at most 10 µm too low; 0 if there is contact. Joint limits are not
// checked.
CrannyStatus cranny_cell_least_clearance(const CrannyCell *cell,
                                         const double *a,
                                         const double *b,
                                         size_t dof,
                                         double *clearance_m);

// Makes a set of `count` grasps at `poses`, `count` × 16: homogeneous matrices, row by row, in metres. `scores`: NULL, or
// `count` values in [0, 1]; NaN: unknown. The caller frees it with cranny_grasps_free.
CrannyStatus cranny_grasps_new(const double *poses,
                               const double *scores,
                               size_t count,
                               CrannyGrasps **grasps);

// Reads a grasps.csv: 16 numbers of the pose row by row, then score, width, robust score, robust trials and load. The caller
// frees it with cranny_grasps_free.
CrannyStatus cranny_grasps_load(const char *path,
                                CrannyGrasps **grasps);

// Samples antipodal grasps of an object, scored by the friction that they need: `vertices`, `vertex_count` × 3 in metres, and
// `triangles`, `triangle_count` × 3 indices of vertices. The caller frees the set with cranny_grasps_free.
//
// `options`: NULL, or a JSON object with any of "gripper" (a YAML file; otherwise the hand of the built-in robot), "count"
// (200), "candidates" (from which they are chosen; ten times as many), "friction" (0.35), "approaches" (directions about each
// closing axis, 12), "approach_m" (straight line that the open hand must have free, 0.05), "bare" (true: without the check
// of the hand), "seed" (0).
CrannyStatus cranny_grasps_sample(const double *vertices,
                                  size_t vertex_count,
                                  const uint32_t *triangles,
                                  size_t triangle_count,
                                  const char *options,
                                  CrannyGrasps **grasps);

// Frees a set of grasps. NULL is ignored.
void cranny_grasps_free(CrannyGrasps *grasps);

// Returns the number of grasps; 0 for NULL.
size_t cranny_grasps_count(const CrannyGrasps *grasps);

// Returns the poses, count × 16: homogeneous matrices, row by row, in metres. They are valid as long as the set.
const double *cranny_grasps_poses(const CrannyGrasps *grasps);

// Returns the scores, count values in [0, 1]; NaN: unknown. They are valid as long as the set.
const double *cranny_grasps_scores(const CrannyGrasps *grasps);

// Returns the indices of the grasps in the order of falling score, count values; grasps without a score come last. They are
// valid as long as the set.
const size_t *cranny_grasps_by_score(const CrannyGrasps *grasps);

// Writes a grasps.csv, whole or not at all.
CrannyStatus cranny_grasps_save(const CrannyGrasps *grasps, const char *path);

// Opens the scenario that `what` names: a built-in id such as "021", a folder in Cranny's own layout or in the paper's
// released one, or a packed .zip. "./021" is the folder. The caller frees it with cranny_scenario_free.
//
// `options`: NULL, or a JSON object with any of "criterion" ("exact" or "paper"), "robot" (another robot: a built-in name, a
// robot folder or a URDF), "geometry" ("scene" or "export", for a released scenario), "grasps" (a file of other grasps, or
// "none": the planner makes its own).
CrannyStatus cranny_scenario_open(const char *what,
                                  const char *options,
                                  CrannyScenario **scenario);

// Makes a scenario of a robot in a world. `start`: the start configuration, `dof` values; NULL with 0: the robot's own.
// `target`: name of the body to grasp, or NULL. `grasps`: grasps of the target; NULL: the planner makes its own. Without a
// target, set a goal with cranny_scenario_with_goals or cranny_scenario_with_grasps. The caller frees it with
// cranny_scenario_free.
CrannyStatus cranny_scenario_new(const CrannyRobot *robot,
                                 const CrannyWorld *world,
                                 const double *start,
                                 size_t dof,
                                 const char *target,
                                 const CrannyGrasps *grasps,
                                 CrannyScenario **scenario);

// Opens a planning scene and a motion plan request of MoveIt (YAML or JSON). The request's goals are configurations. The
// caller frees the scenario with cranny_scenario_free.
//
// `options`: NULL, or a JSON object with any of "robot" (a URDF) and "srdf"; otherwise the files beside the scene are taken
// that are called like its robot_model_name.
CrannyStatus cranny_scenario_from_moveit(const char *scene_path,
                                         const char *request_path,
                                         const char *options,
                                         CrannyScenario **scenario);

// Frees a scenario. NULL is ignored. Cells and plans of it stay valid.
void cranny_scenario_free(CrannyScenario *scenario);

// Returns the built-in id or the name of the folder, valid as long as the scenario; NULL for NULL.
const char *cranny_scenario_id(const CrannyScenario *scenario);

// Returns the differences between the scenario and MoveIt's files, a sentence in each line, valid as long as the scenario;
// empty if there are none.
const char *cranny_scenario_notes(const CrannyScenario *scenario);

// Makes a handle of the robot. The caller frees it with cranny_robot_free.
CrannyStatus cranny_scenario_robot(const CrannyScenario *scenario, CrannyRobot **robot);

// Makes the robot's cell, with target and floor, always with the exact geometry. `margin_m`: required clearance (m) between any
// two bodies or links; `grasp_margin_m`: that between the hand and the target or its support. The caller frees it with
// cranny_cell_free.
CrannyStatus cranny_scenario_cell(const CrannyScenario *scenario,
                                  double margin_m,
                                  double grasp_margin_m,
                                  CrannyCell **cell);

// Makes a handle of the grasps. The caller frees it with cranny_grasps_free.
CrannyStatus cranny_scenario_grasps(const CrannyScenario *scenario, CrannyGrasps **grasps);

// Writes the start configuration, `dof` values.
CrannyStatus cranny_scenario_start(const CrannyScenario *scenario, double *q, size_t dof);

// Makes a scenario with another start, `dof` values. The caller frees it with cranny_scenario_free.
CrannyStatus cranny_scenario_with_start(const CrannyScenario *scenario,
                                        const double *start,
                                        size_t dof,
                                        CrannyScenario **altered);

// Makes a scenario with `rows` goal configurations, `rows` × `dof`, instead of grasps; any of them is a goal. The caller frees
// it with cranny_scenario_free.
CrannyStatus cranny_scenario_with_goals(const CrannyScenario *scenario,
                                        const double *goals,
                                        size_t rows,
                                        size_t dof,
                                        CrannyScenario **altered);

// Makes a scenario with other grasps. Without a target, each is a pose that the gripper frame may reach. The caller frees it
// with cranny_scenario_free.
CrannyStatus cranny_scenario_with_grasps(const CrannyScenario *scenario,
                                         const CrannyGrasps *grasps,
                                         CrannyScenario **altered);

// Plans a scenario: searches for a path to a grasp or goal, shortens it, proves it and times it. A search without a result is
// no error: see cranny_plan_outcome. The caller frees the plan with cranny_plan_free.
//
// `options`: NULL, or a JSON object with the keywords of Python's cranny.plan, such as {"seed": 7, "time_limit_s": 2}. Usual
// ones: "planner" (a name), "seed" (0; the same seed and iterations give the same way points on every machine), "time_limit_s"
// (120), "iterations", "margin_m" and "grasp_margin_m" (clearances that the proof must show), "optimise_s" (seconds for better
// paths) and "cost", "speed" and "acceleration" (fractions of the limits), "tool_speed_m_s", "jerk_limited", "upright_deg",
// "carry" ("home", "out" or configurations), "goal_region", "place", "task", "robust". docs/cpp.md lists all.
//
// `should_stop`: NULL, or a function that is called with `context` and ends the search by returning true.
CrannyStatus cranny_plan(const CrannyScenario *scenario,
                         const char *options,
                         CrannyShouldStop should_stop,
                         void *context,
                         CrannyPlan **plan);

// Verifies a path from any source, `rows` × `dof` way points joined by straight lines, under the criterion of a scenario. The
// caller frees the verification with cranny_verification_free.
//
// `options`: NULL, or a JSON object with any of "margin_m", "grasp_margin_m" (required clearances in metres), "strict_pairs"
// (true: link pairs that are otherwise not compared count too), "any_end" (true: the path need not end at a goal).
CrannyStatus cranny_verify_path(const CrannyScenario *scenario,
                                const double *path,
                                size_t rows,
                                size_t dof,
                                const char *options,
                                CrannyVerification **verification);

// Reads a .plan.json of a scenario. No statement of the file is trusted: its path is verified again. The caller frees the plan
// with cranny_plan_free.
CrannyStatus cranny_plan_load(const char *path,
                              const CrannyScenario *scenario,
                              CrannyPlan **plan);

// Frees a plan. NULL is ignored.
void cranny_plan_free(CrannyPlan *plan);

// Returns whether a path was found and verified under the criterion; false for NULL.
bool cranny_plan_is_solved(const CrannyPlan *plan);

// Returns the outcome of the search: "solved", "budget-exhausted", "gave-up", "cancelled", "start-invalid", "goals-invalid" or
// "no-reachable-grasp". It is valid as long as the plan.
const char *cranny_plan_outcome(const CrannyPlan *plan);

// Returns the name of the planner, valid as long as the plan.
const char *cranny_plan_planner(const CrannyPlan *plan);

// Returns the number of way points; 0 without a path.
size_t cranny_plan_waypoint_count(const CrannyPlan *plan);

// Returns the number of joints of each way point; 0 for NULL.
size_t cranny_plan_dof(const CrannyPlan *plan);

// Returns the way points from the start to the goal, waypoint_count × dof, joined by straight lines. They are valid as long as
// the plan.
const double *cranny_plan_path(const CrannyPlan *plan);

// Returns the index of the grasp at the end of the path, or of the first pick; -1 without one.
int64_t cranny_plan_grasp(const CrannyPlan *plan);

// Returns the proven least clearance along the whole path in metres; NaN without a proof.
double cranny_plan_clearance_m(const CrannyPlan *plan);

// Returns the duration of the trajectory in seconds; NaN without one.
double cranny_plan_duration_s(const CrannyPlan *plan);

// Returns the content of the plan's file as JSON: segments, timing, statistics, reasons of a failure and the rest. It is valid
// as long as the plan.
const char *cranny_plan_json(const CrannyPlan *plan);

// Writes a .plan.json, whole or not at all.
CrannyStatus cranny_plan_save(const CrannyPlan *plan, const char *path);

// Verifies the path again, like any external path, from its way points alone, and the statements of its file. The caller frees
// the verification with cranny_verification_free. A plan without a path is an error.
CrannyStatus cranny_plan_verify(const CrannyPlan *plan,
                                CrannyVerification **verification);

// Samples the trajectory at `rate_hz` per second, with the end. The caller frees the samples with cranny_samples_free. A plan
// without a trajectory is an error.
CrannyStatus cranny_plan_sample(const CrannyPlan *plan,
                                double rate_hz,
                                CrannySamples **samples);

// Computes the state of the trajectory at `time_s` seconds from its beginning: at rest at the first way point before it, and at
// the last one after its end. `position`, `velocity` and `acceleration` receive `dof` values each, in m or rad, per s and s²; any
// of them may be NULL. A plan without a trajectory is an error.
CrannyStatus cranny_plan_state_at(const CrannyPlan *plan,
                                  double time_s,
                                  size_t dof,
                                  double *position,
                                  double *velocity,
                                  double *acceleration);

// Frees a verification. NULL is ignored.
void cranny_verification_free(CrannyVerification *verification);

// Returns whether the path meets the criterion; false for NULL.
bool cranny_verification_is_valid(const CrannyVerification *verification);

// Returns the least distance along the whole path in metres, a certified lower bound; NaN under the criterion "paper", or
// without pairs to check.
double cranny_verification_clearance_m(const CrannyVerification *verification);

// Returns the number of violations; 0 for NULL.
size_t cranny_verification_violation_count(const CrannyVerification *verification);

// Returns a violation as a sentence, in the order of the path, valid as long as the verification; NULL for an index that is
// too large.
const char *cranny_verification_violation(const CrannyVerification *verification,
                                          size_t violation);

// Returns everything that was found as JSON, as `cranny verify --json` writes it, valid as long as the verification.
const char *cranny_verification_json(const CrannyVerification *verification);

// Frees samples. NULL is ignored.
void cranny_samples_free(CrannySamples *samples);

// Returns the number of instants; 0 for NULL.
size_t cranny_samples_count(const CrannySamples *samples);

// Returns the number of joints; 0 for NULL.
size_t cranny_samples_dof(const CrannySamples *samples);

// Returns the times, count values, in seconds from 0.
const double *cranny_samples_times(const CrannySamples *samples);

// Returns the joint values, count × dof, in m or rad.
const double *cranny_samples_positions(const CrannySamples *samples);

// Returns the joint velocities, count × dof, in m/s or rad/s.
const double *cranny_samples_velocities(const CrannySamples *samples);

// Returns the joint accelerations, count × dof, in m/s² or rad/s²; at a discontinuity, the value right after it.
const double *cranny_samples_accelerations(const CrannySamples *samples);

// Returns the distances between the fingers, count values, in metres; NULL if the fingers do not close on an object.
const double *cranny_samples_openings(const CrannySamples *samples);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /*CRANNY_H */
