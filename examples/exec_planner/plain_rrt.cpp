// A plain planner in C++17 without libraries, for the built-in robot:
//
//   c++ -O2 -std=c++17 -o plain_rrt plain_rrt.cpp
//   cranny bench run --scenarios can --planner "exec:./plain_rrt {start} {ik} {obstacles} {seed} {time_limit_s}"
//
// It shows the short form of the protocol (docs/exec_protocol.md): files and numbers come as arguments, way points
// go out as comma-separated lines, and no output means no path. RRT-Connect (Kuffner and LaValle 2000)
// between the start and each known goal, from which the hand is first moved back; collision checks of balls against
// triangles. Only the judge checks what these balls miss, and the last stretch to the object.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

constexpr int kJoints = 9;
constexpr double kPi = 3.14159265358979323846;
constexpr double kFloor_m = -0.05;     // of the planning frame
constexpr double kStep = 0.1;          // of the trees, in the norm of q
constexpr double kCheckStep = 0.05;    // between two configurations that are checked
constexpr double kRetreat_m = 0.12;    // a little more than the fingers are long

using Configuration = std::array<double, kJoints>;
using Vector = std::array<double, 3>;

Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vector operator*(const Vector& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// A pose: the columns of its rotation, and its origin.
struct Frame {
  Vector x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin{0, 0, 0};
  Vector at(const Vector& p) const { return origin + x * p[0] + y * p[1] + z * p[2]; }
  Frame moved(const Vector& p) const { return {x, y, z, at(p)}; }
  Frame turned_x(double a) const {
    return {x, y * std::cos(a) + z * std::sin(a), z * std::cos(a) - y * std::sin(a), origin};
  }
  Frame turned_z(double a) const {
    return {x * std::cos(a) + y * std::sin(a), y * std::cos(a) - x * std::sin(a), z, origin};
  }
};

// Limits of the joints: base y, base x (m), the arm (rad).
const Configuration kLower{-1, -1, -2.9671, -1.8326, -2.9671, -3.1416, -2.9671, -0.0873, -2.9671};
const Configuration kUpper{1, 1, 2.9671, 1.8326, 2.9671, 0, 2.9671, 3.8223, 2.9671};

// Frames of platform, links 1 to 7 and the gripper, from the manufacturer's published dimensions.
std::array<Frame, 9> frames(const Configuration& q) {
  std::array<Frame, 9> f;
  f[0] = Frame{}.moved({q[1], q[0], 0});
  f[1] = f[0].moved({0, 0, 0.333}).turned_z(q[2]);
  f[2] = f[1].turned_x(-kPi / 2).turned_z(q[3]);
  f[3] = f[2].moved({0, -0.316, 0}).turned_x(kPi / 2).turned_z(q[4]);
  f[4] = f[3].moved({0.0825, 0, 0}).turned_x(kPi / 2).turned_z(q[5]);
  f[5] = f[4].moved({-0.0825, 0.384, 0}).turned_x(-kPi / 2).turned_z(q[6]);
  f[6] = f[5].turned_x(kPi / 2).turned_z(q[7]);
  f[7] = f[6].moved({0.088, 0, 0}).turned_x(kPi / 2).turned_z(q[8]);
  f[8] = f[7].moved({0, 0, 0.107}).turned_z(-kPi / 4).moved({0, 0, 0.105});
  return f;
}

struct Ball { int frame; Vector centre; double radius; };

// By hand, around the links; frame 8 is the gripper with its open fingers.
std::vector<Ball> robot_balls() {
  std::vector<Ball> balls;
  for (double x : {-0.15, -0.05, 0.05, 0.15})
    for (double y : {-0.15, -0.05, 0.05, 0.15}) balls.push_back({0, {x, y, 0}, 0.075});
  for (double z : {0.05, 0.12}) balls.push_back({0, {-0.04, 0, z}, 0.13});
  for (double z : {-0.19, -0.1, 0.0}) balls.push_back({1, {0, 0, z}, 0.09});
  for (double y : {-0.19, -0.1, 0.0}) balls.push_back({2, {0, y, 0}, 0.09});
  for (double z : {-0.12, 0.0}) balls.push_back({3, {0.04, 0, z}, 0.11});
  for (double y : {0.0, 0.1}) balls.push_back({4, {-0.04, y, 0}, 0.11});
  for (double z : {-0.27, -0.2, -0.13, -0.05}) balls.push_back({5, {0, 0.04, z}, 0.1});
  balls.push_back({6, {0.04, 0, 0}, 0.12});
  balls.push_back({7, {0, 0, 0.07}, 0.1});
  for (double y : {-0.08, -0.04, 0.0, 0.04, 0.08}) balls.push_back({8, {0, y, -0.075}, 0.05});
  for (double y : {-0.045, 0.045}) for (double z : {-0.03, 0.0}) balls.push_back({8, {0, y, z}, 0.025});
  return balls;
}

struct Triangle { Vector a, b, c, middle; double reach; };

double distance(const Vector& p, const Triangle& t) {
  double nearest = INFINITY;
  bool inside = true;
  const Vector normal = cross(t.b - t.a, t.c - t.a);
  const Vector corners[4] = {t.a, t.b, t.c, t.a};
  for (int k = 0; k < 3; ++k) {
    const Vector edge = corners[k + 1] - corners[k], to = p - corners[k];
    inside &= dot(cross(edge, to), normal) >= 0;
    const double s = std::clamp(dot(to, edge) / std::max(dot(edge, edge), 1e-300), 0.0, 1.0);
    const Vector off = to - edge * s;
    nearest = std::min(nearest, std::sqrt(dot(off, off)));
  }
  if (!inside) return nearest;
  return std::abs(dot(p - t.a, normal)) / std::sqrt(std::max(dot(normal, normal), 1e-300));
}

std::vector<Triangle> read_triangles(const std::string& path) {
  std::vector<Vector> vertices;
  std::vector<Triangle> triangles;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Vector v;
      words >> v[0] >> v[1] >> v[2];
      vertices.push_back(v);
    } else if (kind == "f") {
      std::vector<Vector> corners;
      for (std::string word; words >> word;) corners.push_back(vertices.at(std::stoul(word) - 1));
      for (size_t k = 2; k < corners.size(); ++k) {
        Triangle t{corners[0], corners[k - 1], corners[k], {}, 0};
        t.middle = (t.a + t.b + t.c) * (1.0 / 3);
        for (const Vector& v : {t.a, t.b, t.c}) t.reach = std::max(t.reach, std::sqrt(dot(v - t.middle, v - t.middle)));
        triangles.push_back(t);
      }
    }
  }
  return triangles;
}

