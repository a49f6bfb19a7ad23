// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/ros_types.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <sstream>

#include "host_tests/lab/logs/formats/read_number.h"

namespace m100::lab::logs {
namespace {

constexpr std::size_t kLongestArray = 64;  // longer ones (images, scans) are skipped
constexpr int kDeepest = 12;
constexpr std::size_t kCdrHeadBytes = 4;

double stamp(const char* bytes) { return read_as<std::uint32_t>(bytes) + 1e-9 * read_as<std::uint32_t>(bytes + 4); }

struct Basic {
  std::size_t bytes;
  std::size_t alignment;
  double (*read)(const char*);
};

const Basic* basic(std::string_view type) {
  static const std::map<std::string, Basic, std::less<>> types{{"bool", {1, 1, &read_as<std::uint8_t>}},
                                                               {"byte", {1, 1, &read_as<std::uint8_t>}},
                                                               {"char", {1, 1, &read_as<std::uint8_t>}},
                                                               {"int8", {1, 1, &read_as<std::int8_t>}},
                                                               {"uint8", {1, 1, &read_as<std::uint8_t>}},
                                                               {"int16", {2, 2, &read_as<std::int16_t>}},
                                                               {"uint16", {2, 2, &read_as<std::uint16_t>}},
                                                               {"int32", {4, 4, &read_as<std::int32_t>}},
                                                               {"uint32", {4, 4, &read_as<std::uint32_t>}},
                                                               {"int64", {8, 8, &read_as<std::int64_t>}},
                                                               {"uint64", {8, 8, &read_as<std::uint64_t>}},
                                                               {"float32", {4, 4, &read_as<float>}},
                                                               {"float64", {8, 8, &read_as<double>}},
                                                               {"time", {8, 4, &stamp}},
                                                               {"duration", {8, 4, &stamp}}};
  const auto found = types.find(type);
  return found == types.end() ? nullptr : &found->second;
}

/// Replaces ROS 2's builtin_interfaces/Time by ROS 1's time; both are the same eight bytes.
std::string plain_type(const std::string& type) {
  if (type.ends_with("builtin_interfaces/Time") || type.ends_with("builtin_interfaces/msg/Time")) {
    return "time";
  }
  if (type.ends_with("builtin_interfaces/Duration") || type.ends_with("builtin_interfaces/msg/Duration")) {
    return "duration";
  }
  return type.substr(0, type.starts_with("string<=") ? 6 : type.size());
}

/// Shortens "geometry_msgs/msg/Pose" to "geometry_msgs/Pose", which is the same type.
std::string short_name(const std::string& type) {
  const std::size_t middle = type.find("/msg/");
  return middle == std::string::npos ? type : type.substr(0, middle) + type.substr(middle + 4);
}

constexpr const char* kHeader = "MSG: std_msgs/Header\ntime stamp\nstring frame_id\n";
constexpr const char* kShapes =
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
    "MSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n"
    "MSG: geometry_msgs/Twist\nVector3 linear\nVector3 angular\n"
    "MSG: geometry_msgs/Transform\nVector3 translation\nQuaternion rotation\n"
    "MSG: geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n"
    "MSG: geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance\n";

struct Known {
  const char* type;
  const char* fields;
};
constexpr std::array<Known, 9> kKnown{
    {{"sensor_msgs/Imu",
      "Quaternion orientation\nfloat64[9] orientation_covariance\nVector3 angular_velocity\n"
      "float64[9] angular_velocity_covariance\nVector3 linear_acceleration\n"
      "float64[9] linear_acceleration_covariance\n"},
     {"sensor_msgs/Joy", "float32[] axes\nint32[] buttons\n"},
     {"geometry_msgs/PoseStamped", "Pose pose\n"},
     {"geometry_msgs/PoseWithCovarianceStamped", "PoseWithCovariance pose\n"},
     {"geometry_msgs/QuaternionStamped", "Quaternion quaternion\n"},
     {"geometry_msgs/TransformStamped", "string child_frame_id\nTransform transform\n"},
     {"geometry_msgs/TwistStamped", "Twist twist\n"},
     {"geometry_msgs/Vector3Stamped", "Vector3 vector\n"},
     {"nav_msgs/Odometry", "string child_frame_id\nPoseWithCovariance pose\nTwistWithCovariance twist\n"}}};

}  // namespace

const char* RosType::known_definition(const std::string& type) {
  static const std::map<std::string, std::string> texts = [] {
    std::map<std::string, std::string> out;
    for (const Known& known : kKnown) {
      out[known.type] = std::string("Header header\n") + known.fields + kHeader + kShapes;
    }
    return out;
  }();
  const auto found = texts.find(short_name(type));
  return found == texts.end() ? nullptr : found->second.c_str();
}

RosType::RosType(const std::string& own, const std::string& text, RosWire wire) : wire_(wire) {
  std::map<std::string, int> numbers{{short_name(own), 0}};
  definitions_.resize(1);
  std::size_t present = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string type, name, more;
    words >> type >> name >> more;
    if (type == "MSG:") {
      const auto [place, is_new] = numbers.emplace(short_name(name), static_cast<int>(definitions_.size()));
      definitions_.resize(definitions_.size() + (is_new ? 1 : 0));
      present = static_cast<std::size_t>(place->second);
    } else if (!name.empty() && name.find('=') == std::string::npos && !more.starts_with("=") &&
               type.rfind("==", 0) != 0) {
      definitions_[present].fields.push_back(field_of(type, name));
    }
  }
  find_inner_types(numbers);
  find_bytes();
}

