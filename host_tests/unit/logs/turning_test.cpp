// SPDX-License-Identifier: BSD-3-Clause
// Quaternions and frames of reference, compared with rotations that are computed in another way; spoilt rows; joined
// logs.
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/join.h"
#include "host_tests/lab/logs/quaternion.h"
#include "host_tests/unit/logs/log_files.h"

namespace m100::lab::logs {
namespace {

constexpr std::size_t kSize = 200;

std::vector<double> clock() {
  std::vector<double> t(kSize);
  for (std::size_t k = 0; k < kSize; ++k) {
    t[k] = 0.01 * static_cast<double>(k);
  }
  return t;
}

struct Motion {
  double roll, pitch, yaw;
};
Motion motion(double t_s) { return {0.4 * std::sin(3.0 * t_s), 0.3 * std::cos(2.0 * t_s), 2.5 * t_s}; }

Eigen::Matrix3d rotation(const Motion& m) {
  return (Eigen::AngleAxisd(m.yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(m.pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(m.roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

TEST(Quaternion, GivesTheAnglesThatItWasMadeOf) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-1.5, 1.5);
  for (int k = 0; k < 200; ++k) {
    const Motion m{2.0 * angle(random), angle(random), 2.0 * angle(random)};
    const Eigen::Quaterniond q(rotation(m));
    const auto euler = euler_zyx({2.0 * q.w(), 2.0 * q.x(), 2.0 * q.y(), 2.0 * q.z()});
    EXPECT_NEAR(euler[0], m.roll, 1e-9);
    EXPECT_NEAR(euler[1], m.pitch, 1e-9);
    EXPECT_NEAR(euler[2], m.yaw, 1e-9);
  }
}

constexpr const char* kQuaternionMap = R"(time = "t"
[signals]
attitude_qw = "w"
attitude_qx = "x"
attitude_qy = "y"
attitude_qz = "z"
)";

/// The body's attitude in a log, in either convention. The sign of the quaternion changes at random, as in real logs.
std::map<std::string, std::vector<double>> attitude_columns(bool ned) {
  const Eigen::Matrix3d turn = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  std::mt19937 random(2);
  std::map<std::string, std::vector<double>> out{{"t", clock()}};
  for (const double t_s : clock()) {
    const Eigen::Matrix3d r = rotation(motion(t_s));
    Eigen::Quaterniond q(ned ? Eigen::Matrix3d(turn * r * turn) : r);
    q.coeffs() *= random() % 2 == 0 ? 1.0 : -1.0;
    out["w"].push_back(q.w());
    out["x"].push_back(q.x());
    out["y"].push_back(q.y());
    out["z"].push_back(q.z());
  }
  return out;
}

TEST(ColumnMapFrame, BothConventionsTellTheSameAttitude) {
  for (const bool ned : {false, true}) {
    const MemoryLog raw(attitude_columns(ned));
    const std::string frame = ned ? "frame = \"ned_frd\"\n" : "";
    const FlightLog log = load(raw, parse_column_map(frame + kQuaternionMap, "map"));
    for (std::size_t k = 0; k < log.size; ++k) {
      const Motion m = motion(log.time_s(k));
      EXPECT_NEAR(log.of(Signal::kAttitudeRoll)[k], m.roll, 1e-9) << ned << k;
      EXPECT_NEAR(log.of(Signal::kAttitudePitch)[k], m.pitch, 1e-9) << ned << k;
      EXPECT_NEAR(log.of(Signal::kAttitudeYaw)[k], m.yaw, 1e-9) << ned << k;  // unwrapped beyond half a turn
    }
  }
}

// Vectors are compared with an independent rotation: half a turn about x, of the world for world vectors and of the
// body for body vectors.
TEST(ColumnMapFrame, TurnsEveryVectorByHalfATurnAboutX) {
  const Eigen::AngleAxisd half(std::acos(-1.0), Eigen::Vector3d::UnitX());
  for (const char* const name : {"rate", "position", "velocity", "force"}) {
    const Eigen::Vector3d vector(0.3, -1.2, 2.5);
    std::map<std::string, std::vector<double>> columns{{"t", clock()}};
    std::string map = "frame = \"ned_frd\"\ntime = \"t\"\n[signals]\n";
    for (int i = 0; i < 3; ++i) {
      const std::string axis(1, "xyz"[i]);
      columns[axis].assign(kSize, vector[i]);
      map += std::string(name) + "_" + axis + " = \"" + axis + "\"\n";
    }
    const FlightLog log = load(MemoryLog(columns), parse_column_map(map, "map"));
    const Eigen::Vector3d turned = half * vector;
    for (int i = 0; i < 3; ++i) {
      const auto signal = signal_of(std::string(name) + "_" + std::string(1, "xyz"[i]));
      EXPECT_NEAR(log.of(*signal)[5], turned[i], 1e-12) << name << i;
    }
  }
  // The body's z axis points downwards in one convention and upwards in the other; when level it is (0, 0, 1) in both.
  const Motion m = motion(0.4);
  const Eigen::Vector3d up = rotation(m).col(2);
  const Eigen::Vector3d down_ned = half * Eigen::Vector3d(-up);
  std::map<std::string, std::vector<double>> columns{{"t", clock()}};
  for (int i = 0; i < 3; ++i) {
    columns[std::string(1, "xyz"[i])].assign(kSize, down_ned[i]);
  }
  const FlightLog log = load(MemoryLog(columns), parse_column_map("frame = \"ned_frd\"\ntime = \"t\"\n[signals]\n"
                                                                  "thrust_dir_x = \"x\"\nthrust_dir_y = \"y\"\n"
                                                                  "thrust_dir_z = \"z\"\n",
                                                                  "map"));
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(log.of(offset(Signal::kThrustDirX, i))[5], up[i], 1e-12);
  }
}

TEST(ColumnMapFrame, TakesDegreesByTheScale) {
  std::map<std::string, std::vector<double>> columns{{"t", clock()}, {"p", std::vector<double>(kSize, 30.0)}};
  const FlightLog log =
      load(MemoryLog(columns), parse_column_map("frame = \"ned_frd\"\ntime = \"t\"\n[signals]\n"
                                                "attitude_pitch = {column = \"p\", scale = 0.017453292519943295}\n",
                                                "map"));
  EXPECT_NEAR(log.of(Signal::kAttitudePitch)[3], -std::acos(-1.0) / 6.0, 1e-12);
}

TEST(Quaternion, RefusesWhatIsNone) {
  auto columns = attitude_columns(false);
  for (double& w : columns["w"]) {
    w *= 57.3;
  }
  EXPECT_NE(
      complaint_of([&] { load(MemoryLog(columns), parse_column_map(kQuaternionMap, "map")); }).find("unit length"),
      std::string::npos);
  const std::string three = "time = \"t\"\n[signals]\nattitude_qw = \"w\"\nattitude_qx = \"x\"\nattitude_qy = \"y\"\n";
  EXPECT_NE(complaint_of([&] { parse_column_map(three, "map"); }).find("'attitude_qz': is missing"), std::string::npos);
  const std::string both = std::string(kQuaternionMap) + "attitude_roll = \"w\"\n";
  EXPECT_NE(complaint_of([&] { parse_column_map(both, "map"); }).find("keep one"), std::string::npos);
  EXPECT_NE(complaint_of([&] { parse_column_map("frame = \"enu\"\n" + both, "map"); }).find("ned_frd"),
            std::string::npos);
}

// An unusable cell must be a gap of its signal only; the rest of the log must not change.
TEST(SpoiltRows, AreGapsOfTheirSignalOnly) {
  std::map<std::string, std::vector<double>> columns{{"t", clock()}, {"a", clock()}, {"b", clock()}};
  columns["a"][50] = std::numeric_limits<double>::quiet_NaN();
  columns["a"].back() = std::numeric_limits<double>::infinity();
  const FlightLog log =
      load(MemoryLog(columns), parse_column_map("time = \"t\"\n[signals]\nrate_x = \"a\"\nrate_y = \"b\"\n", "map"));
  const auto a = log.gap_of({Signal::kRateX});
  const auto b = log.gap_of({Signal::kRateY});
  for (std::size_t k = 0; k + 1 < log.size; ++k) {
    EXPECT_EQ(a[k], k == 50 ? 1 : 0) << k;
    EXPECT_EQ(b[k], 0) << k;
    EXPECT_NEAR(log.of(Signal::kRateX)[k], log.time_s(k), 1e-9) << k;
  }
  EXPECT_EQ(log.gap[50], 1) << "of some signal";
}

TEST(SpoiltRows, OfTheClockCostOneRowAndNotTheLog) {
  for (const double stamp : {std::numeric_limits<double>::quiet_NaN(), 1e30, -5.0}) {
    std::map<std::string, std::vector<double>> columns{{"t", clock()}, {"a", clock()}};
    columns["t"][50] = stamp;
    const FlightLog log =
        load(MemoryLog(columns), parse_column_map("time = \"t\"\n[signals]\nrate_x = \"a\"\n", "map"));
    EXPECT_EQ(log.size, kSize) << stamp;
    EXPECT_EQ(log.gap[50], 1) << stamp;
    EXPECT_NEAR(log.of(Signal::kRateX)[120], 1.2, 1e-9) << stamp;
  }
}

FlightLog ramp(double from_s, std::size_t size) {
  FlightLog log;
  log.file = "ramp";
  log.start_s = from_s;
  log.size = size;
  log.gap.assign(size, 0);
  for (std::size_t k = 0; k < size; ++k) {
    log.of(Signal::kRateX).push_back(log.time_s(k));
  }
  log.of(Signal::kRateY) = log.of(Signal::kRateX);
  return log;
}

TEST(JoinedLogs, KeepTheirClocksAndForgetEachOther) {
  std::vector<FlightLog> two{ramp(5.0, 100), ramp(70.0, 200)};
  two[1].of(Signal::kRateY).clear();
  two[0].velocity_mean_s = two[1].velocity_mean_s = 0.1;
  two[0].row_s[Signal::kRateX] = two[1].row_s[Signal::kRateX] = 0.0025;
  const FlightLog log = joined(std::move(two));
  ASSERT_EQ(log.flights.size(), 2U);
  EXPECT_FALSE(log.has(Signal::kRateY)) << "not in every log";
  EXPECT_EQ(log.velocity_mean_s, 0.1);
  EXPECT_EQ(log.logged_row_of(Signal::kRateX), 0.0025);
  EXPECT_EQ(log.size, 100U + 500U + 200U);
  const auto gap = log.gap_of({Signal::kRateX});
  for (std::size_t k = 0; k < log.size; ++k) {
    EXPECT_EQ(gap[k], k >= 100 && k < 600 ? 1 : 0) << k;
  }
  EXPECT_DOUBLE_EQ(log.of(Signal::kRateX)[300], 70.0) << "in the pause stands what the next log begins with";
  EXPECT_NEAR(log.of(Signal::kRateX)[log.index_of(joined_time(log, 1, 70.5))], 70.5, 1e-9);
  EXPECT_EQ(place_of(log, joined_time(log, 1, 70.5)), "2@70.50 s");
  EXPECT_EQ(place_of(log, 5.25), "1@5.25 s");
  EXPECT_EQ(log.notes.front(), "log 2: its time 70.00 s is 11.00 s on the common clock, which the result uses");
  EXPECT_EQ(place_of(ramp(5.0, 50), 5.25), "5.25 s");
}

}  // namespace
}  // namespace m100::lab::logs
