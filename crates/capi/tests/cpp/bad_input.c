/* Wrong calls: NULL, wrong lengths, numbers that are not finite, unknown names and options, missing files. Each is refused
   with a status and a text, and the handles stay usable. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cranny/cranny.h>

#define DOF 6

static int failures = 0;

static void expect(int is_met, const char *what, int line) {
  if (is_met) return;
  fprintf(stderr, "line %d: %s (last error: %s)\n", line, what, cranny_last_error());
  ++failures;
}

#define EXPECT(condition) expect(condition, #condition, __LINE__)

/* A refused call, whose reason contains a text. */
#define REFUSED(call, text)                                        \
  do {                                                             \
    EXPECT((call) == CRANNY_STATUS_ARGUMENT);                      \
    EXPECT(strstr(cranny_last_error(), text) != NULL);             \
  } while (0)
#define BAD_FILE(call, text)                                       \
  do {                                                             \
    EXPECT((call) == CRANNY_STATUS_REFUSED);                       \
    EXPECT(strstr(cranny_last_error(), text) != NULL);             \
  } while (0)
#define DONE(call) EXPECT((call) == CRANNY_STATUS_OK)

static const double AHEAD[16] = {1, 0, 0, 0.6, 0, 1, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1};
static const double MIRROR[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static CrannyRobot *robots(void) {
  CrannyRobot *robot = NULL;
  REFUSED(cranny_robot_builtin(NULL, &robot), "name is NULL");
  REFUSED(cranny_robot_builtin("ur6", &robot), "'ur6' is unknown (known: panda_mobile");
  REFUSED(cranny_robot_builtin("\xff", &robot), "not UTF-8");
  REFUSED(cranny_robot_builtin("ur5e", NULL), "robot is NULL");
  BAD_FILE(cranny_robot_from_urdf("no/such.urdf", NULL, &robot), "no/such.urdf");
  BAD_FILE(cranny_robot_from_urdf_text("<robot", NULL, &robot), "<text>");
  REFUSED(cranny_robot_from_urdf("x.urdf", "{\"tipp\": \"hand\"}", &robot), "unknown field `tipp`, expected one of");
  REFUSED(cranny_robot_from_urdf("x.urdf", "{\"meshes\": \"soft\"}", &robot), "'hull' or 'solid' is expected");
  REFUSED(cranny_robot_from_urdf("x.urdf", "[", &robot), "options: ");
  EXPECT(robot == NULL);
  DONE(cranny_robot_builtin("ur5e", &robot));

  EXPECT(cranny_robot_dof(NULL) == 0 && strcmp(cranny_last_error(), "robot is NULL") == 0);
  EXPECT(cranny_robot_name(NULL) == NULL);
  EXPECT(cranny_robot_joint_name(robot, DOF) == NULL && strcmp(cranny_last_error(), "joint is 6, but there are 6") == 0);
  EXPECT(strcmp(cranny_robot_joint_name(robot, 0), "shoulder_pan_joint") == 0);

  double q[DOF] = {0}, pose[16], found_q[3 * DOF];
  size_t found = 7;
  REFUSED(cranny_robot_start(robot, q, 5), "dof is 5, but 6 is expected");
  REFUSED(cranny_robot_start(robot, NULL, DOF), "q is NULL");
  REFUSED(cranny_robot_start(NULL, q, DOF), "robot is NULL");
  DONE(cranny_robot_start(robot, q, DOF));
  REFUSED(cranny_robot_fk(robot, "elbow", q, 1, DOF, pose), "link 'elbow' is unknown");
  REFUSED(cranny_robot_fk(robot, NULL, q, 1, 7, pose), "dof");
  REFUSED(cranny_robot_fk(robot, NULL, q, (size_t)-1, DOF, pose), "do not fit into memory");
  REFUSED(cranny_robot_fk(robot, NULL, q, 1, DOF, NULL), "poses is NULL");
  REFUSED(cranny_robot_sample(robot, 0, q, (size_t)1 << 40, DOF), "do not fit into memory");
  REFUSED(cranny_robot_limits(robot, 1, NULL, NULL, NULL, NULL), "dof");
  DONE(cranny_robot_limits(robot, DOF, NULL, NULL, NULL, NULL));
  DONE(cranny_robot_fk(robot, NULL, q, 1, DOF, pose));
  DONE(cranny_robot_fk(robot, NULL, NULL, 0, DOF, NULL));
  EXPECT(cranny_robot_ik(robot, MIRROR, NULL, 10, 0, found_q, 3, DOF, &found) == CRANNY_STATUS_REFUSED);
  REFUSED(cranny_robot_ik(robot, pose, NULL, 1000000, 0, found_q, 3, DOF, &found), "at most 100000");
  EXPECT(found == 7);
  DONE(cranny_robot_ik(robot, pose, NULL, 200, 0, found_q, 3, DOF, &found));
  EXPECT(found > 0 && found <= 3);
  q[2] = NAN;
  REFUSED(cranny_robot_fk(robot, NULL, q, 1, DOF, pose), "q: value 2 is NaN");
  return robot;
}

static CrannyWorld *worlds(const CrannyRobot *robot) {
  CrannyWorld *world = NULL;
  const double size[3] = {0.1, 0.2, 0.3}, flat[3] = {0.1, 0.0, 0.3};
  const double corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const uint32_t faces[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, wild[3] = {0, 1, 4};
  REFUSED(cranny_world_new(NULL), "world is NULL");
  DONE(cranny_world_new(&world));
  REFUSED(cranny_world_add_box(NULL, "box", size, NULL), "world is NULL");
  REFUSED(cranny_world_add_box(world, NULL, size, NULL), "name is NULL");
  REFUSED(cranny_world_add_box(world, "box", NULL, NULL), "size is NULL");
  EXPECT(cranny_world_add_box(world, "box", flat, NULL) == CRANNY_STATUS_REFUSED);
  EXPECT(cranny_world_add_box(world, "box", size, MIRROR) == CRANNY_STATUS_REFUSED);
  EXPECT(cranny_world_add_sphere(world, "ball", -1, NULL) == CRANNY_STATUS_REFUSED);
  EXPECT(cranny_world_add_cylinder(world, "can", NAN, 1, NULL) == CRANNY_STATUS_REFUSED);
  REFUSED(cranny_world_add_floor(world, INFINITY), "must be finite");
  REFUSED(cranny_world_add_mesh(world, "mesh", corners, 4, wild, 1, false, NULL), "is 4, but there are 4");
  EXPECT(cranny_world_add_mesh(world, "mesh", corners, 4, faces, 3, false, NULL) == CRANNY_STATUS_REFUSED);
  EXPECT(cranny_world_body_count(world) == 0);
  DONE(cranny_world_add_mesh(world, "mesh", corners, 4, faces, 4, false, AHEAD));
  REFUSED(cranny_world_add_sphere(world, "mesh", 0.1, AHEAD), "a body 'mesh' already");
  EXPECT(cranny_world_body_count(world) == 1);
  CrannyWorld *read = NULL;
  BAD_FILE(cranny_world_from_moveit_scene("none.yaml", robot, &read), "none.yaml");
  return world;
}

static void cells(const CrannyRobot *robot, const CrannyWorld *world) {
  CrannyCell *cell = NULL, *clone = NULL;
  REFUSED(cranny_cell_new(NULL, world, 0, &cell), "robot is NULL");
  REFUSED(cranny_cell_new(robot, NULL, 0, &cell), "world is NULL");
  EXPECT(cranny_cell_new(robot, world, -1, &cell) == CRANNY_STATUS_REFUSED);
  EXPECT(cranny_cell_new(robot, world, NAN, &cell) == CRANNY_STATUS_REFUSED);
  EXPECT(cell == NULL);
  DONE(cranny_cell_new(robot, world, 0, &cell));
  REFUSED(cranny_cell_clone(NULL, &clone), "cell is NULL");
  REFUSED(cranny_cell_clone(cell, NULL), "clone is NULL");

  double q[2 * DOF] = {0}, clearance_m[2];
  bool is_free[2] = {true, true};
  size_t edge = 0;
  CrannyMotion motion;
  CrannyContact contact;
  DONE(cranny_robot_start(robot, q, DOF));
  DONE(cranny_robot_start(robot, q + DOF, DOF));
  REFUSED(cranny_cell_is_free(cell, q, 5, is_free), "dof is 5");
  REFUSED(cranny_cell_is_free(cell, NULL, DOF, is_free), "q is NULL");
  REFUSED(cranny_cell_is_free(cell, q, DOF, NULL), "is_free is NULL");
  REFUSED(cranny_cell_is_free(NULL, q, DOF, is_free), "cell is NULL");
  REFUSED(cranny_cell_are_free(cell, q, 2, DOF, NULL), "are_free is NULL");
  REFUSED(cranny_cell_are_free(cell, q, 2, 0, is_free), "dof is 0");
  DONE(cranny_cell_are_free(cell, NULL, 0, DOF, NULL));
  REFUSED(cranny_cell_path(cell, q, 0, DOF, &edge, &motion), "no way point");
  REFUSED(cranny_cell_path(cell, q, 2, DOF, NULL, &motion), "edge is NULL");
  DONE(cranny_cell_path(cell, q, 2, DOF, &edge, &motion));
  q[0] = INFINITY;
  REFUSED(cranny_cell_clearances(cell, q, 2, DOF, clearance_m), "q: value 0 is inf");
  REFUSED(cranny_cell_motion(cell, q, q + DOF, DOF, &motion), "a: value 0 is inf");
  REFUSED(cranny_cell_first_contact(cell, q, DOF, &contact), "q: value 0");
  DONE(cranny_cell_are_free(cell, q, 2, DOF, is_free));
  EXPECT(!is_free[0]);
  q[0] = 100;
  DONE(cranny_cell_motion(cell, q, q + DOF, DOF, &motion));
  EXPECT(motion.kind == CRANNY_MOTION_KIND_OUT_OF_LIMITS && strcmp(motion.name, "shoulder_pan_joint") == 0);
  EXPECT(isnan(motion.at) && motion.contact.first == NULL);
  cranny_cell_free(cell);
}

static void tasks(const CrannyRobot *robot, const CrannyWorld *world) {
  CrannyScenario *scenario = NULL, *altered = NULL;
  CrannyPlan *plan = NULL;
  CrannyVerification *verification = NULL;
  CrannyGrasps *grasps = NULL;
  CrannySamples *samples = NULL;
  double q[9] = {0};
  BAD_FILE(cranny_scenario_open("0021", NULL, &scenario), "0021");
  REFUSED(cranny_scenario_open("021", "{\"criterion\": \"loose\"}", &scenario), "'exact' or 'paper' is expected");
  REFUSED(cranny_scenario_new(robot, world, q, 5, NULL, NULL, &scenario), "dof is 5");
  EXPECT(cranny_scenario_new(robot, world, NULL, 0, "no such body", NULL, &scenario) == CRANNY_STATUS_REFUSED);
  BAD_FILE(cranny_scenario_from_moveit("a.json", "b.json", NULL, &scenario), "a.json");
  EXPECT(scenario == NULL);
  DONE(cranny_scenario_open("021", NULL, &scenario));
  EXPECT(strcmp(cranny_scenario_id(scenario), "021") == 0);
  REFUSED(cranny_scenario_with_goals(scenario, q, 1, 8, &altered), "dof is 8");
  REFUSED(cranny_scenario_with_grasps(scenario, NULL, &altered), "grasps is NULL");
  BAD_FILE(cranny_grasps_load("none.csv", &grasps), "none.csv");
  EXPECT(cranny_grasps_new(MIRROR, NULL, 1, &grasps) == CRANNY_STATUS_REFUSED);
  const double too_good = 1.5;
  EXPECT(cranny_grasps_new(AHEAD, &too_good, 1, &grasps) == CRANNY_STATUS_REFUSED);

  REFUSED(cranny_plan(NULL, NULL, NULL, NULL, &plan), "scenario is NULL");
  REFUSED(cranny_plan(scenario, "{\"sede\": 1}", NULL, NULL, &plan), "unknown field `sede`");
  REFUSED(cranny_plan(scenario, "{\"seed\": -1}", NULL, NULL, &plan), "options: ");
  REFUSED(cranny_plan(scenario, "{\"time_limit_s\": 0}", NULL, NULL, &plan), "positive number of seconds");
  REFUSED(cranny_plan(scenario, "{\"carry\": \"away\"}", NULL, NULL, &plan), "'home', 'out' or configurations");
  REFUSED(cranny_plan(scenario, "{\"carry\": [0, 1]}", NULL, NULL, &plan), "a row of 2 values");
  REFUSED(cranny_plan(scenario, "{\"speed\": {\"fly\": 1}}", NULL, NULL, &plan), "fly");
  REFUSED(cranny_plan(scenario, "{\"robust\": [-1, 0]}", NULL, NULL, &plan), "`robust`");
  BAD_FILE(cranny_plan(scenario, "{\"planner\": \"rich\"}", NULL, NULL, &plan), "unknown planner 'rich'");
  EXPECT(cranny_plan(scenario, "{\"margin_m\": -1}", NULL, NULL, &plan) == CRANNY_STATUS_REFUSED);
  REFUSED(cranny_plan(scenario, NULL, NULL, NULL, NULL), "plan is NULL");
  BAD_FILE(cranny_plan_load("none.plan.json", scenario, &plan), "none.plan.json");
  EXPECT(plan == NULL);
  EXPECT(cranny_verify_path(scenario, q, 0, 9, NULL, &verification) == CRANNY_STATUS_REFUSED);
  REFUSED(cranny_verify_path(scenario, NULL, 2, 9, NULL, &verification), "path is NULL");
  DONE(cranny_verify_path(scenario, q, 1, 9, NULL, &verification));
  EXPECT(!cranny_verification_is_valid(verification));
  EXPECT(cranny_verification_violation(verification, 1000) == NULL);

  /* A plan without a path has no trajectory, and the reason is given. */
  DONE(cranny_plan(scenario, "{\"iterations\": 0}", NULL, NULL, &plan));
  EXPECT(!cranny_plan_is_solved(plan) && cranny_plan_waypoint_count(plan) == 0 && cranny_plan_grasp(plan) == -1);
  EXPECT(isnan(cranny_plan_duration_s(plan)));
  REFUSED(cranny_plan_sample(plan, 100, &samples), "no path to follow");
  REFUSED(cranny_plan_state_at(plan, 0, 9, q, NULL, NULL), "no path to follow");
  CrannyVerification *none = NULL;
  REFUSED(cranny_plan_verify(plan, &none), "no path to verify");
  EXPECT(cranny_plan_outcome(NULL) == NULL && cranny_samples_times(NULL) == NULL);

  cranny_plan_free(plan);
  cranny_verification_free(verification);
  cranny_scenario_free(scenario);
}

int main(void) {
  EXPECT(cranny_last_error()[0] == '\0');
  EXPECT(cranny_abi_version() == CRANNY_ABI_VERSION);
  CrannyRobot *robot = robots();
  CrannyWorld *world = worlds(robot);
  cells(robot, world);
  tasks(robot, world);
  cranny_world_free(world);
  cranny_robot_free(robot);
  cranny_robot_free(NULL);
  cranny_world_free(NULL);
  cranny_cell_free(NULL);
  cranny_grasps_free(NULL);
  cranny_scenario_free(NULL);
  cranny_plan_free(NULL);
  cranny_verification_free(NULL);
  cranny_samples_free(NULL);
  return failures == 0 ? 0 : 1;
}
