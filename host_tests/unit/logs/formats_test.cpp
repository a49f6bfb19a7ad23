// SPDX-License-Identifier: BSD-3-Clause
// Formats are recognised by their first bytes. Tests ArduPilot logs and ROS 2 bags that the test writes, and the shared
// ones.
#include <sqlite3.h>

#include <cmath>
#include <cstdint>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/proposal/propose.h"
#include "host_tests/lab/logs/raw_log.h"
#include "host_tests/shared_files.h"
#include "host_tests/unit/logs/log_files.h"
#include "host_tests/unit/logs/log_samples.h"
#include "host_tests/unit/logs/ulog_bytes.h"

namespace m100::lab::logs {
namespace {

using namespace std::string_literals;

struct Foreign {
  const char* name;
  std::string bytes;
  const char* says;
};
class ForeignFile : public ::testing::TestWithParam<Foreign> {};

// Catches a text reader that accepts every file that no other reader wants: it once printed an ArduPilot log and
// returned 0.
TEST_P(ForeignFile, IsRefusedWithoutShowingIt) {
  const std::string file = host_tests::made("a.bin", GetParam().bytes);
  const std::string said = complaint_of([&] { open_log(file); });
  EXPECT_NE(said.find(GetParam().says), std::string::npos) << said;
  EXPECT_EQ(said.find('\x01'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Table, ForeignFile,
    ::testing::Values(Foreign{"Binary", "t,x\x01\x02\x03\n0,1\n"s, "has an unknown format"},
                      Foreign{"Zeros", std::string(5000, '\0'), "has an unknown format"},
                      Foreign{"Gzip", "\x1f\x8b\x08 and so on"s, "gzip"}, Foreign{"Hdf5", "\x89HDF\r\n\x1a\n"s, "-v7"},
                      Foreign{"Mcap", "\x89MCAP0\r\n"s, "MCAP"}, Foreign{"Utf16", "\xff\xfet\0,\0x\0"s, "UTF-8"},
                      Foreign{"DataFlashText", "FMT, 128, 89, FMT, BBnNZ, Type\nATT, 1, 2\n"s, "mavlogdump"},
                      Foreign{"BlackboxCsv", "\"Product\",\"Blackbox flight data recorder\"\n"s, "loopIteration"},
                      Foreign{"Blackbox", "H Product:Blackbox flight data recorder\nH x:1\nI\x80"s, "blackbox_decode"},
                      Foreign{"Telemetry", "\x00\x05\x93\x1a\x02\x03\x04\x05\xfd\x09\x00"s, "tlog"},
                      Foreign{"Parquet", "PAR1\x15\x04"s, "Parquet"},
                      Foreign{"DjiDat", std::string(16, '\x01') + "BUILD 2016", "DatCon"},
                      Foreign{"DjiDatOfToday", std::string(242, '\x01') + "DJI_LOG_V3", "DatCon"},
                      Foreign{"OtherUlog", "ULog\x02\x02\x02\x02 and so on"s, "has an unknown format"},
                      Foreign{"OtherBase", "SQLite format 3\0"s + std::string(100, '\0'), "sqlite3"}),
    [](const auto& tested) { return tested.param.name; });

TEST(OpenLog, RefusesWhatHasNoEnd) {
  for (const char* const device : {"/dev/zero", "/dev/urandom", "/"}) {
    EXPECT_NE(complaint_of([&] { open_log(device); }).find("not a regular file"), std::string::npos) << device;
    EXPECT_NE(complaint_of([&] { read_column_map(device); }).find("not a regular file"), std::string::npos) << device;
  }
}

// --- ArduPilot ---

TEST(ArduPilot, IsReadByTheDefinitionsItCarries) {
  const std::string file = host_tests::made("a.bin", ardupilot_sample());
  const auto log = open_log(file);
  const RawColumn roll = log->column("ATT.Roll", "attitude_roll");
  ASSERT_EQ(roll.values.size(), 40U);
  EXPECT_DOUBLE_EQ(roll.values[3], 3.0) << "hundredths by its letter, and not once more by the multiplier";
  EXPECT_DOUBLE_EQ(log->column("ATT.Pitch", "x").values[3], 3.0) << "tenths by the multiplier alone";
  EXPECT_NEAR(roll.time_s[3], 1.06, 1e-9);
  EXPECT_DOUBLE_EQ(log->column("IMU.GyrX", "rate_x").values[3], 3.0);
  EXPECT_DOUBLE_EQ(log->column("IMU:1.GyrX", "rate_x").values[3], 103.0);
  EXPECT_NE(complaint_of([&] { log->column("IMU:2.GyrX", "rate_x"); }).find("no such column"), std::string::npos);
}

TEST(ArduPilot, StepsOverDamageAndHalfARecord) {
  std::string bytes = ardupilot_sample();
  bytes.insert(bytes.size() - 60, "noise \xa3\x95\xff noise");
  const std::string file = host_tests::made("a.bin", bytes.substr(0, bytes.size() - 3));
  const auto log = open_log(file);
  EXPECT_GE(log->column("ATT.Roll", "attitude_roll").values.size(), 38U);
  EXPECT_EQ(log->notes().size(), 1U);
}

TEST(ArduPilot, ReadsTheSharedFile) {
  M100_SHARED_FILE_OR_SKIP(path, "data/formats/tiny.bin");
  const auto log = open_log(path.string());
  const RawColumn roll = log->column("ATT.Roll", "attitude_roll");
  ASSERT_EQ(roll.values.size(), 50U);
  EXPECT_NEAR(roll.time_s[0], 1.0, 1e-9);
  EXPECT_NEAR(roll.time_s[1], 1.02, 1e-9);
  EXPECT_NEAR(roll.values[1], 0.8985007405, 1e-6);                   // decoded by hand, degrees
  EXPECT_NEAR(log->column("XKF1.Roll", "x").values[1], 0.89, 1e-9);  // int16 of hundredths: 89
  EXPECT_NEAR(log->column("XKF1.Yaw", "x").values[0], 90.0, 1e-9);   // uint16 of hundredths: 9000
  EXPECT_NEAR(log->column("RCIN.C1", "x").values[1], 1504.0, 1e-9);  // e0 05
}

// --- ROS 2 ---

/// The published CDR encoding: little endian, aligned after the header.
class Cdr {
 public:
  template <typename T>
  Cdr& put(T value) {
    body_.resize((body_.size() + sizeof value - 1) / sizeof value * sizeof value, '\0');
    body_ += raw(value);
    return *this;
  }
  Cdr& text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size() + 1));
    body_ += value + '\0';
    return *this;
  }
  Cdr& header(int k, const std::string& frame) {
    return put(std::int32_t{1000}).put(static_cast<std::uint32_t>(10'000'000 * k)).text(frame);
  }
  Cdr& zeros(int count) {
    for (int i = 0; i < count; ++i) {
      put(0.0);
    }
    return *this;
  }
  std::string bytes() const { return "\0\1\0\0"s + body_; }

