// The wrapper for C++: owners, exceptions, views, threads, and what one object gives to another.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <cranny/cranny.hpp>

std::size_t joints_of(const cranny::Robot& robot);

namespace {

int failures = 0;

void expect(bool is_met, const char* what, int line) {
  if (is_met) return;
  std::fprintf(stderr, "line %d: %s\n", line, what);
  ++failures;
}

#define EXPECT(condition) expect(static_cast<bool>(condition), #condition, __LINE__)

template <class F>
std::string error_of(F call) {
  try {
    call();
  } catch (const cranny::Error& error) {
    return error.what();
  }
  return "no error";
}

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

void options_are_json() {
  const cranny::Options options{{"seed", 7}, {"margin_m", 0.5}, {"blend", false}, {"planner", "a\"b\\c\n"}, {"carry", std::vector<double>{1, 2}}};
  EXPECT(std::string(options.c_str()) == R"({"seed":7,"margin_m":0.5,"blend":false,"planner":"a\"b\\c\u000a","carry":[1,2]})");
  EXPECT(cranny::Options().c_str() == nullptr);
}

void owners_outlive_each_other() {
  const auto cell = [] {
    const cranny::Robot robot = cranny::Robot::builtin("ur5e");
    cranny::World world;
    world.add_floor(-1).add_box("table", {0.8, 1.2, 0.04}, cranny::translation(0.7, 0, 0.1));
    world.add_capsule("pipe", 0.02, 0.3, cranny::translation(0, 0.8, 0.5));
    return cranny::Cell(robot, world);
  }();
  const cranny::Robot robot = cell.robot();
  EXPECT(joints_of(robot) == 6 && robot.joint_names().size() == 6 && robot.name() == "ur5e");
  EXPECT(cell.is_free(robot.start()));
  EXPECT(cell.clearance_m(robot.start()) > 0);

  // Into the table: the contact names both.
  cranny::Configuration down = robot.start();
  down[1] = 0.3;
  EXPECT(!cell.is_free(down));
  const cranny::Contact contact = cell.first_contact(down);
  EXPECT(!contact.first.empty() && !contact.second.empty());
  EXPECT(cell.first_contact(robot.start()).first.empty());
  const cranny::Motion motion = cell.motion(robot.start(), down);
  EXPECT(!motion && motion.kind == CRANNY_MOTION_KIND_CONTACT && motion.at >= 0 && motion.at <= 1);
  EXPECT(!cell.motion_is_free(robot.start(), down));
  EXPECT(cell.least_clearance_m(robot.start(), down) == 0.0);
}

