// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/write_tables.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdio>
#include <span>

#include "firmware/model/axis_effects.h"
#include "firmware/mpc/table_data.h"
#include "firmware/mpc/table_file.h"
#include "host_tests/lab/on_all_cores.h"

namespace m100::lab::gains {
namespace {

/// Calls each(name, span of doubles) for every array or number of a table.
template <typename Each>
void list_numbers(const mpc::GainTable<double>& table, Each&& each) {
  mpc::visit_numbers(table, [&each](const char* name, const auto& numbers) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(numbers)>>) {
      const double value = static_cast<double>(numbers);
      each(name, std::span<const double>(&value, 1));
    } else {
      each(name, std::span<const double>(numbers));
    }
  });
}

class Bytes {
 public:
  void unsigned_number(std::uint64_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      bytes_.push_back(static_cast<std::byte>(value >> (8 * i)));
    }
  }
  void number(double value) { unsigned_number(std::bit_cast<std::uint64_t>(value), 8); }
  void digest(const core::Sha256Digest& digest) {
    for (const std::uint8_t byte : digest) {
      bytes_.push_back(static_cast<std::byte>(byte));
    }
  }
  void axis(const mpc::GainTable<double>& table, const SetpointRows& rows) {
    list_numbers(table, [this](const char*, std::span<const double> numbers) {
      std::for_each(numbers.begin(), numbers.end(), [this](double value) { number(value); });
    });
    unsigned_number(rows.laws.size() / mpc::kLawNumbers, 4);
    unsigned_number(rows.nodes.size(), 4);
    const auto last = static_cast<std::ptrdiff_t>(rows.nodes.size() * mpc::kNodeNumbers);
    std::for_each(rows.planes.begin(), rows.planes.begin() + last, [this](double value) { number(value); });
    std::for_each(rows.laws.begin(), rows.laws.end(), [this](double value) { number(value); });
    for (const mpc::SetpointNode& node : rows.nodes) {
      for (const std::uint16_t child : node.child) {
        unsigned_number(child, 2);
      }
    }
  }
  std::vector<std::byte>& all() { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

std::string text_of(double value) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  std::string text(buffer.data(), end.ptr);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

/// Writes words, wrapped to the project's line width.
class Lines {
 public:
  explicit Lines(std::string& out) : out_(out) {}
  void word(const std::string& text) {
    if (line_.size() + text.size() + 2 > 119) {
      flush();
    }
    line_ += (line_.empty() ? "    " : " ") + text + ",";
  }
  void flush() {
    if (!line_.empty()) {
      out_ += line_ + "\n";
    }
    line_.clear();
  }

 private:
  std::string& out_;
  std::string line_;
};

void put_array(std::string& out, const std::string& name, std::span<const double> numbers) {
  out += "inline constexpr std::array<double, " + std::to_string(numbers.size()) + "> " + name + "{\n";
  Lines lines(out);
  for (const double number : numbers) {
    lines.word(text_of(number));
  }
  lines.flush();
  out += "};\n";
}

void put_axis(std::string& out, const std::string& name, const mpc::GainTable<double>& table,
              const SetpointRows& rows) {
  std::vector<double> list;
  std::string contents;
  list_numbers(table, [&](const char* block, std::span<const double> numbers) {
    contents += std::string(contents.empty() ? "" : ", ") + block;
    list.insert(list.end(), numbers.begin(), numbers.end());
  });
  put_array(out, "kNumbers" + name, list);
  put_array(out, "kPlanes" + name, rows.planes);
  put_array(out, "kLaws" + name, rows.laws);
  out += "inline constexpr std::array<SetpointNode, " + std::to_string(rows.nodes.size()) + "> kNodes" + name + "{{\n";
  Lines lines(out);
  for (const mpc::SetpointNode& node : rows.nodes) {
    std::string children;
    for (const std::uint16_t child : node.child) {
      children += (children.empty() ? "" : ", ") + std::to_string(child);
    }
    lines.word("{{" + children + "}}");
  }
  lines.flush();
  out += "}};\n";
  out += "template <typename T>\ninline constexpr auto kPlanes" + name + "In = rounded<T>(kPlanes" + name + ");\n";
  out += "template <typename T>\ninline constexpr auto kLaws" + name + "In = rounded<T>(kLaws" + name + ");\n\n";
}

/// Designated initialisers of one struct of the vehicle, for the members that are added.
class StructText {
 public:
  explicit StructText(const std::string& name) : text_("." + name + " = {") {}
  StructText& number(const std::string& key, double value) {
    text_ += (first_ ? "." : ", .") + key + " = " + text_of(value);
    first_ = false;
    return *this;
  }
  /// Adds a flag that is true by default, only if it is false.
  StructText& unless(const std::string& key, bool value) {
    if (!value) {
      text_ += (first_ ? "." : ", .") + key + " = false";
      first_ = false;
    }
    return *this;
  }
  StructText& shape(model::DeadZoneShape value) {
    text_ += std::string(", .dead_zone_shape = model::DeadZoneShape::") +
             (value == model::DeadZoneShape::kJump ? "kJump" : "kContinuous");
    return *this;
  }
  std::string done() const { return "    " + text_ + "},\n"; }

 private:
  std::string text_;
  bool first_ = true;
};

#define M100_FIELD(field) number(#field, from.field)

/// Writes only the numbers that differ from the struct's defaults.
std::string axis_text(const std::string& name, const model::StickAxis& from) {
  StructText text(name);
  const model::StickAxis plain;
  model::for_each_axis_number([&](const model::AxisNumber& number) {
    if (from.*number.member != plain.*number.member) {
      text.number(std::string(number.field_name()), from.*number.member);
    }
    if (number.member == &model::StickAxis::dead_zone_counts && from.dead_zone_shape != plain.dead_zone_shape) {
      text.shape(from.dead_zone_shape);
    }
  });
  return text.done();
}

std::string translation_text(const model::Translation& from) {
  std::string text = "    .translation = model::Translation{}";
  for (const auto& number : model::kTranslationNumbers) {
    const double value = from.*number.member;
    if (value != number.neutral || value != model::Translation{}.*number.member) {
      text += ".with(\"" + std::string(number.key) + "\", " + text_of(value) + ")";
    }
  }
  return text + ",\n";
}

std::string weights_text(const model::MpcWeights& from) {
  return StructText("mpc")
      .M100_FIELD(position)
      .M100_FIELD(velocity)
      .M100_FIELD(tilt)
      .M100_FIELD(input)
      .M100_FIELD(input_rate)
      .done();
}

std::string estimator_text(const model::EstimatorNoise& from) {
  return StructText("estimator")
      .M100_FIELD(position_process_m)
      .M100_FIELD(velocity_process_m_s)
      .M100_FIELD(tilt_process_rad)
      .M100_FIELD(tilt_rate_process_rad_s)
      .M100_FIELD(disturbance_process_m_s2)
      .M100_FIELD(input_offset_process_rad)
      .M100_FIELD(pose_position_sigma_m)
      .M100_FIELD(pose_velocity_sigma_m_s)
      .M100_FIELD(attitude_sigma_rad)
      .M100_FIELD(rate_sigma_rad_s)
      .done();
}

std::string height_and_yaw_text(const model::AltitudeGains& from, const model::YawGain& yaw) {
  return StructText("altitude")
             .unless("design", from.design)
             .M100_FIELD(proportional_per_s)
             .M100_FIELD(integral_per_s2)
             .M100_FIELD(derivative)
             .M100_FIELD(integral_min_m_s)
             .M100_FIELD(integral_max_m_s)
             .M100_FIELD(climb_limit_m_s)
             .done() +
         StructText("yaw")
             .number("proportional_per_s", yaw.proportional_per_s)
             .number("rate_limit_rad_s", yaw.rate_limit_rad_s)
             .done();
}
#undef M100_FIELD

/// The design as text; empty: it does not exist.
std::string design_text(const std::string& name, const model::Design& from) {
  if (!from.exists()) {
    return {};
  }
  return "    ." + name + " = {\n" + axis_text("roll", from.roll) + axis_text("pitch", from.pitch) +
         weights_text(from.mpc) + estimator_text(from.estimator) +
         "    .has_mpc = " + (from.has_mpc ? "true" : "false") +
         ", .has_estimator = " + (from.has_estimator ? "true" : "false") + "},\n";
}

std::string digest_text(const core::Sha256Digest& digest) {
  std::string out = "inline constexpr core::Sha256Digest kVehicleDigest{\n";
  Lines lines(out);
  for (const std::uint8_t byte : digest) {
    std::array<char, 8> text{};
    std::snprintf(text.data(), text.size(), "0x%02x", static_cast<unsigned>(byte));
    lines.word(text.data());
  }
  lines.flush();
  return out + "};\n\n";
}

std::string table_text(const std::string& name) {
  const std::string lower = name == "X" ? "x" : "y";
  return "/// The table of axis " + lower + " in T, float or double; it stays in flash.\n" +
         "template <typename T>\ninline constexpr GainTable<T> k" + name + " = [] {\n" +
         "  GainTable<T> table = table_of<T>(kNumbers" + name + ", kVehicleDigest);\n" +
         "  table.setpoint.nodes = kNodes" + name + ";\n  table.setpoint.planes = kPlanes" + name +
         "In<T>;\n  table.setpoint.laws = kLaws" + name + "In<T>;\n  return table;\n}();\n\n";
}

}  // namespace