 private:
  std::string body_;
};

class Base {
 public:
  explicit Base(const std::string& file) {
    std::filesystem::remove(file);
    EXPECT_EQ(sqlite3_open(file.c_str(), &base_), SQLITE_OK);
  }
  ~Base() { sqlite3_close(base_); }
  Base(const Base&) = delete;
  Base& operator=(const Base&) = delete;
  void run(const std::string& text) {
    EXPECT_EQ(sqlite3_exec(base_, text.c_str(), nullptr, nullptr, nullptr), 0) << text;
  }
  void message(int topic, long long t_ns, const std::string& data) {
    sqlite3_stmt* insert = nullptr;
    sqlite3_prepare_v2(base_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?,?,?)", -1, &insert, nullptr);
    sqlite3_bind_int(insert, 1, topic);
    sqlite3_bind_int64(insert, 2, t_ns);
    sqlite3_bind_blob(insert, 3, data.data(), static_cast<int>(data.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(insert), SQLITE_DONE);
    sqlite3_finalize(insert);
  }
  void tables() {
    run("CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT,type TEXT,serialization_format TEXT,"
        "offered_qos_profiles TEXT)");
    run("CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER,timestamp INTEGER,data BLOB)");
  }
  void topic(int id, const std::string& name, const std::string& type) {
    run("INSERT INTO topics VALUES(" + std::to_string(id) + ",'" + name + "','" + type + "','cdr','')");
  }

 private:
  sqlite3* base_ = nullptr;
};

constexpr long long kStart_ns = 1'000'000'000'000LL;

void write_motion(Base& base, int k) {
  const long long t_ns = kStart_ns + 10'000'000LL * k;
  const double v = k;
  Cdr imu;
  imu.header(k, "imu").put(0.0).put(0.0).put(0.0).put(1.0).zeros(9);
  imu.put(v).put(-v).put(2 * v).zeros(9).put(0.5).put(0.25).put(9.8).zeros(9);
  base.message(1, t_ns, imu.bytes());
  Cdr odometry;
  odometry.header(k, "world").text("base_link").put(v).put(2.0).put(3.0).zeros(3).put(1.0).zeros(36);
  base.message(2, t_ns, odometry.put(-v).zeros(5).zeros(36).bytes());
  base.message(5, t_ns, Cdr().header(k, "w").put(v).put(1.0).put(2.0).zeros(3).bytes());
}

void write_sticks_and_attitude(Base& base, int k) {
  const long long t_ns = kStart_ns + 10'000'000LL * k;
  Cdr joy;
  joy.header(k, "").put(std::uint32_t{4}).put(0.1F * static_cast<float>(k)).put(0.F).put(-1.F).put(1.F);
  base.message(3, t_ns, joy.put(std::uint32_t{1}).put(std::int32_t{3}).bytes());
  const double half = 0.5 * 0.01 * k;
  const Cdr attitude = Cdr().header(k, "FLU").put(0.0).put(0.0).put(std::sin(half)).put(std::cos(half));
  base.message(4, t_ns, attitude.bytes());
  base.message(6, t_ns, "\0\1\0\0 whatever"s);
}

/// Writes thirty messages of each type that needs no definition, and of one unknown type.
void write_bag(const std::string& path) {
  Base base(path);
  base.run("BEGIN");
  base.tables();
  base.topic(1, "/imu", "sensor_msgs/msg/Imu");
  base.topic(2, "/odom", "nav_msgs/msg/Odometry");
  base.topic(3, "/dji_sdk/rc", "sensor_msgs/msg/Joy");
  base.topic(4, "/dji_sdk/attitude", "geometry_msgs/msg/QuaternionStamped");
  base.topic(5, "/twist", "geometry_msgs/msg/TwistStamped");
  base.topic(6, "/other", "somebody_msgs/msg/Unknown");
  for (int k = 0; k < 30; ++k) {
    write_motion(base, k);
    write_sticks_and_attitude(base, k);
  }
  base.run("COMMIT");
}

TEST(RosBag2, DecodesItsTypesWithoutDefinitions) {
  const std::string file = host_tests::made("a.db3", "");
  write_bag(file);
  const auto log = open_log(file);
  EXPECT_DOUBLE_EQ(log->column("/imu.angular_velocity.y", "rate_y").values[7], -7.0);
  EXPECT_DOUBLE_EQ(log->column("/imu.linear_acceleration.z", "force_z").values[7], 9.8);
  EXPECT_DOUBLE_EQ(log->column("/odom.pose.pose.position.x", "position_x").values[7], 7.0);
  EXPECT_DOUBLE_EQ(log->column("/odom.twist.twist.linear.x", "velocity_x").values[7], -7.0);
  EXPECT_NEAR(log->column("/dji_sdk/rc.axes[0]", "stick_roll").values[7], 0.7, 1e-6);
  EXPECT_DOUBLE_EQ(log->column("/dji_sdk/rc.buttons[0]", "x").values[7], 3.0);
  EXPECT_DOUBLE_EQ(log->column("/twist.twist.linear.z", "x").values[7], 2.0);
  EXPECT_NEAR(log->column("/twist.time", "x").values[7], 0.07, 1e-6);
  EXPECT_NE(complaint_of([&] { log->column("/other.x", "x"); }).find("is unknown, and the bag"), std::string::npos);

  const auto proposal = propose(*log);
  ASSERT_TRUE(proposal);
  const FlightLog flight = load(*log, parse_column_map(proposal->toml, "proposed"));
  EXPECT_NEAR(flight.of(Signal::kAttitudeYaw)[20], 0.2, 1e-6);
  EXPECT_NEAR(flight.of(Signal::kStickRoll)[20], 2.0 * 660.0, 1e-3);
  EXPECT_NEAR(flight.of(Signal::kStickYaw)[20], -660.0, 1e-3);
}

// A view can be an endless program. A file is data and must not be executed.
TEST(RosBag2, RefusesAViewInThePlaceOfATable) {
  const std::string file = host_tests::made("a.db3", "");
  {
    Base base(file);
    base.run("CREATE TABLE topics(id INTEGER,name TEXT,type TEXT,serialization_format TEXT)");
    base.run(
        "CREATE VIEW messages AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x+1 FROM c) "
        "SELECT x AS topic_id, x AS timestamp, x AS data FROM c");
  }
  EXPECT_NE(complaint_of([&] { open_log(file); }).find("not a ROS 2 bag"), std::string::npos);
}

class SharedBag : public ::testing::TestWithParam<const char*> {};

TEST_P(SharedBag, IsRead) {
  M100_SHARED_FILE_OR_SKIP(path, std::string("data/formats/") + GetParam());
  const auto log = open_log(path.string());
  const RawColumn x = log->column("/pose.pose.position.x", "position_x");
  ASSERT_EQ(x.values.size(), 25U);
  EXPECT_DOUBLE_EQ(x.values[3], 0.13);  // decoded by hand
  EXPECT_NEAR(x.time_s[3], 0.125, 1e-6) << "the stamp of the header, 5 ms before the arrival";
  EXPECT_DOUBLE_EQ(log->column("/odom.pose.pose.position.y", "position_y").values[3], 2.0);
  EXPECT_DOUBLE_EQ(log->column("/dji_sdk/attitude.quaternion.w", "attitude_qw").values[3], 1.0);
  EXPECT_NEAR(log->column("/imu.orientation.w", "attitude_qw").values[3], 0.9928086358538663, 1e-15);
}

INSTANTIATE_TEST_SUITE_P(Shared, SharedBag, ::testing::Values("bag_humble.db3", "bag_foxy.db3"),
                         [](const auto& tested) { return std::string(tested.param).substr(4, 4); });

}  // namespace
}  // namespace m100::lab::logs