RosType::Field RosType::field_of(const std::string& type, const std::string& name) {
  Field field{.name = name, .type = type, .array = false, .fixed = 0, .inner = -1};
  if (const std::size_t bracket = type.find('['); bracket != std::string::npos) {
    field.array = true;
    field.type = type.substr(0, bracket);
    // "[3]" means three; for "[]" and "[<=3]" the message gives the count.
    static_cast<void>(std::from_chars(type.data() + bracket + 1, type.data() + type.size(), field.fixed));
  }
  field.type = plain_type(field.type);
  return field;
}

void RosType::find_inner_types(const std::map<std::string, int>& numbers) {
  std::map<std::string, int> endings;  // inside its package a type is named without the package
  for (const auto& [name, index] : numbers) {
    endings.emplace(name.substr(name.rfind('/') + 1), index);
  }
  for (Definition& definition : definitions_) {
    for (Field& field : definition.fields) {
      if (basic(field.type) != nullptr || field.type == "string") {
        definition.has_bytes = true;
      } else if (const auto exact = numbers.find(short_name(field.type)); exact != numbers.end()) {
        field.inner = exact->second;
      } else if (const auto ending = endings.find(field.type); ending != endings.end()) {
        field.inner = ending->second;
      }
      definition.has_bytes = definition.has_bytes || field.inner < 0 || (field.array && field.fixed == 0);
    }
  }
}

/// Marks the types that hold bytes: a type does if an inner type does. Repeats as often as types may be nested.
void RosType::find_bytes() {
  for (int round = 0; round < kDeepest; ++round) {
    for (Definition& definition : definitions_) {
      for (const Field& field : definition.fields) {
        definition.has_bytes =
            definition.has_bytes || (field.inner >= 0 && definitions_[static_cast<std::size_t>(field.inner)].has_bytes);
      }
    }
  }
}

/// Walks through one message along its definition.
class RosType::Walker {
 public:
  Walker(const RosType& type, std::string_view bytes, bool named, const Visit& visit)
      : type_(type), all_(bytes), named_(named), visit_(visit) {}

  bool message() {
    if (type_.wire_ == RosWire::kCdr) {
      if (all_.size() < kCdrHeadBytes || all_[0] != 0 || all_[1] != 1) {
        return fail("is not in little-endian CDR");
      }
      all_.remove_prefix(kCdrHeadBytes);
    }
    return structure(0, "", 0, true);
  }
  const std::string& error_text() const { return error_text_; }

 private:
  bool fail(const std::string& what) {
    error_text_ = what;
    return false;
  }

  /// The next bytes; nullptr: there are fewer.
  const char* take(std::size_t count, std::size_t alignment) {
    if (type_.wire_ == RosWire::kCdr) {
      at_ = (at_ + alignment - 1) / alignment * alignment;
    }
    if (at_ > all_.size() || count > all_.size() - at_) {
      error_text_ = "is shorter than its definition";
      return nullptr;
    }
    const char* const out = all_.data() + at_;
    at_ += count;
    return out;
  }

  bool length(std::size_t& count) {
    const char* const bytes = take(4, 4);
    count = bytes == nullptr ? 0 : static_cast<std::size_t>(read_as<std::uint32_t>(bytes));
    return bytes != nullptr;
  }

  bool structure(std::size_t index, const std::string& path, int depth, bool show) {
    if (depth > kDeepest) {
      return fail("is nested too deeply");
    }
    for (const Field& field : type_.definitions_[index].fields) {
      const std::string below = !named_ ? std::string() : path.empty() ? field.name : path + "." + field.name;
      if (!(field.array ? array(field, below, depth, show)
                        : is_empty_type(field) || value(field, below, depth, show))) {
        return false;
      }
    }
    return true;
  }

  bool is_empty_type(const Field& field) const {
    return field.inner >= 0 && !type_.definitions_[static_cast<std::size_t>(field.inner)].has_bytes;
  }

  bool array(const Field& field, const std::string& path, int depth, bool show) {
    std::size_t count = field.fixed;
    return (count != 0 || length(count)) && (is_empty_type(field) || elements(field, count, path, depth, show));
  }

  bool elements(const Field& field, std::size_t count, const std::string& path, int depth, bool show) {
    if (count > all_.size() - std::min(at_, all_.size())) {  // each element has at least one byte
      return fail("is shorter than its definition");
    }
    const Basic* const plain = basic(field.type);
    if (plain != nullptr && count > kLongestArray) {
      return take(count * plain->bytes, plain->alignment) != nullptr;
    }
    for (std::size_t k = 0; k < count; ++k) {
      const std::string full = named_ ? path + "[" + std::to_string(k) + "]" : std::string();
      if (!value(field, full, depth, show && k < kLongestArray)) {
        return false;
      }
    }
    return true;
  }

  bool value(const Field& field, const std::string& path, int depth, bool show) {
    if (const Basic* const plain = basic(field.type)) {
      const char* const bytes = take(plain->bytes, plain->alignment);
      if (bytes != nullptr && show) {
        visit_(path, plain->read(bytes));
      }
      return bytes != nullptr;
    }
    if (field.type == "string") {
      std::size_t count = 0;
      return length(count) && take(count, 1) != nullptr;
    }
    return field.inner >= 0 ? structure(static_cast<std::size_t>(field.inner), path, depth + 1, show)
                            : fail("uses the type " + field.type + " without defining it");
  }

  const RosType& type_;
  std::string_view all_;
  bool named_;
  const Visit& visit_;
  std::size_t at_ = 0;
  std::string error_text_;
};

std::string RosType::walk(std::string_view message, bool named, const Visit& visit) const {
  Walker walker(*this, message, named, visit);
  return walker.message() ? std::string() : walker.error_text();
}

}  // namespace m100::lab::logs