TableSet make_table_set(const companion::VehicleFile& file, const SetpointBox& box, const SetpointProgress& progress) {
  const model::Vehicle vehicle = model::controller_model(file.vehicle);
  TableSet set{.tables = make_gain_tables(vehicle, file.digest), .x = {}, .y = {}};
  on_all_cores(2, [&](std::size_t i) {
    (i == 0 ? set.x : set.y) = make_setpoint_law(axis_qp(vehicle, i == 0 ? Axis::kX : Axis::kY), box, ComputeBudget(),
                                                 i == 0 ? progress : SetpointProgress{});
  });
  for (const auto& [table, rows] : {std::pair{&set.tables.x, &set.x}, {&set.tables.y, &set.y}}) {
    table->setpoint.box = rows->box;
    table->setpoint.mirror = rows->mirror;
    table->setpoint.depth = rows->depth;
  }
  return set;
}

std::vector<std::byte> to_file(const TableSet& set) {
  Bytes bytes;
  for (const char letter : mpc::kTableFileMagic) {
    bytes.unsigned_number(static_cast<std::uint8_t>(letter), 1);
  }
  bytes.unsigned_number(mpc::kTableFileVersion, 4);
  bytes.unsigned_number(0, 4);
  bytes.digest(set.tables.x.vehicle);
  bytes.axis(set.tables.x, set.x);
  bytes.axis(set.tables.y, set.y);
  bytes.digest(core::sha256(bytes.all()));
  return bytes.all();
}

