// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#ifdef M100_BZIP2
#include <bzlib.h>
#endif

#include <cstdint>

#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/refusal.h"
#include "host_tests/unit/logs/log_files.h"
#include "host_tests/unit/logs/log_samples.h"

namespace m100::lab::logs {
namespace {

std::string stamp(double t_s) {
  const auto whole = static_cast<std::uint32_t>(t_s);
  return raw(whole) + raw(static_cast<std::uint32_t>((t_s - whole) * 1e9));
}

constexpr const char* kHeaderText = R"(================================
MSG: std_msgs/Header
# a comment
uint32 seq
time stamp
string frame_id
)";
const std::string kPoseText = std::string("Header header\ngeometry_msgs/Pose pose\n") + kHeaderText +
                              "====\nMSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n"
                              "====\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
                              "====\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
const std::string kJoyText =
    std::string("Header header\nfloat32[] axes\nint32[] buttons\nint32 KIND=3 # a constant\n") + kHeaderText;

std::string connection(std::uint32_t number, const std::string& topic, const std::string& type,
                       const std::string& text) {
  return bag_record(bag_field("op", "\x07") + bag_field("conn", raw(number)) + bag_field("topic", topic),
                    bag_field("topic", topic) + bag_field("type", type) + bag_field("md5sum", "x") +
                        bag_field("message_definition", text));
}
std::string message(std::uint32_t number, double t_s, const std::string& data) {
  return bag_record(bag_field("op", "\x02") + bag_field("conn", raw(number)) + bag_field("time", stamp(t_s)), data);
}
std::string header(std::uint32_t seq, double t_s) { return raw(seq) + stamp(t_s) + sized("world"); }

constexpr double kStart_s = 1.4e9;

/// Two seconds of poses at 100 Hz and sticks at 50 Hz.
std::string messages() {
  std::string out = connection(0, "/vicon/m100", "geometry_msgs/PoseStamped", kPoseText) +
                    connection(1, "/joy", "sensor_msgs/Joy", kJoyText);
  for (int k = 0; k < 200; ++k) {
    const double t_s = kStart_s + 0.01 * k;
    out += message(0, t_s + 0.003,
                   header(static_cast<std::uint32_t>(k), t_s) + raw(0.5 * k) + raw(-1.0) + raw(2.0) + raw(0.0) +
                       raw(0.0) + raw(0.0) + raw(1.0));
    if (k % 2 == 0) {
      out += message(1, t_s,
                     header(static_cast<std::uint32_t>(k / 2), t_s) + raw(std::uint32_t{2}) +
                         raw(static_cast<float>(k)) + raw(0.25F) + raw(std::uint32_t{1}) + raw(std::int32_t{7}));
    }
  }
  return out;
}

std::string bag(const std::string& compression, const std::string& chunk, std::size_t size) {
  return "#ROSBAG V2.0\n" +
         bag_record(bag_field("op", "\x03") + bag_field("index_pos", raw(std::uint64_t{0})), std::string(100, ' ')) +
         bag_record(bag_field("op", "\x05") + bag_field("compression", compression) +
                        bag_field("size", raw(static_cast<std::uint32_t>(size))),
                    chunk) +
         bag_record(bag_field("op", "\x04") + bag_field("ver", raw(std::uint32_t{1})), "index, which nobody needs");
}

TEST(RosBag, IsReadByTheDefinitionsItCarries) {
  const std::string inside = messages();
  const std::string file = host_tests::made("plain.bag", bag("none", inside, inside.size()));
  const ColumnMap map = parse_column_map(R"(time = "/vicon/m100.time"
[signals]
position_x = "/vicon/m100.pose.position.x"
position_z = "/vicon/m100.pose.position.z"
stick_roll = "/joy.axes[0]"
[extra]
button = "/joy.buttons[0]"
w = "/vicon/m100.pose.orientation.w"
)",
                                         "map.toml");
  const FlightLog log = load(*open_log(file), map);
  ASSERT_GE(log.size, 198U);
  EXPECT_NEAR(log.of(Signal::kPositionX)[100], 0.5 * 100.0 - 0.5 * 0.3, 0.31) << "stamps of the header, not of arrival";
  EXPECT_DOUBLE_EQ(log.of(Signal::kPositionZ)[50], 2.0);
  EXPECT_NEAR(log.of(Signal::kStickRoll)[101], 101.0, 0.31);
  EXPECT_DOUBLE_EQ(log.extra.at("button")[10], 7.0);
  EXPECT_DOUBLE_EQ(log.extra.at("w")[10], 1.0);
}

std::string error_text(const std::string& file, const std::string& column) {
  return host_tests::refusal_by<InputError>([&] { (void)open_log(file)->column(column, "a test"); });
}

TEST(RosBag, UnknownTopicsFieldsAndCompressionsAreOneClearError) {
  const std::string inside = messages();
  const std::string file = host_tests::made("plain.bag", bag("none", inside, inside.size()));
  EXPECT_NE(error_text(file, "/joystick.axes[0]").find("/joy.axes[0]"), std::string::npos) << "offers what is near";
  for (const char* const wrong : {"/joy.axes[9]", "/none.x"}) {
    const ColumnMap map = parse_column_map("time = \"" + std::string(wrong) + "\"\n[signals]\nrate_x = \"x\"", "map");
    EXPECT_EQ(complaint_of([&] { load(*open_log(file), map); }).rfind("map:1: 'time': " + file + ": '" + wrong, 0), 0U);
  }
  EXPECT_NE(error_text(host_tests::made("lz4.bag", bag("lz4", inside, inside.size())), "/joy.axes[0]").find("lz4"),
            std::string::npos);
  EXPECT_NE(error_text(host_tests::made("old.bag", "#ROSLOG V1.1\n"), "/joy.axes[0]"), "");
  EXPECT_NE(error_text(host_tests::made("none.bag", bag("none", "", 0)), "/joy.axes[0]").find("no message"),
            std::string::npos);
}

#ifdef M100_BZIP2
TEST(RosBag, Bz2ChunksAreTheSameBag) {
  std::string inside = messages();
  std::string packed(inside.size() + 1000, '\0');
  auto size = static_cast<unsigned>(packed.size());
  ASSERT_EQ(
      BZ2_bzBuffToBuffCompress(packed.data(), &size, inside.data(), static_cast<unsigned>(inside.size()), 9, 0, 0),
      BZ_OK);
  packed.resize(size);
  const std::string plain = host_tests::made("plain.bag", bag("none", inside, inside.size()));
  const std::string file = host_tests::made("packed.bag", bag("bz2", packed, inside.size()));
  EXPECT_EQ(open_log(file)->column("/joy.axes[0]", "a test").values,
            open_log(plain)->column("/joy.axes[0]", "a test").values);
  packed[packed.size() / 2] = static_cast<char>(~packed[packed.size() / 2]);
  EXPECT_NE(
      error_text(host_tests::made("damaged.bag", bag("bz2", packed, inside.size())), "/joy.axes[0]").find("damaged"),
      std::string::npos);
}
#endif

// Catches a length field that is trusted: every truncation must end in an error or in fewer messages, never in a crash.
TEST(RosBag, EveryTruncationIsSurvived) {
  const std::string inside = messages().substr(0, 3000);
  const std::string whole = bag("none", inside, inside.size());
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    const std::string file = host_tests::made("cut.bag", whole.substr(0, length));
    if (error_text(file, "/joy.axes[0]").empty()) {  // all of the messages are there, and a note reports the truncation
      EXPECT_FALSE(open_log(file)->notes().empty()) << length;
    }
  }
}

}  // namespace
}  // namespace m100::lab::logs
