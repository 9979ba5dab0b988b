/* Whether a robot in a world of boxes is free of collision, in C: one configuration, many, and whole motions. */
#include <stdio.h>
#include <stdlib.h>

#include <cranny/cranny.h>

#define DOF 6
#define ROWS 1000

/* Ends the program with the reason if a call fails. */
static void check(CrannyStatus status) {
  if (status == CRANNY_STATUS_OK) return;
  fprintf(stderr, "verdicts: %s\n", cranny_last_error());
  exit(1);
}

int main(void) {
  if (cranny_abi_version() != CRANNY_ABI_VERSION) {
    fprintf(stderr, "verdicts: this library does not fit the header that it was compiled with\n");
    return 1;
  }

  /* A UR5e on its mount, which ends at z = 0, beside a table and a post. Poses are 4 x 4, row by row. */
  CrannyRobot *robot = NULL;
  CrannyWorld *world = NULL;
  CrannyCell *cell = NULL;
  const double table_m[3] = {0.8, 1.2, 0.04}, post_m[3] = {0.1, 0.1, 1.0};
  const double table[16] = {1, 0, 0, 0.7, 0, 1, 0, 0, 0, 0, 1, 0.1, 0, 0, 0, 1};
  const double post[16] = {1, 0, 0, 0.5, 0, 1, 0, 0.4, 0, 0, 1, 0.62, 0, 0, 0, 1};
  check(cranny_robot_builtin("ur5e", &robot));
  check(cranny_world_new(&world));
  check(cranny_world_add_box(world, "table", table_m, table));
  check(cranny_world_add_box(world, "post", post_m, post));
  check(cranny_cell_new(robot, world, 0.002, &cell));

  /* One configuration, with 2 mm between any two bodies. */
  double start[DOF];
  bool is_free = false;
  check(cranny_robot_start(robot, start, DOF));
  check(cranny_cell_is_free(cell, start, DOF, &is_free));
  double clearance_m = 0;
  check(cranny_cell_clearances(cell, start, 1, DOF, &clearance_m));
  printf("the start is %s, %.0f mm clear\n", is_free ? "free" : "not free", 1e3 * clearance_m);

  /* Many at once. */
  static double q[ROWS * DOF];
  static bool verdicts[ROWS];
  size_t free_count = 0;
  check(cranny_robot_sample(robot, 1, q, ROWS, DOF));
  check(cranny_cell_are_free(cell, q, ROWS, DOF, verdicts));
  for (size_t row = 0; row < ROWS; ++row) free_count += verdicts[row];
  printf("%zu of %d random configurations are free\n", free_count, ROWS);

  /* A whole motion: proven, or with what is in its way. */
  double goal[DOF];
  for (size_t joint = 0; joint < DOF; ++joint) goal[joint] = start[joint];
  goal[0] += 1.6;
  CrannyMotion motion;
  check(cranny_cell_motion(cell, start, goal, DOF, &motion));
  if (motion.kind == CRANNY_MOTION_KIND_PROVEN) {
    printf("the turn is proven free\n");
  } else if (motion.kind == CRANNY_MOTION_KIND_CONTACT) {
    printf("the turn is not free: %s meets %s after %.0f %% of it\n", motion.contact.first, motion.contact.second,
           100 * motion.at);
  } else {
    printf("the turn is neither proven nor refuted\n");
  }

  cranny_cell_free(cell);
  cranny_world_free(world);
  cranny_robot_free(robot);
  return 0;
}