void batches_and_singles_agree(const cranny::Scenario& scenario) {
  const cranny::Robot robot = scenario.robot();
  const cranny::Cell cell = scenario.cell();
  const cranny::Rows q = robot.sample(500, 3);
  const std::vector<bool> verdicts = cell.are_free(q);
  for (std::size_t row = 0; row < q.rows(); ++row) EXPECT(cell.is_free(q[row]) == verdicts[row]);
  EXPECT(std::count(verdicts.begin(), verdicts.end(), true) > 0);

  // Each thread has its cell; on one cell they wait for each other.
  std::vector<std::vector<bool>> found(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < found.size(); ++i) {
    threads.emplace_back([&, i] {
      if (i % 2 == 0) {
        const cranny::Cell own = cell;
        found[i] = own.are_free(q);
      } else {
        found[i] = cell.are_free(q);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<bool>& of_thread : found) EXPECT(of_thread == verdicts);
}

void ik_reaches_its_pose(const cranny::Robot& robot) {
  const cranny::Configuration start = robot.start();
  const cranny::Pose pose = robot.fk(start);
  const cranny::Rows solutions = robot.ik(pose, 4);
  EXPECT(solutions.rows() >= 1);
  for (std::size_t row = 0; row < solutions.rows(); ++row) {
    const cranny::Pose reached = robot.fk(solutions[row]);
    for (std::size_t i = 0; i < 16; ++i) EXPECT(std::abs(reached[i] - pose[i]) < 1e-3);
  }
  const cranny::Rows near = robot.ik_from(pose, start);
  EXPECT(near.rows() == 1 && std::abs(near[0][0] - start[0]) < 1e-6);

  // The Jacobian against a difference of poses.
  const cranny::Rows jacobian = robot.jacobian(start);
  for (std::size_t joint = 0; joint < robot.dof(); ++joint) {
    cranny::Configuration moved = start;
    moved[joint] += 1e-6;
    const cranny::Pose other = robot.fk(moved);
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT(std::abs((other[4 * axis + 3] - pose[4 * axis + 3]) / 1e-6 - jacobian[axis][joint]) < 1e-4);
  }
}

void plans_are_followed_saved_and_read(const cranny::Scenario& scenario) {
  const cranny::Plan plan = cranny::plan(scenario, {{"seed", 5}, {"time_limit_s", 20.0}});
  EXPECT(plan.is_solved() && plan.outcome() == "solved" && plan.path().rows() >= 2 && plan.clearance_m() > 0);
  EXPECT(cranny::plan(scenario, {{"seed", 5}, {"time_limit_s", 20.0}}).path().row(1) == plan.path().row(1));
  EXPECT(scenario.cell().path_is_free(plan.path()));
  EXPECT(cranny::verify_path(scenario, plan.path()));
  EXPECT(plan.verify().is_valid() && plan.verify().violations().empty());
  EXPECT(has(plan.json(), "\"format\":\"cranny-plan/2\""));

  // The straight line to the same grasp touches the table.
  cranny::Rows straight;
  straight.push_back(plan.path()[0]);
  straight.push_back(plan.path()[plan.path().rows() - 1]);
  const cranny::Verification refused = cranny::verify_path(scenario, straight);
  EXPECT(!refused && !refused.violations().empty() && has(refused.json(), "\"valid\":false"));
  const auto [edge, motion] = scenario.cell().path(straight);
  EXPECT(edge == 0 && !motion);

  const cranny::Samples samples = plan.sample(200);
  EXPECT(samples.size() > 10 && samples.times().back() == plan.duration_s());
  EXPECT(samples.positions().row(0) == scenario.start() && samples.openings().empty());
  const cranny::State end = plan.at(1e9);
  EXPECT(end.position == plan.path().row(plan.path().rows() - 1));
  const cranny::State middle = plan.at(samples.times()[5]);
  EXPECT(middle.position == samples.positions().row(5) && middle.velocity == samples.velocities().row(5));

  const char* folder = std::getenv("TMPDIR");
  const std::string file = std::string(folder ? folder : "/tmp") + "/cranny_wrapper_" + std::to_string(std::rand()) + ".plan.json";
  plan.save(file);
  const cranny::Plan read = cranny::Plan::load(file, scenario);
  EXPECT(read.is_solved() && read.path().rows() == plan.path().rows() && read.duration_s() == plan.duration_s());
  std::remove(file.c_str());
}

void a_search_can_be_stopped(const cranny::Scenario& scenario) {
  const cranny::Plan plan = cranny::plan(scenario, {}, [] { return true; });
  EXPECT(plan.outcome() == "cancelled" && !plan && !plan.has_trajectory());
  std::string thrown;
  try {
    cranny::plan(scenario, {}, []() -> bool { throw std::runtime_error("from outside"); });
  } catch (const std::runtime_error& fault) {
    thrown = fault.what();
  }
  EXPECT(thrown == "from outside");
}

void own_tasks_are_planned() {
  const cranny::Robot robot = cranny::Robot::builtin("ur5e");
  cranny::World world;
  world.add_cylinder("post", 0.05, 1.0, cranny::translation(0.5, 0.4, 0.6));
  cranny::Rows goals;
  cranny::Configuration goal = robot.start();
  goal[0] += 1.6;
  goals.push_back(goal);
  const cranny::Scenario scenario = cranny::Scenario(robot, world).with_goals(goals);
  const cranny::Plan plan = cranny::plan(scenario, {{"margin_m", 0.01}});
  EXPECT(plan.is_solved() && plan.grasp() == -1 && plan.clearance_m() >= 0.01);
  EXPECT(plan.path().row(plan.path().rows() - 1) == goal);

  // A cube as a mesh: its grasps.
  const std::vector<double> corners{-0.02, -0.02, -0.02, 0.02, -0.02, -0.02, -0.02, 0.02, -0.02, 0.02, 0.02, -0.02,
                                    -0.02, -0.02, 0.02,  0.02, -0.02, 0.02,  -0.02, 0.02, 0.02,  0.02, 0.02, 0.02};
  const std::vector<std::uint32_t> faces{0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  const cranny::Grasps grasps = cranny::Grasps::sample(corners, faces, {{"count", 20}, {"seed", 3}});
  EXPECT(grasps.size() == 20 && grasps.scores().size() == 20);
  EXPECT(grasps.scores()[grasps.by_score()[0]] >= grasps.scores()[grasps.by_score()[19]]);
  const cranny::Grasps same({grasps.pose(0), grasps.pose(1)}, {0.5, 0.25});
  EXPECT(same.size() == 2 && same.scores()[1] == 0.25);
}

void failures_are_exceptions(const cranny::Scenario& scenario) {
  EXPECT(has(error_of([] { cranny::Robot::builtin("ur6"); }), "'ur6' is unknown"));
  EXPECT(has(error_of([] { cranny::Scenario("0021"); }), "0021"));
  EXPECT(has(error_of([&] { cranny::plan(scenario, {{"sede", 1}}); }), "unknown field `sede`"));
  EXPECT(has(error_of([&] { scenario.cell().is_free(cranny::Configuration(3)); }), "dof is 3, but 9 is expected"));
  EXPECT(has(error_of([&] { scenario.grasps().pose(100000); }), "no grasp"));
  // The text is that of the thread: another thread's failure does not change it.
  std::thread([] { error_of([] { cranny::Robot::builtin("ur7"); }); }).join();
  EXPECT(!has(cranny_last_error(), "ur7"));
}

#ifdef CRANNY_HAS_EIGEN
void eigen_maps_share_memory(const cranny::Robot& robot) {
  cranny::Rows q = robot.sample(3, 1);
  EXPECT(cranny::map(q).rows() == 3 && cranny::map(q)(2, 1) == q[2][1]);
  cranny::map(q)(2, 1) = 0.25;
  EXPECT(q[2][1] == 0.25);
  const cranny::RowMatrix matrix = cranny::map(q);
  EXPECT(cranny::view(matrix)[2][1] == 0.25);
  const cranny::Pose pose = robot.fk(q[0]);
  const Eigen::Isometry3d isometry = cranny::isometry(pose);
  EXPECT(isometry.translation().x() == pose[3] && cranny::pose(isometry) == pose);
}
#endif

}  // namespace

int main() try {
  options_are_json();
  owners_outlive_each_other();
  const cranny::Scenario scenario("021");
  const cranny::Robot robot = scenario.robot();
  batches_and_singles_agree(scenario);
  ik_reaches_its_pose(robot);
  plans_are_followed_saved_and_read(scenario);
  a_search_can_be_stopped(scenario);
  own_tasks_are_planned();
  failures_are_exceptions(scenario);
#ifdef CRANNY_HAS_EIGEN
  eigen_maps_share_memory(robot);
#else
  std::printf("without Eigen\n");
#endif
  return failures == 0 ? 0 : 1;
} catch (const std::exception& fault) {
  std::fprintf(stderr, "%s\n", fault.what());
  return 1;
}
