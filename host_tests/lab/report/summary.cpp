// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/report/summary.h"

#include <algorithm>
#include <array>
#include <limits>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/plot/charts.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab::report {
namespace {

/// Smaller growth of a prediction error is ignored: the choice of seeds alone changes it as much. Flown errors are
/// judged by the loop's pairs of flights.
constexpr double kNoticed = 1.02;

Json read(const std::string& file) {
  if (file.empty()) {
    return Json::object();
  }
  Json out = Json::parse(whole_file(file));
  if (!out.is_object()) {
    throw InputError(file, 0, "", "is not a result of m100-lab");
  }
  return out.sorted();  // the page lists what a file holds in this order
}

std::string spaced(std::string name) {
  for (char& letter : name) {
    letter = letter == '_' ? ' ' : letter;
  }
  return name;
}

const char* unit_of(const std::string& axis) {
  return axis == "climb" ? "m/s" : axis == "yaw_rate" ? "rad/s" : axis == "translation" ? "m/s^2" : "rad";
}

/// The value at a path ("/final/validation_rmse"); null if there is none.
Json value_at(const Json& from, std::string_view path) {
  const std::size_t end = std::min(path.find('/', 1), path.size());
  return path.empty()       ? from
         : from.is_object() ? value_at(from.value(path.substr(1, end - 1), Json()), path.substr(end))
                            : Json();
}

/// The number at a path; negative if there is none.
double number_at(const Json& from, const std::string& path) {
  const Json value = value_at(from, path);
  return value.is_number() ? value.get<double>() : -1.0;
}

/// Builds the first screen: rows with the errors before and after, and the goals that were not reached.
class Summary {
 public:
  explicit Summary(const Sources& sources) : sources_(sources) {
    for (const std::string& file : sources.identified) {
      identified_.push_back(read(file));
    }
    experiments_ = read(sources.experiments);
    loop_ = read(sources.loop);
    margins_ = read(sources.margins);
  }

  void write(plot::Page& page) {
    constexpr const char* kNone = "is not a result of m100-lab";
    for (std::size_t i = 0; i < identified_.size(); ++i) {
      of_json(sources_.identified[i], kNone, [&] { identified(identified_[i]); });
    }
    of_json(sources_.loop, kNone, [&] {
      loop_predictions();
      loop_flights();
    });
    of_json(sources_.experiments, kNone, [&] { paper(); });
    of_json(sources_.margins, kNone, [&] {
      for (const char* const loops : {"flown", "height", "yaw"}) {
        margins(margins_.value(loops, Json::object()), loops);
      }
    });
    page.begin_answer({{"Refused", refused_},
                       {"Asked", sources_.asked},
                       {"Missing in the model", found_},
                       {"What it explains" + (sources_.origin.empty() ? "" : " (" + sources_.origin + ")"), explained_},
                       {"What it changed in flight (simulated)", flown_},
                       {"What remains", missed_.empty() ? "every goal was reached."
                                                        : std::to_string(missed_.size()) +
                                                              (missed_.size() == 1 ? " goal was" : " goals were") +
                                                              " not reached: " + plot::joined(missed_, "; ") + "."}},
                      !refused_.empty() ? "bad"
                      : missed_.empty() ? "good"
                                        : "warn");
    if (!bars_.bars.empty()) {
      page.figure(bars_, "Orange: before; blue: after. In per cent of the error before.");
    }
    page.end_answer();
    page.table(rows_, marked_);
    page.paragraph(
        "Rows 'log': prediction error on the part of the log that no fit has used, with the declared model (before) "
        "and with the effects found (after). Rows 'loop': prediction error 1 s ahead for a simulated aircraft with "
        "hidden effects, with the vehicle file before and after they were identified. Rows 'flown': pose error in the "
        "tasks that this aircraft flew with both files.");
  }

 private:
  /// @param growth  the error after is marked if it is more than this times the error before
  void row(const std::string& what, double before, double after, const std::string& data = "simulated",
           double growth = kNoticed) {
    if (before < 0.0 || after < 0.0) {
      return;
    }
    if (after > growth * before) {
      marked_.insert({rows_.size(), 2});
      missed_.push_back(what + " became larger: " + plot::number(before) + " before, " + plot::number(after) +
                        " after");
    }
    const std::string change = before > 0.0 ? plot::percent(after / before - 1.0) : "";
    rows_.push_back({what, plot::number(before), plot::number(after), change, data.empty() ? "-" : data});
    if (before > 0.0) {
      bars_.bars.push_back({.label = what, .value = 100.0, .note = plot::number(before), .color = plot::kOrange});
      bars_.bars.push_back({.label = "",
                            .value = 100.0 * after / before,
                            .note = plot::number(after) + " (" + change + ")",
                            .color = plot::kBlue});
    }
  }