std::string to_header(const TableSet& set, const model::Vehicle& vehicle) {
  std::string out =
      "// SPDX-License-Identifier: BSD-3-Clause\n"
      "// Made by `m100-lab gains --vehicle firmware/mpc/generated/vehicle.toml --out <this file>`; do not edit.\n"
      "// clang-format off\n"
      "#pragma once\n\n"
      "#include <array>\n\n"
      "#include \"firmware/model/vehicle.h\"\n"
      "#include \"firmware/mpc/gain_table.h\"\n"
      "#include \"firmware/mpc/table_data.h\"\n\n"
      "namespace m100::mpc::generated {\n\n"
      "/// SHA-256 of the vehicle file that everything here was made from.\n";
  out += digest_text(set.tables.x.vehicle);
  out += "inline constexpr model::Vehicle kVehicle{\n" + axis_text("roll", vehicle.roll) +
         axis_text("pitch", vehicle.pitch) + axis_text("yaw_rate", vehicle.yaw_rate) +
         axis_text("climb", vehicle.climb) + translation_text(vehicle.translation) + weights_text(vehicle.mpc) +
         estimator_text(vehicle.estimator) + height_and_yaw_text(vehicle.altitude, vehicle.yaw) +
         design_text("design", vehicle.design) + design_text("robust", vehicle.robust) + "};\n\n";
  out += "// Numbers in the order of visit_numbers() in table_data.h.\n";
  put_axis(out, "X", set.tables.x, set.x);
  put_axis(out, "Y", set.tables.y, set.y);
  out += table_text("X") + table_text("Y");
  out += "}  // namespace m100::mpc::generated\n";
  return out;
}

}  // namespace m100::lab::gains