std::vector<double> read_numbers(const std::string& path) {
  std::ifstream file(path);
  std::vector<double> numbers;
  for (std::string field; std::getline(file, field);) {
    std::istringstream line(field);
    for (std::string number; std::getline(line, number, ',');) numbers.push_back(std::stod(number));
  }
  return numbers;
}

double norm(const Configuration& a, const Configuration& b) {
  double sum = 0;
  for (int j = 0; j < kJoints; ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
  return std::sqrt(sum);
}

Configuration between(const Configuration& a, const Configuration& b, double t) {
  Configuration q;
  for (int j = 0; j < kJoints; ++j) q[j] = a[j] + (b[j] - a[j]) * t;
  return q;
}

struct Checker {
  std::vector<Triangle> triangles;
  std::vector<Ball> balls = robot_balls();

  // Without the gripper if `gripper_too` is not set: on the last stretch it comes close to the object intentionally.
  bool is_free(const Configuration& q, bool gripper_too = true) const {
    for (int j = 0; j < kJoints; ++j) if (q[j] < kLower[j] || q[j] > kUpper[j]) return false;
    const auto f = frames(q);
    std::vector<Vector> centres;
    for (const Ball& ball : balls) centres.push_back(f[ball.frame].at(ball.centre));
    for (size_t i = 0; i < balls.size(); ++i) {
      if (balls[i].frame >= 2 && centres[i][2] - balls[i].radius < kFloor_m) return false;
      // Links that are far apart along the arm.
      for (size_t k = 0; k < i; ++k) {
        const Vector off = centres[i] - centres[k];
        const double reach = balls[i].radius + balls[k].radius;
        if (balls[i].frame - balls[k].frame >= 4 && dot(off, off) < reach * reach) return false;
      }
      if (!gripper_too && balls[i].frame >= 6) continue;
      for (const Triangle& t : triangles) {
        const Vector off = centres[i] - t.middle;
        const double reach = balls[i].radius + t.reach;
        if (dot(off, off) < reach * reach && distance(centres[i], t) < balls[i].radius) return false;
      }
    }
    return true;
  }

  bool motion_is_free(const Configuration& a, const Configuration& b) const {
    const int count = std::max(1, int(std::ceil(norm(a, b) / kCheckStep)));
    for (int k = 1; k <= count; ++k) if (!is_free(between(a, b, double(k) / count))) return false;
    return true;
  }
};

// One damped least-squares step of the gripper towards a place, its rotation held.
void step_gripper(Configuration& q, const Frame& begin, const Vector& wanted) {
  const auto turn = [](const Frame& to, const Frame& from) {
    return (cross(from.x, to.x) + cross(from.y, to.y) + cross(from.z, to.z)) * 0.5;
  };
  const Frame tip = frames(q)[8];
  const Vector move = wanted - tip.origin, spin = turn(begin, tip);
  double jacobian[6][kJoints], a[6][7] = {};
  for (int j = 0; j < kJoints; ++j) {
    Configuration moved = q;
    moved[j] += 1e-6;
    const Frame other = frames(moved)[8];
    const Vector v = (other.origin - tip.origin) * 1e6, w = turn(other, tip) * 1e6;
    for (int k = 0; k < 3; ++k) { jacobian[k][j] = v[k]; jacobian[k + 3][j] = w[k]; }
  }
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) for (int j = 0; j < kJoints; ++j) a[r][c] += jacobian[r][j] * jacobian[c][j];
    a[r][r] += 1e-4;
    a[r][6] = r < 3 ? move[r] : spin[r - 3];
  }
  // Gauss and Jordan; the damping keeps every pivot above zero.
  for (int p = 0; p < 6; ++p)
    for (int r = 0; r < 6; ++r) {
      if (r == p) continue;
      const double factor = a[r][p] / a[p][p];
      for (int c = p; c < 7; ++c) a[r][c] -= factor * a[p][c];
    }
  for (int j = 0; j < kJoints; ++j) for (int r = 0; r < 6; ++r) q[j] += jacobian[r][j] * a[r][6] / a[r][r];
}