  void identified(const Json& one) {
    const std::string axis = one.value("axis", "");
    std::string names;
    for (const Json& effect : one.value("effects", Json::array())) {
      names += (names.empty() ? "" : ", ") + spaced(effect.value("name", ""));
    }
    const bool unexplained = one.value("verdict", "") == "unexplained";
    names = !names.empty() ? names : unexplained ? "an effect that could not be named" : "nothing";
    found_ += (found_.empty() ? "" : "; ") + spaced(axis) + ": " + names;
    for (const Json& finding : one.value("findings", Json::array())) {
      if (finding.value("certain", true) && std::ranges::count(identify::kMisreadings, finding.value("what", "")) > 0) {
        refused_ += (refused_.empty() ? "not fit to fly, because the log is misread: " : "; ") + spaced(axis) + ": " +
                    finding.value("text", "");
      }
    }
    const double before = number_at(one, "/declared/validation_rmse");
    const double after = number_at(one, "/final/validation_rmse");
    if (before > 0.0 && after >= 0.0) {
      explained_ += (explained_.empty() ? "" : "; ") + spaced(axis) + ": " + plot::number(before) + " to " +
                    plot::number(after) + " " + unit_of(axis) + " (" + plot::percent(after / before - 1.0) + ")";
    }
    row("log: " + spaced(axis) + " [" + unit_of(axis) + "]", before, after, sources_.origin);
    row("log: position 1 s ahead, from the sticks [m]", number_at(one, "/declared/position_rmse/1.0"),
        number_at(one, "/final/position_rmse/1.0"), sources_.origin);
    if (unexplained) {
      missed_.push_back(spaced(axis) + ": no known effect explains a part of the log's error");
    }
  }

  void loop_predictions() {
    constexpr std::array<std::array<const char*, 2>, 5> kQuantities{{{"roll_rad", "roll [rad]"},
                                                                     {"pitch_rad", "pitch [rad]"},
                                                                     {"velocity_m_s", "velocity [m/s]"},
                                                                     {"climb_m_s", "climb [m/s]"},
                                                                     {"yaw_rate_rad_s", "yaw rate [rad/s]"}}};
    for (const auto& [key, words] : kQuantities) {
      const std::string path = std::string("/prediction_1s/") + key;
      row(std::string("loop: ") + words, number_at(loop_, "/before" + path), number_at(loop_, "/after" + path));
    }
  }

  void loop_flights() {
    const Json before = value_at(loop_, "/before/experiments");
    for (const auto& [task, airs] : before.items()) {
      if (!airs.is_object()) {
        continue;
      }
      for (const auto& [air, cell] : airs.items()) {
        const std::string path = "/" + task + "/" + air + "/pose_m";
        const double was = number_at(before, path);
        const double is = number_at(loop_, "/after/experiments" + path);
        const auto is_worse = [&, name = task](const char* part) {
          return value_at(loop_, "/paired/" + name + part + "/verdict") == "worse";
        };
        row("flown: " + spaced(task) + ", " + air + " [m]", was, is, "simulated",
            is_worse("/horizontal") || is_worse("/vertical") ? 1.0 : std::numeric_limits<double>::infinity());
        if (was > 0.0 && is >= 0.0) {
          flown_ += spaced(task) + ", " + air + ": " + plot::number(was) + " to " + plot::number(is) + " m (" +
                    plot::percent(is / was - 1.0) + "); ";
        }
      }
    }
  }

  /// Counts the cells that the paper's table has, and those in which our error is above the paper's.
  void paper() {
    for (const auto& [task, airs] : experiments_.items()) {
      if (!airs.is_object()) {
        continue;
      }
      for (const auto& [air, cell] : airs.items()) {
        cells_ += cell.value("compared", 0);
        const auto above = cell.value("above_paper", std::vector<std::string>());
        for (const std::string& key : above) {
          ++above_;
          missed_.push_back(spaced(task) + ", " + air + ": " + key + " is " + plot::number(number_at(cell, "/" + key)) +
                            " (simulated), the paper measured " + plot::number(number_at(cell, "/paper/" + key)));
        }
      }
    }
    if (cells_ > 0) {
      flown_ += std::to_string(cells_ - above_) + " of " + std::to_string(cells_) +
                " errors of the paper's tasks are at or below those that the paper measured";
    }
  }

  /// Adds the unstable loops in `of` to the missed goals: each channel, and with --corners the worst of corners and
  /// box.
  void margins(const Json& of, const std::string& name) {
    if (!of.value("stable", true)) {
      missed_.push_back("a stable loop: " + name);
    }
    for (const auto& [key, inner] : of.items()) {
      if (inner.is_object()) {
        margins(inner, name + (name.empty() ? "" : ", ") + key);
      }
    }
  }

  const Sources& sources_;
  std::vector<Json> identified_;
  Json experiments_;
  Json loop_;
  Json margins_;
  std::string found_, refused_, explained_;
  std::string flown_;  ///< on the flights of the loop's aircraft, and on those of the paper's tasks
  plot::BarChart bars_{.title = "Root mean square error before and after", .x_label = ""};
  std::vector<std::vector<std::string>> rows_{{"root mean square error", "before", "after", "change", "data"}};
  plot::Cells marked_;
  std::vector<std::string> missed_;
  int cells_ = 0;
  int above_ = 0;
};

}  // namespace

void summarise(const Sources& sources, plot::Page& page) { Summary(sources).write(page); }

}  // namespace m100::lab::report
