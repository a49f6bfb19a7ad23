// SPDX-License-Identifier: BSD-3-Clause
// m100-lab reference: prints the keys, words and messages of the programs with their meanings, as pages or as JSON.
#include <algorithm>
#include <array>
#include <charconv>
#include <iostream>
#include <memory>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/course/course.h"
#include "firmware/companion/files/flight_file.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/companion/files/vehicle_file.h"
#include "firmware/companion/files/vehicle_keys.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/logs/signal.h"
#include "host_tests/lab/reference/reference_text.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/sim/autopilot/n1_script_syntax.h"
#include "host_tests/sim/world/plant_keys.h"

namespace m100::lab {
namespace reference {
namespace {

/// One key or word from the code's own table.
struct Row {
  std::string section;  ///< "[fence]"; the heading on the page
  std::string key;
  std::vector<std::string> cells;  ///< the page's columns between the key and its meaning
};

/// One reference page: the part of it that the code's tables know.
struct Table {
  std::string page;                  ///< its name
  std::vector<std::string> columns;  ///< headings of the cells
  std::vector<Row> rows;
};

using companion::NumberKey;

/// The unit that the ending of a key stands for; longer endings come first.
struct Unit {
  std::string_view ending;
  std::string_view unit;
};
constexpr std::array kUnits{Unit{"_rad_s_per_count", "(rad/s)/count"},
                            Unit{"_m_s_per_count", "(m/s)/count"},
                            Unit{"_rad_per_count", "rad/count"},
                            Unit{"_per_minute", "1/min"},
                            Unit{"_per_s2", "1/s^2"},
                            Unit{"_per_s", "1/s"},
                            Unit{"_per_m", "1/m"},
                            Unit{"_rad_s2", "rad/s^2"},
                            Unit{"_rad_s", "rad/s"},
                            Unit{"_deg_s", "deg/s"},
                            Unit{"_m_s2", "m/s^2"},
                            Unit{"_m_s", "m/s"},
                            Unit{"_counts", "counts"},
                            Unit{"_percent", "%"},
                            Unit{"_ppm", "ppm"},
                            Unit{"_rad", "rad"},
                            Unit{"_deg", "deg"},
                            Unit{"_kg", "kg"},
                            Unit{"_hz", "Hz"},
                            Unit{"_s", "s"},
                            Unit{"_m", "m"}};

std::string unit_of(std::string_view key) {
  for (const Unit& unit : kUnits) {
    if (key.ends_with(unit.ending)) {
      return std::string(unit.unit);
    }
  }
  return "-";
}

std::string text(double value) {
  std::array<char, 32> buffer{};
  const std::to_chars_result end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 6);
  return {buffer.data(), end.ptr};
}

std::string range(double low, double high) { return text(low) + " to " + text(high); }

template <typename T>
void add(Table& table, const std::string& section, std::span<const NumberKey<T>> keys, const T& defaults) {
  for (const NumberKey<T>& key : keys) {
    table.rows.push_back(
        {section, std::string(key.key), {unit_of(key.key), range(key.low, key.high), text(defaults.*key.member)}});
  }
}

/// Adds the keys of an axis of a vehicle file. Their defaults are those of an axis that is not identified.
void add_axis(Table& table, const std::string& section, model::AxisUnit unit) {
  add<model::StickAxis>(table, section, companion::axis_keys(unit), model::StickAxis{});
  table.rows.push_back({section, "dead_zone_shape", {"text", "\"continuous\" or \"jump\"", "\"continuous\""}});
}

/// Checks that every section of a written vehicle file is in the table.
void expect_sections(const Table& table) {
  std::istringstream written(companion::to_text(mpc::generated::kVehicle, {}));
  for (std::string line; std::getline(written, line);) {
    const bool known = std::any_of(table.rows.begin(), table.rows.end(),
                                   [&](const Row& row) { return row.section.find(line) != std::string::npos; });
    const bool repeats = line.starts_with("[design.");  // the keys of [axis.*], [mpc] and [estimator]
    if (line.starts_with("[") && !known && !repeats) {
      throw std::logic_error("reference: a vehicle file has the section " + line + ", which is not listed");
    }
  }
}

Table vehicle_table() {
  Table table{"vehicle_keys", {"unit", "range", "default"}, {}};
  const model::Vehicle vehicle;
  add_axis(table, "[axis.roll] and [axis.pitch]", model::AxisUnit::kTilt_rad);
  add_axis(table, "[axis.yaw_rate]", model::AxisUnit::kYawRate_rad_s);
  add_axis(table, "[axis.climb]", model::AxisUnit::kClimb_m_s);
  add<model::Translation>(table, "[translation]", companion::translation_keys(), vehicle.translation);
  add<model::MpcWeights>(table, "[mpc]", companion::mpc_keys(), vehicle.mpc);
  add<model::EstimatorNoise>(table, "[estimator]", companion::estimator_keys(), vehicle.estimator);
  table.rows.push_back({"[altitude]", "design", {"-", "true or false", "true"}});
  add<model::AltitudeGains>(table, "[altitude]", companion::altitude_keys(), vehicle.altitude);
  add<model::YawGain>(table, "[yaw]", companion::yaw_keys(), vehicle.yaw);
  table.rows.push_back({"every section", "source", {"text", "any", "-"}});
  expect_sections(table);
  return table;
}

Table flight_table() {
  Table table{"flight_keys", {"unit", "range", "default"}, {}};
  const companion::FlightFile defaults;
  for (const companion::FlightKey& key : companion::flight_keys()) {
    const std::string section = key.section.empty() ? "top of the file" : "[" + std::string(key.section) + "]";
    std::vector<std::string> cells{unit_of(key.key), range(key.low, key.high), "-"};
    if (const auto* mode = std::get_if<companion::Mode companion::FlightFile::*>(&key.member)) {
      cells = {"text", "\"field\" or \"robust\"", "\"" + std::string(name(defaults.**mode)) + "\""};
    } else if (std::holds_alternative<link::SenderChoice companion::FlightFile::*>(key.member)) {
      cells = {"text", "\"SYSTEM\" or \"SYSTEM:COMPONENT\"", "-"};
    } else if (std::holds_alternative<link::LeverArm companion::FlightFile::*>(key.member)) {
      cells[1] = "three numbers, " + cells[1];
    } else if (std::holds_alternative<companion::Range companion::FlightFile::*>(key.member)) {
      cells[1] = "two numbers, " + cells[1];
    } else if (const double value = defaults.*std::get<double companion::FlightFile::*>(key.member);
               value != 0.0 || key.low <= 0.0) {
      cells[2] = text(value);
    }
    cells[2] = key.required ? "must be there" : cells[2];
    table.rows.push_back({section, std::string(key.key), cells});
  }
  return table;
}

template <typename T, std::size_t kCount>
std::string one_of(const std::array<companion::NamedValue<T>, kCount>& words) {
  std::string out;
  for (const companion::NamedValue<T>& word : words) {
    out += (out.empty() ? "\"" : " or \"") + std::string(word.word) + "\"";
  }
  return out;
}

Table plant_table() {
  Table table{"plant_keys", {"unit", "range", "default"}, {}};
  const sim::Plant plant = sim::measured_plant();
  add<sim::Air>(table, "[air]", sim::air_keys(), plant.air);
  table.rows.push_back({"[air]", "wind_m_s", {"m/s", "three numbers, -40 to 40", "0, 0, 0"}});
  add<sim::Payload>(table, "[payload]", sim::kPayloadKeys, plant.payload);
  add<sim::PoseNumbers>(table, "[pose]", sim::kPoseKeys, plant.pose);
  table.rows.push_back({"[pose]", "phase", {"text", one_of(sim::kPhases), "\"random\""}});
  table.rows.push_back({"[pose]", "reported_age", {"text", one_of(sim::kReportedAges), "\"true\""}});
  add<sim::Sensors>(table, "[sensors]", sim::kSensorKeys, plant.sensors);
  for (const sim::KeyAlias& name : sim::kPoseKeyAliases) {
    table.rows.push_back(
        {"[sensors]", std::string(name.old), {unit_of(name.old), "as pose." + std::string(name.key), "-"}});
  }
  add<sim::Link>(table, "[link]", sim::kLinkKeys, plant.link);
  add<sim::Battery>(table, "[battery]", sim::kBatteryKeys, plant.battery);
  add<sim::AutopilotNumbers>(table, "[autopilot]", sim::kAutopilotKeys, plant.autopilot);
  add<sim::Plant>(table, "[vehicle]", sim::kVehicleKeys, plant);
  table.rows.push_back({"[change]", "at_s", {"s", "0 to 1e+06", "must be there"}});
  return table;
}

Table course_table() {
  Table table{"course_words", {"takes"}, {}};
  for (const companion::CourseWord& word : companion::kCourseWords) {
    table.rows.push_back({"words", std::string(word.word), {std::string(word.arguments)}});
  }
  return table;
}

std::string takes(const sim::N1EventSyntax& form) {
  if (form.words.empty()) {
    return form.low == form.high ? "nothing"
                                 : (form.whole ? "a whole number, " : "a number, ") + range(form.low, form.high);
  }
  std::string out;
  for (const sim::N1NamedValue& word : form.words) {
    out += (out.empty() ? "" : " or ") + std::string(word.text);
  }
  return out;
}

Table script_table() {
  Table table{"script_words", {"takes"}, {}};
  for (const sim::N1EventSyntax& form : sim::kN1Events) {
    table.rows.push_back({"what happens", std::string(form.name), {takes(form)}});
  }
  for (const sim::N1StickShapeName& word : sim::kN1StickShapes) {
    const bool chirp = word.shape == sim::N1StickMove::Shape::kChirp;
    table.rows.push_back({"what the pilot does",
                          std::string(word.name),
                          {chirp ? "STICK COUNTS FROM_HZ TO_HZ SECONDS" : "STICK COUNTS SECONDS"}});
  }
  for (const sim::SensorFault& fault : sim::sensor_faults()) {
    table.rows.push_back({"a sensor fault, and its size",
                          std::string(sim::kN1FaultWord) + " " + std::string(fault.name),
                          {fault.unit.empty() ? "-" : "[" + std::string(fault.unit) + "]"}});
  }
  for (const std::string_view stick : sim::kN1StickNames) {
    table.rows.push_back({"names of a STICK", std::string(stick), {"-"}});
  }
  for (const sim::N1RequestName& word : sim::kN1RequestNames) {
    table.rows.push_back({"commands that lose_acks can name", std::string(word.text), {"-"}});
  }
  return table;
}

Table signal_table() {
  Table table{"column_keys", {"turned for ned_frd"}, {}};
  for (std::size_t i = 0; i < logs::kSignals; ++i) {
    const bool turned = logs::sign_in_ned_frd(static_cast<logs::Signal>(i)) < 0.0;
    table.rows.push_back({"[signals]", std::string(logs::kSignalNames[i]), {turned ? "yes" : "no"}});
  }
  return table;
}

/// The keys of every file and the words of every script that the programs read, from the tables with which they read
/// them. Throws std::logic_error if a written vehicle file has a section that is not listed here.
std::vector<Table> tables() {
  return {vehicle_table(), flight_table(), plant_table(), course_table(), script_table(), signal_table()};
}

/// All pages: the words of meanings.toml, joined to the tables. A key that has no meaning gets an empty one.
Json all_pages() {
  Json pages;
  for (const auto& [name, text] : page_texts()) {
    pages[name] = Json::parse(text);
  }
  for (const Table& table : tables()) {
    pages[table.page]["columns"] = table.columns;
    for (const Row& row : table.rows) {
      pages[table.page]["rows"].push_back({{"section", row.section}, {"key", row.key}, {"cells", row.cells}});
    }
  }
  for (Json& page : pages) {
    for (Json& row : page["rows"]) {
      row["meaning"] = page["meanings"][row["section"].get<std::string>()].value(row["key"].get<std::string>(), "");
    }
    page.erase("meanings");
  }
  return pages;
}

void print_line(const std::vector<std::string>& cells) {
  for (const std::string& cell : cells) {
    std::cout << "| ";
    for (const char c : cell) {
      std::cout << (c == '|' ? "\\" : "") << c;
    }
    std::cout << " ";
  }
  std::cout << "|\n";
}

/// Prints rows of one section as a Markdown table. A column that has only "-" in it is left out.
void print_table(const Json& columns, const std::vector<Json>& rows) {
  std::vector<std::vector<std::string>> lines(rows.size() + 1);
  const auto add = [&](const std::string& title, const auto& cell_of) {
    lines[0].push_back(title);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      lines[i + 1].push_back(cell_of(rows[i]));
    }
  };
  add("key", [](const Json& row) { return "`" + row["key"].get<std::string>() + "`"; });
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (std::any_of(rows.begin(), rows.end(), [i](const Json& row) { return row["cells"][i] != "-"; })) {
      add(columns[i].get<std::string>(), [i](const Json& row) { return row["cells"][i].get<std::string>(); });
    }
  }
  add("meaning", [](const Json& row) { return row["meaning"].get<std::string>(); });
  lines.insert(lines.begin() + 1, std::vector<std::string>(lines[0].size(), "---"));
  std::for_each(lines.begin(), lines.end(), print_line);
}

void print_page(const Json& page) {
  std::cout << "# " << page["title"].get<std::string>() << "\n\n" << page["introduction"].get<std::string>() << "\n";
  const Json& rows = page["rows"];
  for (auto first = rows.begin(), end = first; first != rows.end(); first = end) {
    end = std::find_if(first, rows.end(), [&](const Json& row) { return row["section"] != (*first)["section"]; });
    std::cout << "\n## " << (*first)["section"].get<std::string>() << "\n\n";
    print_table(page["columns"], {first, end});
  }
}

}  // namespace
}  // namespace reference

void add_reference(companion::CommandLine& lab) {
  const companion::Subcommand command = lab.add_subcommand(
      "reference", "print every key, word, message and exit code of the programs, with range, default and meaning");
  const auto page = std::make_shared<std::string>();
  std::vector<std::string> names;
  for (const auto& [name, text] : reference::page_texts()) {
    names.push_back(name);
  }
  command.add_option("page", *page, "page to print as Markdown; without it, all pages as JSON").one_of(names);
  command.callback([page] {
    const Json pages = reference::all_pages();
    if (page->empty()) {
      std::cout << pages.dump(1) << "\n";
    } else {
      reference::print_page(pages[*page]);
    }
  });
}

}  // namespace m100::lab