using Path = std::vector<Configuration>;

Path retreat(const Configuration& goal) {
  Path path{goal};
  const Frame begin = frames(goal)[8];
  Configuration q = goal;
  for (double away = 0.01; away <= kRetreat_m; away += 0.01) {
    for (int k = 0; k < 5; ++k) step_gripper(q, begin, begin.origin - begin.z * away);
    path.push_back(q);
  }
  return path;
}

struct Tree {
  Path nodes;
  std::vector<int> parents;

  // Steps from the nearest node towards `target` as far as it is free: the last node, and whether it is there.
  std::pair<int, bool> extend(const Configuration& target, const Checker& checker) {
    int node = 0;
    for (size_t k = 1; k < nodes.size(); ++k) if (norm(nodes[k], target) < norm(nodes[node], target)) node = int(k);
    while (true) {
      const double length = norm(nodes[node], target);
      const Configuration q = length <= kStep ? target : between(nodes[node], target, kStep / length);
      if (!checker.motion_is_free(nodes[node], q)) return {node, false};
      nodes.push_back(q);
      parents.push_back(node);
      node = int(nodes.size()) - 1;
      if (length <= kStep) return {node, true};
    }
  }

  Path back(int node) const {
    Path path;
    for (; node >= 0; node = parents[node]) path.push_back(nodes[node]);
    return path;
  }
};

using Clock = std::chrono::steady_clock;

std::optional<Path> connect(const Checker& checker, const Configuration& start, const Configuration& goal,
                            std::mt19937_64& random, Clock::time_point deadline) {
  if (checker.motion_is_free(start, goal)) return Path{start, goal};
  Tree trees[2] = {{{start}, {-1}}, {{goal}, {-1}}};
  for (int growing = 0; Clock::now() < deadline; growing = 1 - growing) {
    Configuration sample;
    for (int j = 0; j < kJoints; ++j) sample[j] = std::uniform_real_distribution<double>(kLower[j], kUpper[j])(random);
    const int grown = trees[growing].extend(sample, checker).first;
    const auto [met, is_there] = trees[1 - growing].extend(trees[growing].nodes[grown], checker);
    if (!is_there) continue;
    Path path = trees[0].back(growing == 0 ? grown : met), rest = trees[1].back(growing == 0 ? met : grown);
    std::reverse(path.begin(), path.end());
    path.insert(path.end(), rest.begin() + 1, rest.end());
    return path;
  }
  return std::nullopt;
}

int main(int count, char** arguments) {
  if (count != 6) {
    std::fprintf(stderr, "usage: plain_rrt START IK OBSTACLES SEED TIME_LIMIT_S\n");
    return 2;
  }
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(0.9 * std::stod(arguments[5])));
  std::mt19937_64 random(std::stoull(arguments[4]));
  const Checker checker{read_triangles(arguments[3])};
  const std::vector<double> start_numbers = read_numbers(arguments[1]), numbers = read_numbers(arguments[2]);
  Configuration start;
  std::copy_n(start_numbers.begin(), kJoints, start.begin());
  std::vector<Configuration> goals(numbers.size() / kJoints);
  for (size_t k = 0; k < goals.size(); ++k) std::copy_n(numbers.begin() + long(k) * kJoints, kJoints, goals[k].begin());
  std::shuffle(goals.begin(), goals.end(), random);

  for (const Configuration& goal : goals) {
    const Path stretch = retreat(goal);
    const auto arm_is_free = [&](const Configuration& q) { return checker.is_free(q, false); };
    if (!checker.is_free(stretch.back()) || !std::all_of(stretch.begin(), stretch.end(), arm_is_free)) continue;
    // A share of the time for each goal.
    const auto share = std::min(end, Clock::now() + std::max<Clock::duration>(std::chrono::seconds(1), (end - Clock::now()) / 4));
    auto path = connect(checker, start, stretch.back(), random, share);
    if (!path) continue;
    path->insert(path->end(), stretch.rbegin() + 1, stretch.rend());
    for (const Configuration& q : *path)
      for (int j = 0; j < kJoints; ++j) std::printf("%.17g%c", q[j], j + 1 < kJoints ? ',' : '\n');
    return 0;
  }
  return 0;
}
