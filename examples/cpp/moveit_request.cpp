// A planning scene and a motion plan request of MoveIt in (JSON or YAML), a joint trajectory out (JSON, as the message
// trajectory_msgs/JointTrajectory):
//
//   moveit_request SCENE REQUEST [URDF] > trajectory.json
#include <cstdio>
#include <exception>
#include <string>

#include <cranny/cranny.hpp>

namespace {

void print_row(const char* name, cranny::span<const double> values, const char* end) {
  std::printf("\"%s\": [", name);
  for (std::size_t i = 0; i < values.size(); ++i) std::printf("%s%.17g", i ? ", " : "", values[i]);
  std::printf("]%s", end);
}

void print_trajectory(const cranny::Robot& robot, const cranny::Samples& samples) {
  std::printf("{\"joint_names\": [");
  const auto names = robot.joint_names();
  for (std::size_t joint = 0; joint < names.size(); ++joint)
    std::printf("%s\"%s\"", joint ? ", " : "", names[joint].c_str());
  std::printf("],\n \"points\": [\n");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto nanoseconds = static_cast<long long>(1e9 * samples.times()[i] + 0.5);
    std::printf("  {");
    print_row("positions", samples.positions()[i], ", ");
    print_row("velocities", samples.velocities()[i], ", ");
    print_row("accelerations", samples.accelerations()[i], ", ");
    std::printf("\"time_from_start\": {\"sec\": %lld, \"nanosec\": %lld}}%s\n", nanoseconds / 1000000000,
                nanoseconds % 1000000000, i + 1 < samples.size() ? "," : "");
  }
  std::printf("]}\n");
}

}  // namespace

int main(int count, char** words) try {
  if (count < 3) {
    std::fprintf(stderr, "usage: moveit_request SCENE REQUEST [URDF]\n");
    return 2;
  }
  const cranny::Options files = count > 3 ? cranny::Options{{"robot", words[3]}} : cranny::Options{};
  const cranny::Scenario scenario = cranny::Scenario::from_moveit(words[1], words[2], files);
  if (!scenario.notes().empty()) std::fprintf(stderr, "%s\n", scenario.notes().c_str());

  const cranny::Plan plan = cranny::plan(scenario, {{"seed", 1}, {"time_limit_s", 5.0}});
  if (!plan) {
    std::fprintf(stderr, "moveit_request: %s\n", plan.outcome().c_str());
    return 1;
  }
  std::fprintf(stderr, "%zu way points, %.2f s, %.1f mm clear along the whole path\n", plan.path().rows(),
               plan.duration_s(), 1e3 * plan.clearance_m());
  print_trajectory(scenario.robot(), plan.sample(50));
  return 0;
} catch (const std::exception& fault) {
  std::fprintf(stderr, "moveit_request: %s\n", fault.what());
  return 1;
}
