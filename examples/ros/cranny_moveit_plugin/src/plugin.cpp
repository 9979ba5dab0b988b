// Planner plugin of MoveIt 2 (moveit_core of Jazzy and later) that asks a running `cranny serve`.
//
// The parameter `address` below the pipeline's namespace is the address that `cranny serve` printed.

#include <iomanip>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <curl/curl.h>
#include <yaml-cpp/yaml.h>

#include <moveit/planning_interface/planning_interface.hpp>
#include <moveit/planning_scene/planning_scene.hpp>
#include <moveit/robot_state/conversions.hpp>
#include <moveit/robot_trajectory/robot_trajectory.hpp>
#include <moveit_msgs/msg/move_it_error_codes.hpp>
#include <moveit_msgs/msg/planning_scene.hpp>
#include <moveit_msgs/msg/robot_trajectory.hpp>
#include <pluginlib/class_list_macros.hpp>
#include <rclcpp/rclcpp.hpp>

namespace cranny_moveit_plugin
{
using planning_interface::MotionPlanDetailedResponse;
using planning_interface::MotionPlanRequest;
using planning_interface::MotionPlanResponse;
using Codes = moveit_msgs::msg::MoveItErrorCodes;

/// Reply of the server: status and content.
struct Reply
{
  long status = 0;
  std::string content;
};

/// Sends `content` to `url` and waits for the reply, which comes within the planning time of the request.
Reply post(const std::string & url, const std::string & content)
{
  std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl(curl_easy_init(), curl_easy_cleanup);
  if (!curl) throw std::runtime_error("libcurl cannot start");
  Reply reply;
  const auto keep = +[](char * bytes, size_t size, size_t count, void * text) {
    static_cast<std::string *>(text)->append(bytes, size * count);
    return size * count;
  };
  curl_easy_setopt(curl.get(), CURLOPT_URL, url.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl.get(), CURLOPT_POSTFIELDS, content.data());
  curl_easy_setopt(curl.get(), CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(content.size()));
  curl_easy_setopt(curl.get(), CURLOPT_WRITEFUNCTION, keep);
  curl_easy_setopt(curl.get(), CURLOPT_WRITEDATA, &reply.content);
  const CURLcode done = curl_easy_perform(curl.get());
  if (done != CURLE_OK) throw std::runtime_error(curl_easy_strerror(done));
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &reply.status);
  return reply;
}

/// Planning context of one request.
class Context : public planning_interface::PlanningContext
{
public:
  Context(const std::string & group, std::string address)
  : PlanningContext("cranny", group), address_(std::move(address)) {}

  void solve(MotionPlanResponse & response) override
  {
    response.planner_id = "cranny";
    response.error_code.val = Codes::FAILURE;
    response.error_code.source = "cranny";
    try {
      ask(response);
    } catch (const std::exception & fault) {
      response.error_code.message = fault.what();
      RCLCPP_ERROR(rclcpp::get_logger("cranny"), "%s", fault.what());
    }
  }

  void solve(MotionPlanDetailedResponse & detailed) override
  {
    MotionPlanResponse response;
    solve(response);
    detailed.planner_id = response.planner_id;
    detailed.error_code = response.error_code;
    if (!response.trajectory) return;
    detailed.trajectory = {response.trajectory};
    detailed.description = {"plan"};
    detailed.processing_time = {response.planning_time};
  }

  /// A request under way ends with its planning time.
  bool terminate() override { return false; }
  void clear() override {}

private:
  void ask(MotionPlanResponse & response) const
  {
    moveit_msgs::msg::PlanningScene scene;
    planning_scene_->getPlanningSceneMsg(scene);
    // Messages are written as YAML, which Cranny reads like JSON; 17 digits identify a double.
    std::ostringstream text;
    text << std::setprecision(std::numeric_limits<double>::max_digits10) << "{planning_scene: ";
    moveit_msgs::msg::to_flow_style_yaml(scene, text);
    text << ", motion_plan_request: ";
    moveit_msgs::msg::to_flow_style_yaml(request_, text);
    text << "}";
    const Reply reply = post(address_ + "plan", text.str());
    const YAML::Node document = YAML::Load(reply.content);
    if (reply.status != 200) throw std::runtime_error(document["error"].as<std::string>(reply.content));

    const YAML::Node answer = document["motion_plan_response"];
    response.error_code.val = answer["error_code"]["val"].as<int>();
    response.error_code.message = answer["error_code"]["message"].as<std::string>();
    response.planning_time = answer["planning_time"].as<double>();
    if (response.error_code.val != Codes::SUCCESS) return;

    moveit_msgs::msg::RobotTrajectory message;
    const YAML::Node joints = answer["trajectory"]["joint_trajectory"];
    message.joint_trajectory.joint_names = joints["joint_names"].as<std::vector<std::string>>();
    for (const YAML::Node & point : joints["points"]) {
      auto & to = message.joint_trajectory.points.emplace_back();
      to.positions = point["positions"].as<std::vector<double>>();
      to.velocities = point["velocities"].as<std::vector<double>>();
      to.accelerations = point["accelerations"].as<std::vector<double>>();
      to.time_from_start.sec = point["time_from_start"]["sec"].as<int32_t>();
      to.time_from_start.nanosec = point["time_from_start"]["nanosec"].as<uint32_t>();
    }
    moveit::core::RobotState start(planning_scene_->getCurrentState());
    moveit::core::robotStateMsgToRobotState(planning_scene_->getTransforms(), request_.start_state, start);
    response.trajectory = std::make_shared<robot_trajectory::RobotTrajectory>(
      planning_scene_->getRobotModel(), getGroupName());
    response.trajectory->setRobotTrajectoryMsg(start, message);
    moveit::core::robotStateToRobotStateMsg(start, response.start_state);
  }

  std::string address_;
};

/// The plugin.
class Manager : public planning_interface::PlannerManager
{
public:
  bool initialize(
    const moveit::core::RobotModelConstPtr &, const rclcpp::Node::SharedPtr & node,
    const std::string & parameter_namespace) override
  {
    const std::string name = parameter_namespace.empty() ? "address" : parameter_namespace + ".address";
    if (!node->has_parameter(name)) node->declare_parameter<std::string>(name, "");
    address_ = node->get_parameter(name).as_string();
    if (!address_.empty()) return true;
    RCLCPP_ERROR(node->get_logger(), "set '%s' to the address that `cranny serve` prints", name.c_str());
    return false;
  }

  std::string getDescription() const override { return "Cranny"; }

  void getPlanningAlgorithms(std::vector<std::string> & names) const override { names = {"cranny"}; }

  planning_interface::PlanningContextPtr getPlanningContext(
    const planning_scene::PlanningSceneConstPtr & scene, const MotionPlanRequest & request,
    Codes & error_code) const override
  {
    auto context = std::make_shared<Context>(request.group_name, address_);
    context->setPlanningScene(scene);
    context->setMotionPlanRequest(request);
    error_code.val = Codes::SUCCESS;
    return context;
  }

  /// Cranny refuses by name what it does not support.
  bool canServiceRequest(const MotionPlanRequest &) const override { return true; }

private:
  std::string address_;
};
}  // namespace cranny_moveit_plugin

PLUGINLIB_EXPORT_CLASS(cranny_moveit_plugin::Manager, planning_interface::PlannerManager)
